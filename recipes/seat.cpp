#include "recipes/seat.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <set>
#include <tuple>

#include "config/upright.hpp"
#include "recipes/on_board.hpp"
#include "recipes/parts_apart.hpp"

namespace gantry::recipes {
namespace {

using config::in_one_another;
using config::Mistakes;
using config::Upright;

constexpr double kSlack_mm = 1e-6;

struct Rectangle {
  Vec2 low{1e9, 1e9}, high{-1e9, -1e9};
  void add(Vec2 p) {
    low = {std::min(low.x, p.x), std::min(low.y, p.y)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y)};
  }
};

/// Of a body seen from above.
Rectangle outline(const config::Body& body) {
  Rectangle r;
  const Vec2 half{body.shape.size.x / 2, body.shape.size.y / 2};
  for (const Vec2 corner : std::array{Vec2{half.x, half.y}, Vec2{-half.x, half.y}, Vec2{half.x, -half.y}, half * -1})
    r.add(Vec2{body.centre.x, body.centre.y} + rotated(corner, body.rotation_rad));
  return r;
}

std::string corners_in_words(const Rectangle& r) {
  return fmt::format("from ({:.6g}, {:.6g}) to ({:.6g}, {:.6g}) mm", r.low.x, r.low.y, r.high.x, r.high.y);
}

/// Where the board's place was written: its 'at', or else its frame.
Location location_of(const Board& board) {
  return board.locations.at.line > 0 ? board.locations.at : board.frame_location;
}

/// What stands under the board, and ends at the height of its underside, carries it; it lies in no other body.
bool board_on_its_seat(const Recipe& recipe, const config::Machine& machine, Mistakes& mistakes) {
  constexpr double kSameHeight_mm = 1, kOverhang_mm = 0.5, kContact_mm = 0.1;
  const Vec3 origin = config::find_frame(machine, recipe.board.frame)->origin;
  Rectangle board;
  board.add(Vec2{origin.x, origin.y} + recipe.board.at);
  board.add(Vec2{origin.x, origin.y} + recipe.board.at + recipe.board.size);
  const Upright itself{.centre = (board.low + board.high) * 0.5,
                       .half = recipe.board.size * 0.5,
                       .low = origin.z,
                       .high = origin.z + recipe.board.thickness};
  Rectangle seat;
  std::string names, beside;
  for (const config::Body& body : machine.scene) {
    const Rectangle r = outline(body);
    const double top = body.centre.z + body.shape.size.z / 2;
    const bool apart =
        r.high.x <= board.low.x || r.low.x >= board.high.x || r.high.y <= board.low.y || r.low.y >= board.high.y;
    const bool ends_there = std::abs(top - origin.z) <= kSameHeight_mm;
    if (!ends_there && in_one_another(itself, config::upright(body), kContact_mm)) {
      mistakes.add(
          Fault::Inconsistent,
          fmt::format("the board lies in '{}' of the machine's scene: it takes {} and z {:.6g} to {:.6g} mm, "
                      "that body {} and z {:.6g} to {:.6g} mm; correct the board's placement 'at', or the origin "
                      "of frame '{}' in the machine file",
                      body.name, corners_in_words(board), itself.low, itself.high, corners_in_words(r),
                      top - body.shape.size.z, top, recipe.board.frame),
          location_of(recipe.board));
      return false;
    }
    if (!ends_there) continue;
    if (apart) {
      if (beside.empty()) beside = fmt::format("; '{}' ends there, {}", body.name, corners_in_words(r));
      continue;
    }
    seat.add(r.low), seat.add(r.high);
    names += (names.empty() ? "'" : ", '") + body.name + "'";
  }
  if (names.empty()) {
    if (machine.scene.empty()) return true;  // nothing of this machine is known
    mistakes.add(Fault::OutOfRange,
                 fmt::format("nothing carries the board: it lies {} of the machine with its underside at z {:.6g} mm, "
                             "and no body of the scene is under it and ends there{}; correct its place 'at' or its "
                             "'frame', or write what carries it under 'scene' in the machine file",
                             corners_in_words(board), origin.z, beside),
                 location_of(recipe.board));
    return false;
  }
  if (board.low.x >= seat.low.x - kOverhang_mm && board.high.x <= seat.high.x + kOverhang_mm &&
      board.low.y >= seat.low.y - kOverhang_mm && board.high.y <= seat.high.y + kOverhang_mm)
    return true;
  const Vec2 room = seat.high - seat.low;
  const bool too_large =
      recipe.board.size.x > room.x + 2 * kOverhang_mm || recipe.board.size.y > room.y + 2 * kOverhang_mm;
  mistakes.add(
      Fault::OutOfRange,
      fmt::format("the board of {:.6g} x {:.6g} mm does not fit on {}: it lies from ({:.6g}, {:.6g}) to "
                  "({:.6g}, {:.6g}) mm of the machine, and is carried from ({:.6g}, {:.6g}) to ({:.6g}, "
                  "{:.6g}) mm; correct its {}",
                  recipe.board.size.x, recipe.board.size.y, names, board.low.x, board.low.y, board.high.x, board.high.y,
                  seat.low.x, seat.low.y, seat.high.x, seat.high.y, too_large ? "'size'" : "place 'at', or its 'size'"),
      too_large && recipe.board.locations.size.line > 0 ? recipe.board.locations.size : location_of(recipe.board));
  return false;
}

/// Marks that lie close together leave the rotation open.
void marks_apart(const Recipe& recipe, Mistakes& mistakes) {
  constexpr double kSpread = 0.1;  // of the board's diagonal; nearer, an error of a mark is ten times one at a corner
  double widest = 0;
  for (std::size_t i = 0; i < recipe.marks.size(); ++i)
    for (std::size_t k = 0; k < i; ++k) widest = std::max(widest, norm(recipe.marks[k].at - recipe.marks[i].at));
  const double needed = kSpread * norm(recipe.board.size);
  if (recipe.marks.size() < 2 || widest >= needed) return;
  mistakes.add(
      Fault::Inconsistent,
      fmt::format("the marks lie within {:.6g} mm, which does not fix the board's rotation; put two of them at "
                  "least {:.6g} mm apart",
                  widest, needed),
      recipe.marks.back().location);
}

/// Surely beside: seen from above, circles about both do not meet.
bool far_apart(const Part& part, Vec2 middle, double reach) {
  return norm(part.at - middle) > reach + norm(Vec2{part.size.x / 2, part.size.y / 2}) + kSlack_mm;
}

/// Whether a stretch from above goes over a part.
bool crosses(const Part& part, Vec2 from, Vec2 to) {
  const Vec2 a = rotated(from - part.at, -part.rotation), b = rotated(to - part.at, -part.rotation);
  double enter = 0, leave = 1;  // Liang and Barsky 1984
  for (const auto& [start, end, half] :
       {std::tuple{a.x, b.x, part.size.x / 2}, std::tuple{a.y, b.y, part.size.y / 2}}) {
    const double whole = end - start;
    if (std::abs(whole) < kSlack_mm) {
      if (std::abs(start) >= half - kSlack_mm) return false;
      continue;
    }
    const double t1 = (-half - start) / whole, t2 = (half - start) / whole;
    enter = std::max(enter, std::min(t1, t2)), leave = std::min(leave, std::max(t1, t2));
  }
  return enter < leave - kSlack_mm || (enter <= leave && from == to);
}

/// One piece of work on the board: a feature, a touch, a mark. An array is one line of the recipe and told once.
class Work {
 public:
  Work(const Recipe& recipe, Mistakes& mistakes) : recipe_(recipe), mistakes_(mistakes) {}

  void off_the_margin(Vec2 at, double radius, Location location, std::string_view what) {
    const double keep = recipe_.board.clamp_margin + radius;
    const Vec2 size = recipe_.board.size;
    if (recipe_.board.clamp_margin <= 0) return;
    looked_at_.insert({location.line, location.column});
    if (at.x >= keep - kSlack_mm && at.y >= keep - kSlack_mm && at.x <= size.x - keep + kSlack_mm &&
        at.y <= size.y - keep + kSlack_mm)
      return;
    if (!in_margin_.insert({location.line, location.column}).second) return;
    margin_.push_back(
        {location, fmt::format("{} at ({:.6g}, {:.6g}) mm lies in the {:.6g} mm at the board's edges that "
                               "'clamp_margin' keeps for the fixture; move it inwards",
                               what, at.x, at.y, recipe_.board.clamp_margin)});
  }

  /// What lies in the margin, each at its place; where that is most of the work, the margin is the mistake.
  void tell_margin() {
    constexpr std::size_t kFew = 3;
    const Location written = recipe_.board.locations.clamp_margin;
    if (written.line > 0 && margin_.size() >= kFew && 3 * margin_.size() > 2 * looked_at_.size())
      return tell(Fault::OutOfRange, written,
                  fmt::format("{} of {} marks, touches and features lie in the {:.6g} mm at the board's edges that "
                              "'clamp_margin' keeps for the fixture; write less",
                              margin_.size(), looked_at_.size(), recipe_.board.clamp_margin));
    for (auto& [location, words] : margin_)
      if (!told(location)) tell(Fault::OutOfRange, location, std::move(words));
  }

  /// `on`: the part that it is meant to lie on, of what may lie on one; null: of a touch, which reads the board.
  void off_the_parts(Vec2 from, Vec2 to, const std::string* on, Location location, std::string_view what) {
    const Vec2 middle = (from + to) * 0.5;
    const double reach = norm(to - from) / 2;
    for (const Part& part : recipe_.parts) {
      if (part.fixture || far_apart(part, middle, reach) || (on != nullptr && part.name == *on) ||
          !crosses(part, from, to) || told(location))
        continue;
      tell(Fault::Inconsistent, location,
           on == nullptr ? fmt::format("{} is on part '{}', and the board's surface is what it has to find; move it",
                                       what, part.name)
                         : fmt::format("{} goes through part '{}'; move it, or write `on: {}` where it is meant to lie "
                                       "on that part",
                                       what, part.name, part.name));
    }
  }

 private:
  [[nodiscard]] bool told(Location location) const { return told_.count({location.line, location.column}) > 0; }
  void tell(Fault fault, Location location, std::string words) {
    told_.insert({location.line, location.column});
    mistakes_.add(fault, std::move(words), location);
  }

  const Recipe& recipe_;
  Mistakes& mistakes_;
  std::set<std::pair<int, int>> told_, looked_at_, in_margin_;
  std::vector<std::pair<Location, std::string>> margin_;
};

void feature(Work& work, const Dot& dot) {
  const std::string what = fmt::format("dot '{}'", dot.id);
  if (!dot.off_board) work.off_the_margin(dot.at, 0, dot.location, what);
  work.off_the_parts(dot.at, dot.at, &dot.on, dot.location, what);
}

void feature(Work& work, const Bead& bead) {
  const std::string what = fmt::format("bead '{}'", bead.id);
  for (std::size_t i = 0; i < bead.points.size(); ++i) {
    const Vec2 at = flat(bead.points[i]);
    if (!bead.off_board) work.off_the_margin(at, 0, bead.location, what);
    if (i > 0) work.off_the_parts(flat(bead.points[i - 1]), at, &bead.on, bead.location, what);
  }
}

/// False, and a mistake, when it is not.
bool whole_on_board(const Recipe& recipe, const MarkDef& m, Mistakes& mistakes) {
  const Vec2 size = recipe.board.size;
  const double radius = m.diameter / 2;
  const double edge = std::min({m.at.x, m.at.y, size.x - m.at.x, size.y - m.at.y});
  if (size.x <= 0 || edge >= radius - 1e-9) return true;
  mistakes.add(Fault::OutOfRange,
               fmt::format("mark '{}' of {:.6g} mm reaches over the board's edge, which is {:.6g} mm from its centre; "
                           "move it inwards to {:.6g} mm",
                           m.name, m.diameter, edge, std::max(radius, recipe.board.clamp_margin + radius)),
               m.location);
  return false;
}

/// False, and a mistake, when it leaves no room for any work.
bool margin_leaves_room(const Board& board, Mistakes& mistakes) {
  const double edge = std::min(board.size.x, board.size.y);
  if (2 * board.clamp_margin < edge) return true;
  mistakes.add(
      Fault::OutOfRange,
      fmt::format("a 'clamp_margin' of {:.6g} mm at every edge leaves nothing of a board of {:.6g} x {:.6g} mm; "
                  "write less than {:.6g} mm",
                  board.clamp_margin, board.size.x, board.size.y, edge / 2),
      board.locations.clamp_margin.line > 0 ? board.locations.clamp_margin : board.frame_location);
  return false;
}

/// With the board in its nominal placement: from the board's origin, z from its underside.
Upright upright(const Part& part, const Board& board) {
  const double low = part.fixture ? part.underside : board.thickness;
  return {.centre = part.at,
          .half = {part.size.x / 2, part.size.y / 2},
          .rotation_rad = part.rotation,
          .low = low,
          .high = low + part.size.z};
}

/// A clamp may reach onto the board and down its side; none is wholly inside it, or in a part.
void fixture_beside_all(const Recipe& recipe, const Part& clamp, Mistakes& mistakes) {
  constexpr double kContact_mm = 0.01;
  const Upright itself = upright(clamp, recipe.board);
  const Vec2 size = recipe.board.size;
  bool inside = size.x > 0 && itself.high < recipe.board.thickness - kContact_mm;
  for (const Vec2 corner : {Vec2{1, 1}, Vec2{-1, 1}, Vec2{1, -1}, Vec2{-1, -1}})
    inside = inside && on_board(recipe.board, clamp.at + rotated({corner.x * itself.half.x, corner.y * itself.half.y},
                                                                 clamp.rotation));
  if (inside)
    mistakes.add(Fault::Inconsistent,
                 fmt::format("fixture '{}' is inside the board: it ends {:.6g} mm over the frame's origin, and the "
                             "board's top face is at {:.6g} mm; correct its 'at', 'size' or 'z'",
                             clamp.name, itself.high, recipe.board.thickness),
                 clamp.location);
  for (const Part& part : recipe.parts)
    if (!part.fixture && !far_apart(part, clamp.at, norm(itself.half)) &&
        in_one_another(itself, upright(part, recipe.board), kContact_mm))
      mistakes.add(Fault::Inconsistent,
                   fmt::format("fixture '{}' stands in part '{}', from z {:.6g} to {:.6g} mm over the frame's origin; "
                               "correct the 'at', 'size' or 'z' of one of them",
                               clamp.name, part.name, itself.low, itself.high),
                   clamp.location);
}

}  // namespace

bool check_seat(const Recipe& recipe, const config::Machine& machine, Mistakes& mistakes) {
  if (!board_on_its_seat(recipe, machine, mistakes)) return false;
  marks_apart(recipe, mistakes);
  check_parts_apart(recipe, mistakes);
  for (const Part& part : recipe.parts)
    if (part.fixture) fixture_beside_all(recipe, part, mistakes);
  const bool room = margin_leaves_room(recipe.board, mistakes);
  Work work(recipe, mistakes);
  for (const MarkDef& m : recipe.marks)
    if (whole_on_board(recipe, m, mistakes))
      work.off_the_margin(m.at, m.diameter / 2, m.location, fmt::format("mark '{}'", m.name));
  for (const TouchPoint& t : recipe.touches) {
    work.off_the_margin(t.at, 0, t.location, fmt::format("touch '{}'", t.name));
    work.off_the_parts(t.at, t.at, nullptr, t.location, fmt::format("touch '{}'", t.name));
  }
  for (const Feature& each : recipe.features) std::visit([&](const auto& f) { feature(work, f); }, each);
  if (const auto& purge = recipe.purge; purge && purge->frame.empty() && on_board(recipe.board, flat(purge->at)))
    work.off_the_margin(flat(purge->at), 0, purge->at_location, "the purge");
  if (room) work.tell_margin();
  return true;
}

void check_tools(const Recipe& recipe, const config::Machine& machine, Mistakes& mistakes) {
  const auto wants = [&](bool there, std::string_view what, std::string_view why, Location location) {
    if (!there)
      mistakes.add(Fault::UnknownReference,
                   fmt::format("machine '{}' has no {}, without which {}", machine.name, what, why), location);
  };
  const auto has = [&](std::string_view tool) { return config::find_tool(machine, tool) != nullptr; };
  const config::CameraConfig& camera = machine.camera;
  if (!recipe.marks.empty()) {
    wants(has("camera"), "tool 'camera'", "no mark is seen", recipe.marks.front().location);
    wants(camera.width_px > 0 && camera.height_px > 0 && camera.mm_per_px > 0, "'camera' with its pixels",
          "no mark is seen", recipe.marks.front().location);
  }
  if (!recipe.touches.empty()) {
    wants(has("probe"), "tool 'probe'", "no height is touched", recipe.touches.front().location);
    wants(machine.probe.speed_mm_s > 0, "'probe' with its speed", "no height is touched",
          recipe.touches.front().location);
  }
  if (!recipe.features.empty())
    wants(has("needle"), "tool 'needle'", "nothing is dispensed",
          std::visit([](const auto& f) { return f.location; }, recipe.features.front()));
}

}  // namespace gantry::recipes
