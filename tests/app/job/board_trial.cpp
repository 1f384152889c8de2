#include "tests/app/job/board_trial.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <random>
#include <set>

#include "app/job/block_plan.hpp"
#include "app/job/limits.hpp"
#include "app/job/prove_homing.hpp"
#include "app/job/rise.hpp"
#include "app/job/settle.hpp"
#include "app/job/surroundings.hpp"
#include "core/units.hpp"
#include "motion/geometry.hpp"
#include "motion/path/bead.hpp"
#include "motion/path/moves.hpp"
#include "sim/world/collisions.hpp"
#include "tests/motion/plan/prism_distance.hpp"

namespace gantry::test {
namespace {

using config::Body;

constexpr double kAllowed_mm = 1e-6;     // about the clearance, either way
constexpr double kOvertravel_mm = 0.05;  // of the probe behind the surface
constexpr double kProbeStep_mm = 0.02;
constexpr double kMeasured_mm = 1e-4;    // how exactly a rise knows how near bodies stand
constexpr double kPlayedStep_mm = 0.02;  // on a curve
constexpr double kPlayedOff_mm = 0.011;  // chords of the proof and of the judge, off the path together
constexpr double kTickOff_mm = 0.001;    // of a curve from its chord over a tick, here and there
constexpr double kHeights_mm = 0.25;     // between the heights of lift-overs that are tried
constexpr std::size_t kToldMost = 12;

/// A motion that had to be taken, in the judge's words.
struct Leg {
  AxisVec from{}, to{};
  bool straight = false;  ///< no other path would do
  bool riders_grow = true;
  double extra_mm = 0;
  std::vector<std::string> tools{};  ///< that may be near the board
};

struct Pair {
  std::string head, standing;
  auto operator<=>(const Pair&) const = default;
};

class Trial {
 public:
  Trial(const RandomBoard& board, std::uint64_t number, Verdict& verdict)
      : b_(board),
        machine_(b_.machine),
        recipe_(b_.recipe),
        number_(number),
        verdict_(verdict),
        head_(machine_),
        watch_(head_),
        truth_(sim::board_plan(recipe_), config::find_frame(machine_, recipe_.board.frame)->origin, b_.placement),
        planner_(machine_, recipe_, {}, motion::fcl_opinion()),
        random_(number) {
    watch_.set_solids(sim::solids_of(machine_.scene, &truth_));
    for (const auto& [axis, position] : machine_.park) at_[axis.value] = position;
    true_bodies_ =
        bodies_at({b_.placement.shift, b_.placement.rotation_rad}, {b_.placement.z0_mm, b_.placement.slope}, 0, 0, 0);
  }

  void run() {
    ++verdict_.boards;
    for (std::size_t i = 0; i < recipe_.marks.size(); ++i) mark(i);
    settle_marks();
    for (std::size_t i = 0; i < recipe_.touches.size(); ++i) touch(i);
    if (!settle_touches()) return;
    for (std::size_t i = 0; i < recipe_.features.size(); ++i) feature(i);
    all_features();
    for (int i = 0; i < 4; ++i) rise();
    step(planner_.park(++block_, at_), last_line(),
         [&] {
           AxisVec to = at_;
           for (const auto& [axis, position] : machine_.park) to[axis.value] = position;
           return std::vector<Leg>{{.from = at_, .to = to, .tools = {"needle", "probe_stylus"}}};
         },
         {"needle", "probe_stylus"});
  }

 private:
  // ---- bodies, worked out here ----

  [[nodiscard]] std::vector<Body> bodies_at(const recipes::WorkOffset& o, const recipes::Surface& s, double shift,
                                            double turn, double up, bool in_doubt = false) const {
    std::vector<Body> out = machine_.scene;
    const Vec3 origin = config::find_frame(machine_, recipe_.board.frame)->origin;
    const auto on = [&](Vec2 p) { return rotated(p, o.rotation) + o.shift; };
    const auto furthest = [&](Vec2 at, Vec2 size, double rotation) {
      double r = 0;
      for (const double x : {-0.5, 0.5})
        for (const double y : {-0.5, 0.5}) r = std::max(r, norm(at + rotated({x * size.x, y * size.y}, rotation)));
      return shift + 2 * r * std::sin(turn / 2);
    };
    const auto add = [&](const std::string& name, Vec2 at, double low, double high, Vec2 size, double rotation) {
      out.push_back({name,
                     {config::Shape::Kind::Box, {size.x, size.y, high - low}},
                     {origin.x + at.x, origin.y + at.y, origin.z + (low + high) / 2},
                     rotation,
                     false});
    };
    const Vec2 size = recipe_.board.size;
    const double t = recipe_.board.thickness;
    double top = -1e9;
    for (const Vec2 c : {Vec2{0, 0}, Vec2{size.x, 0}, size, Vec2{0, size.y}})
      top = std::max(top, s.at(c) + (in_doubt ? doubt_mm(c) : 0));
    const auto higher = [&](const recipes::Part& p) {
      double most = 0;
      for (const double x : {-0.5, 0.5})
        for (const double y : {-0.5, 0.5})
          most = std::max(most, doubt_mm(p.at + rotated({x * p.size.x, y * p.size.y}, p.rotation)));
      return in_doubt ? most : 0;
    };
    const double wide = 2 * furthest(size * 0.5, size, 0);
    add("board", on(size * 0.5), 0, t + top + up, {size.x + wide, size.y + wide}, o.rotation);
    for (const recipes::Part& p : recipe_.parts) {
      const Vec2 flat{p.size.x, p.size.y};
      const double grown = 2 * furthest(p.at, flat, p.rotation);
      if (p.fixture)
        add(p.name, p.at, 0, p.size.z, flat, p.rotation);
      else
        add(p.name, on(p.at), t + s.at(p.at), t + s.at(p.at) + p.size.z + up + higher(p),
            {flat.x + grown, flat.y + grown}, p.rotation + o.rotation);
    }
    return out;
  }
  [[nodiscard]] std::vector<Body> believed(bool grow_up) const {
    const bool marks = !known_.offset && !recipe_.marks.empty(), touches = !known_.surface && !recipe_.touches.empty();
    return bodies_at(known_.offset.value_or(recipes::WorkOffset{}), known_.surface.value_or(recipes::Surface{}),
                     marks ? recipe_.mark_rules.max_shift_mm : 0, marks ? recipe_.mark_rules.max_rotation_rad : 0,
                     touches && grow_up ? recipe_.touch_rules.window_mm : 0, known_.surface.has_value());
  }
  /// By how much the board may be higher than its touches say, by the touches' principal axes.
  [[nodiscard]] double doubt_mm(Vec2 p) const {
    const auto n = static_cast<double>(recipe_.touches.size());
    if (n == 0) return 0;
    Eigen::Vector2d mean(0, 0);
    for (const auto& t : recipe_.touches) mean += Eigen::Vector2d(t.at.x, t.at.y) / n;
    Eigen::Matrix2d scatter = Eigen::Matrix2d::Zero();
    for (const auto& t : recipe_.touches) {
      const Eigen::Vector2d d = Eigen::Vector2d(t.at.x, t.at.y) - mean;
      scatter += d * d.transpose();
    }
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(scatter);
    const double touch_mm = machine_.probe.speed_mm_s * 1e-3 + 1 / machine_.axes[machine_.z.value].counts_per_unit;
    double open = 0, leverage = 1;
    for (const int i : {0, 1}) {
      const Eigen::Vector2d axis = axes.eigenvectors().col(i);
      const double off = axis.dot(Eigen::Vector2d(p.x, p.y) - mean);
      double sum = 0;
      for (const auto& t : recipe_.touches) sum += std::abs(axis.dot(Eigen::Vector2d(t.at.x, t.at.y) - mean));
      if (std::sqrt(std::max(0.0, axes.eigenvalues()[i]) / n) < 0.5)
        open += off * off;
      else
        leverage += std::abs(off) * sum / axes.eigenvalues()[i];
    }
    const double slope = std::tan(recipe_.touch_rules.max_tilt_rad.value_or(units::rad(0.15)));
    return slope * std::sqrt(open) + std::max(0.0, touch_mm * leverage - 0.05);
  }
  [[nodiscard]] Vec3 carried(const Body& body, const AxisVec& q) const {
    return {q[machine_.x.value], q[machine_.y.value],
            q[machine_.z.value] - (body.on_lift && machine_.u ? q[machine_.u->value] : 0)};
  }
  /// Least distance on a straight motion; a large number where boxes alone say more than `enough`.
  [[nodiscard]] double least(const Body& head, const AxisVec& from, const AxisVec& to, const Body& standing,
                             double enough) const {
    Body a = head;
    const Vec3 p = carried(head, from), d = carried(head, to) - p;
    a.centre = a.centre + p;
    const auto reach = [](const Body& b) {
      const double r = std::hypot(b.shape.size.x, b.shape.size.y) / 2;
      return Vec3{r, r, b.shape.size.z / 2};
    };
    const Vec3 ra = reach(a), rb = reach(standing);
    const auto apart = [&](double Vec3::*c) {
      const double low = std::min(a.centre.*c, a.centre.*c + d.*c) - ra.*c,
                   high = std::max(a.centre.*c, a.centre.*c + d.*c) + ra.*c;
      return std::max(low - standing.centre.*c - rb.*c, standing.centre.*c - rb.*c - high);
    };
    const double box = std::max({apart(&Vec3::x), apart(&Vec3::y), apart(&Vec3::z)});
    return box > enough ? 1e9 : swept_distance(a, d, standing);
  }

  // ---- what was refused ----

  [[nodiscard]] bool named(const Leg& leg, const Pair& pair) const {
    return (pair.standing == "board" || pair.standing == "pallet_plate") &&
           std::find(leg.tools.begin(), leg.tools.end(), pair.head) != leg.tools.end();
  }
  [[nodiscard]] std::set<Pair> near(const Leg& leg, const std::vector<Body>& bodies, const AxisVec& from,
                                    const AxisVec& to, bool all = true) const {
    std::set<Pair> out;
    const double enough = machine_.clearance_mm + leg.extra_mm + kAllowed_mm;
    for (const Body& standing : bodies)
      for (const Body& head : machine_.head)
        if (!named(leg, {head.name, standing.name}) && least(head, from, to, standing, enough) < enough) {
          out.insert({head.name, standing.name});
          if (!all) return out;
        }
    return out;
  }
  /// The pairs that rightly refuse this leg; none: it is free. Where a lift-over could do, every height is tried.
  [[nodiscard]] std::set<Pair> blocks(const Leg& leg) const {
    const std::vector<Body> bodies = believed(leg.riders_grow);
    std::set<Pair> met = near(leg, bodies, leg.from, leg.to);
    if (leg.straight || met.empty()) return met;
    const auto blocked = [&](const AxisVec& from, const AxisVec& to) {
      return !near(leg, bodies, from, to, false).empty();
    };
    if (blocked(leg.from, leg.from) || blocked(leg.to, leg.to)) return met;
    const std::size_t z = machine_.z.value;
    for (double height = std::max(leg.from[z], leg.to[z]); height <= machine_.axes[z].p_max; height += kHeights_mm) {
      AxisVec up = leg.from, down = leg.to;
      up[z] = down[z] = height;
      if (machine_.u)
        up[machine_.u->value] = down[machine_.u->value] =
            std::min(leg.from[machine_.u->value], leg.to[machine_.u->value]);
      // Rising further only lengthens the motions up and down.
      if (blocked(leg.from, up) || blocked(down, leg.to)) return met;
      if (!blocked(up, down)) return {};
    }
    return met;
  }

  void wrong(std::size_t& count, const std::string& text) {
    ++count;
    if (verdict_.told.size() < kToldMost) verdict_.told.push_back(fmt::format("board {}: {}", number_, text));
  }

  /// "needle comes within 2 mm of relay at (...": the first pair of a message.
  [[nodiscard]] std::optional<Pair> pair_in(const std::string& text) const {
    for (const char* verb : {" comes within ", " meets "}) {
      const std::size_t at = text.find(verb);
      if (at == std::string::npos) continue;
      const std::size_t begin = text.rfind(' ', at - 1) + 1;
      std::size_t after = at + std::string_view(verb).size();
      if (verb[1] == 'c') after = text.find("of ", after) + 3;
      return Pair{text.substr(begin, at - begin), text.substr(after, text.find(" at ", after) - after)};
    }
    return std::nullopt;
  }

  template <class Legs>
  void refused(const Error& e, int line, const Legs& legs) {
    ++verdict_.refused;
    if (e.fault == Fault::Internal) return wrong(verdict_.collisions, to_text(e));  // FCL contradicts the proof
    if (e.fault != Fault::Collision) {
      ++verdict_.by_rules;
      return;
    }
    if (e.message.find("than the touches say") != std::string::npos) return refused_in_doubt(e, line);
    const auto pair = pair_in(e.message);
    if (pair && pair->standing == "board" && e.message.find(" comes within 0 mm of board ") != std::string::npos) {
      for (const Leg& leg : legs())
        if (lowest_over_board(leg, pair->head) < kAllowed_mm) {
          ++verdict_.in_doubt;
          return;
        }
      return wrong(verdict_.false_refusals, to_text(e));
    }
    if (!pair || e.where != fmt::format("random.yaml:{}:5", line))
      return wrong(verdict_.unnamed, to_text(e) + fmt::format(" (line {})", line));
    bool any = false;
    for (const Leg& leg : legs()) {
      const std::set<Pair> met = blocks(leg);
      if (met.contains(*pair)) return;
      any = any || !met.empty();
    }
    if (any) return wrong(verdict_.unnamed, "another pair is near: " + to_text(e));
    wrong(verdict_.false_refusals, to_text(e));
  }

  /// A feature where the board may be higher by more than its gap less what heights are off by.
  void refused_in_doubt(const Error& e, int line) {
    ++verdict_.in_doubt;
    for (const recipes::Feature& f : recipe_.features) {
      if (std::visit([](const auto& each) { return each.location.line; }, f) != line) continue;
      const double room = recipe_.materials.front().gap - 0.05;
      if (const auto* dot = std::get_if<recipes::Dot>(&f); dot != nullptr && doubt_mm(dot->at) > room - 1e-9) return;
      if (const auto* bead = std::get_if<recipes::Bead>(&f))
        for (const Vec3 p : bead->points)
          if (doubt_mm(flat(p)) > room - 1e-9) return;
      return wrong(verdict_.false_refusals, to_text(e));
    }
    wrong(verdict_.unnamed, to_text(e));
  }
  /// Of a tool's lower end over the highest that the board's face may be, at a thousand points of a leg.
  [[nodiscard]] double lowest_over_board(const Leg& leg, const std::string& tool) const {
    const Body* body = nullptr;
    for (const Body& each : machine_.head)
      if (each.name == tool) body = &each;
    const Vec3 corner = recipes::to_machine(recipe_, machine_, *known_.offset, {}, {0, 0}, 0);
    double lowest = 1e9;
    for (int k = 0; k <= 1000; ++k) {
      AxisVec q = leg.from;
      for (std::size_t i = 0; i < q.size(); ++i) q[i] += (leg.to[i] - leg.from[i]) * k / 1000;
      const Vec3 tip = body->centre + carried(*body, q) - Vec3{0, 0, body->shape.size.z / 2};
      const Vec2 p = rotated(flat(tip) - flat(corner), -known_.offset->rotation);
      const double r = body->shape.size.x / 2;
      if (p.x < -r || p.y < -r || p.x > recipe_.board.size.x + r || p.y > recipe_.board.size.y + r) continue;
      lowest = std::min(lowest, tip.z - corner.z - known_.surface->at(p) - doubt_mm(p));
    }
    return lowest;
  }

  // ---- what was certified ----

  /// True distances, but for the pairs that are named; the tilted board is the world's to judge.
  void keeps(const AxisVec& from, const AxisVec& to, const std::vector<std::string>& tools, std::optional<double> touch,
             double off_mm = 0) {
    const Leg leg{.tools = tools};
    for (const Body& standing : true_bodies_) {
      if (standing.name == "board" && (b_.placement.slope.x != 0 || b_.placement.slope.y != 0)) continue;
      double wanted = machine_.clearance_mm - kAllowed_mm - off_mm;
      // In a touch, what differs from the touched height by more than the window may be nearer by that.
      if (touch)
        for (const recipes::Part& p : recipe_.parts)
          if (p.name == standing.name && !p.fixture)
            wanted -= std::max(0.0, height_at(p.at) - *touch + kOvertravel_mm - recipe_.touch_rules.window_mm);
      if (touch && standing.name == "board")
        wanted -= std::max(0.0, kOvertravel_mm - recipe_.touch_rules.window_mm + b_.placement.z0_mm - *touch);
      for (const Body& head : machine_.head)
        if (!named(leg, {head.name, standing.name}))
          if (const double d = least(head, from, to, standing, wanted); d < wanted)
            wrong(verdict_.too_near, fmt::format("block {}: {} and {} at {:.9f} mm, {:.9f} wanted", block_, head.name,
                                                 standing.name, d, wanted));
    }
  }
  [[nodiscard]] double height_at(Vec2 p) const { return b_.placement.z0_mm + dot(b_.placement.slope, p); }

  void go(const AxisVec& to, double dt_s) {
    for (const sim::Contact& c : watch_.step(at_, to, dt_s))
      wrong(verdict_.collisions, fmt::format("block {}: {} met {}", block_, c.moving, c.standing));
    at_ = to;
  }

  void replay(const job::ProvenBlock& block, const std::vector<std::string>& tools, std::optional<double> touch) {
    verdict_.motions += block.motions();
    for (const motion::Segment& s : block.segments()) {
      if (s.kind != motion::SegmentKind::Path && s.kind != motion::SegmentKind::Piece) continue;
      const bool curve = s.geometry.degree > 1;
      const int pieces = curve ? std::max(8, static_cast<int>(motion::duration({&s, 1}) / 1e-3)) : 1;
      for (int k = 1; k <= pieces; ++k) {
        const AxisVec to = motion::point(s.geometry, s.geometry.length * k / pieces);
        keeps(at_, to, tools, touch, curve ? kTickOff_mm : 0);
        go(to, 1e-3);
      }
    }
  }

  template <class Legs>
  bool step(const Result<job::ProvenBlock>& block, int line, const Legs& legs, const std::vector<std::string>& tools) {
    ++verdict_.steps;
    if (!block) return refused(block.error(), line, legs), false;
    replay(*block, tools, std::nullopt);
    return true;
  }

  // ---- the job ----

  [[nodiscard]] AxisVec tool_at(const char* tool, Vec2 at, double height, const recipes::WorkOffset& offset,
                                const recipes::Surface& surface) const {
    return recipes::tool_at(machine_, *config::find_tool(machine_, tool),
                            recipes::to_machine(recipe_, machine_, offset, surface, at, height),
                            std::string_view(tool) == "needle" ? offset.rotation : 0);
  }
  [[nodiscard]] int last_line() const {
    return std::visit([](const auto& f) { return f.location.line; }, recipe_.features.back());
  }

  void mark(std::size_t i) {
    const auto legs = [&] {
      return std::vector<Leg>{{.from = at_, .to = tool_at("camera", recipe_.marks[i].at, 0, known_.guess, {})}};
    };
    if (!step(planner_.look_at_mark(++block_, at_, i), recipe_.marks[i].location.line, legs, {})) return;
    const Vec2 at = recipe_.marks[i].at;
    known_.marks.push_back({i, rotated(at, b_.placement.rotation_rad) + b_.placement.shift});
    known_.guess = job::guess_offset(recipe_, known_.marks);
    planner_.know(known_);
  }
  /// What the marks cannot say, because they were refused, is told: the rest of the job is tried all the same.
  void settle_marks() {
    known_.offset = recipes::WorkOffset{b_.placement.shift, b_.placement.rotation_rad};
    planner_.know(known_);
  }

  void touch(std::size_t i) {
    const recipes::TouchPoint& point = recipe_.touches[i];
    const double window = recipe_.touch_rules.window_mm;
    const AxisVec over = tool_at("probe", point.at, window + machine_.probe.approach_mm, *known_.offset, {}),
                  end = tool_at("probe", point.at, -window, *known_.offset, {});
    const auto legs = [&] {
      return std::vector<Leg>{
          {.from = at_, .to = over, .tools = {"probe_stylus"}},
          {.from = over, .to = end, .straight = true, .riders_grow = false, .tools = {"probe_stylus"}}};
    };
    ++verdict_.steps;
    const auto block = planner_.touch(++block_, at_, i);
    if (!block) return refused(block.error(), point.location.line, legs);
    replay(*block, {"probe_stylus"}, std::nullopt);
    const motion::Segment& down = block->segments().back();
    if (down.kind != motion::SegmentKind::UntilProbe || norm_z(at_, over) > 1e-6)
      return wrong(verdict_.misread, "the touch does not end with the probe");
    descend(point, end);
    const auto up = planner_.retract(++block_, at_, i);
    ++verdict_.steps;
    AxisVec high = at_;
    high[machine_.z.value] += machine_.probe.retract_mm;
    if (!up)
      return refused(up.error(), point.location.line, [&] {
        return std::vector<Leg>{
            {.from = at_, .to = high, .straight = true, .riders_grow = false, .tools = {"probe_stylus"}}};
      });
    replay(*up, {"probe_stylus"}, height_at(point.at));
    known_.heights.push_back({i, height_at(point.at)});
    planner_.know(known_);
  }
  [[nodiscard]] double norm_z(const AxisVec& a, const AxisVec& b) const {
    return std::abs(a[machine_.z.value] - b[machine_.z.value]);
  }

  /// Down in small steps until the stylus meets something, which must be the board.
  void descend(const recipes::TouchPoint& point, const AxisVec& end) {
    ++verdict_.touched;
    const std::size_t z = machine_.z.value;
    const AxisVec over = at_;
    const double surface = tool_at("probe", point.at, 0, *known_.offset, {})[z] + height_at(point.at);
    const double rest = std::max(end[z], surface - kOvertravel_mm);
    const Body* stylus = nullptr;
    for (const Body& body : machine_.head)
      if (body.name == "probe_stylus") stylus = &body;
    while (at_[z] > rest) {
      AxisVec next = at_;
      next[z] = std::max(rest, at_[z] - kProbeStep_mm);
      if (next[z] >= surface)
        for (const Body& standing : true_bodies_)
          if (standing.name != "board" && least(*stylus, at_, next, standing, 0) <= 0)
            return wrong(verdict_.misread, fmt::format("touch {} met {}", point.name, standing.name));
      go(next, kProbeStep_mm);
    }
    keeps(over, at_, {"probe_stylus"}, height_at(point.at));
  }
  /// As a job does it; a touch that was refused is told.
  bool settle_touches() {
    for (std::size_t i = 0; i < recipe_.touches.size(); ++i)
      if (std::none_of(known_.heights.begin(), known_.heights.end(), [&](const auto& h) { return h.touch == i; }))
        known_.heights.push_back({i, height_at(recipe_.touches[i].at)});
    known_.surface = recipes::Surface{};
    if (!recipe_.touches.empty()) {
      const auto fit = job::settle_surface(recipe_, known_.heights);
      if (!fit) return wrong(verdict_.unnamed, to_text(fit.error())), false;
      known_.surface = recipes::Surface{fit->z0_mm, fit->slope};
    }
    planner_.know(known_);
    return true;
  }

  void feature(std::size_t i) {
    const recipes::Material& m = recipe_.materials.front();
    const auto over = [&](AxisVec q) {
      q[machine_.z.value] = std::min(q[machine_.z.value] + m.retract, machine_.axes[machine_.z.value].p_max);
      return q;
    };
    const auto legs = [&] {
      const std::vector<std::string> tools{"needle", "probe_stylus"};
      std::vector<Leg> out;
      if (const auto* dot = std::get_if<recipes::Dot>(&recipe_.features[i])) {
        const AxisVec to = tool_at("needle", dot->at, m.gap, *known_.offset, *known_.surface);
        out.push_back({.from = at_, .to = over(to), .tools = tools});
        out.push_back({.from = over(to), .to = to, .straight = true, .tools = tools});
        return out;
      }
      const auto& bead = std::get<recipes::Bead>(recipe_.features[i]);
      motion::BeadSpec spec;
      for (const Vec3 p : bead.points)
        spec.points.push_back(tool_at("needle", flat(p), p.z + m.gap, *known_.offset, *known_.surface));
      spec.speed_mm_s = m.speed, spec.corner_tolerance_mm = bead.corner_tolerance;
      spec.open_lead_s = m.valve_open_lead, spec.close_lead_s = m.valve_close_lead;
      const auto planned = motion::plan_bead(job::limits_of(machine_), spec);
      if (!planned) return out;
      out.push_back({.from = at_, .to = over(planned->start), .tools = tools});
      out.push_back({.from = over(planned->start), .to = planned->start, .straight = true, .tools = tools});
      for (const motion::Segment& piece : planned->segments) {
        const motion::Geometry& g = piece.geometry;
        const double parts = g.degree < 2 ? 1 : std::ceil(g.length / kPlayedStep_mm);
        for (double k = 0; k < parts; ++k)
          out.push_back({.from = motion::point(g, g.length * k / parts),
                         .to = motion::point(g, g.length * (k + 1) / parts),
                         .straight = true,
                         .extra_mm = kPlayedOff_mm,
                         .tools = tools});
      }
      out.push_back({.from = planned->end, .to = over(planned->end), .straight = true, .tools = tools});
      return out;
    };
    const int line = std::visit([](const auto& f) { return f.location.line; }, recipe_.features[i]);
    if (step(planner_.dispense(++block_, at_, {i}), line, legs, {"needle", "probe_stylus"})) possible_.push_back(i);
  }

  /// Those that can be dispensed, in one block: travel between them is blended with the motions up and down.
  void all_features() {
    if (possible_.size() < 2) return;
    const auto block = planner_.dispense(++block_, at_, possible_);
    if (!block) return;  // what refuses a feature by itself was judged
    const auto& all = block->segments();
    for (auto first = all.begin(); first != all.end();) {
      const auto travels = [](const motion::Segment& s) { return s.feature == motion::kTravel; };
      const auto begin = std::find_if(first, all.end(), travels), end = std::find_if_not(begin, all.end(), travels);
      if (begin != all.begin() && end != all.end()) turns_above(begin, end);
      first = end;
    }
    replay(*block, {"needle", "probe_stylus"}, std::nullopt);
  }
  /// Between two features nothing but Z moves lower than half of the retract.
  template <class It>
  void turns_above(It begin, It end) {
    const auto place = [](const motion::Segment& s, double share) {
      return motion::point(s.geometry, share * s.geometry.length);
    };
    const std::size_t x = machine_.x.value, y = machine_.y.value, z = machine_.z.value;
    AxisVec last = place(*begin, 0);
    const double lowest = std::min(last[z], place(*std::prev(end), 1)[z]) + recipe_.materials.front().retract / 2;
    for (auto s = begin; s != end; ++s) {
      verdict_.blended += s->geometry.degree == 3;
      for (int k = 1; k <= 20; ++k) {
        const AxisVec next = place(*s, k / 20.0);
        const double low = std::min(last[z], next[z]);
        if (std::hypot(next[x] - last[x], next[y] - last[y]) > 1e-9 && low < lowest - 1e-9)
          return wrong(verdict_.too_near, fmt::format("turns {:.6f} mm too low", lowest - low));
        last = next;
      }
    }
  }

  // ---- rising and homing from anywhere ----

  double real(double low, double high) { return low + (high - low) * static_cast<double>(random_() >> 11) * 0x1.0p-53; }

  void rise() {
    AxisVec here =
        tool_at("camera", {real(-20, recipe_.board.size.x + 20), real(-20, recipe_.board.size.y + 20)}, 0, {}, {});
    here[machine_.x.value] += real(-1, 1) * 60;
    for (const AxisId id : {machine_.x, machine_.y})
      here[id.value] = std::clamp(here[id.value], machine_.axes[id.value].p_min, machine_.axes[id.value].p_max);
    here[machine_.z.value] = real(machine_.axes[machine_.z.value].p_min, machine_.safe_z_mm - 1);
    if (machine_.u && real(0, 1) < 0.5) here[machine_.u->value] = real(0, 30);
    const std::vector<Body> bodies = believed(true);
    AxisVec up = here;
    up[machine_.z.value] = machine_.safe_z_mm;
    double short_by = -1e9;
    for (const Body& standing : bodies)
      for (const Body& head : machine_.head) {
        const double now = least(head, here, here, standing, machine_.clearance_mm);
        if (now <= 0) return;  // nobody stands there
        const double wanted = std::min(machine_.clearance_mm, now);
        short_by = std::max(short_by, wanted - least(head, here, up, standing, machine_.clearance_mm));
      }
    ++verdict_.rises;
    const auto planned = job::plan_rise(machine_, *planner_.surroundings(), 1, here);
    if (planned && short_by > kMeasured_mm)
      wrong(verdict_.too_near, fmt::format("a rise comes nearer by {:.6f} mm", short_by));
    if (!planned && short_by < -kMeasured_mm) wrong(verdict_.false_refusals, "rise: " + to_text(planned.error()));
    if (!planned && !pair_in(planned.error().message)) wrong(verdict_.unnamed, "rise: " + to_text(planned.error()));
    home(here, bodies);
  }

  /// Where homing is certified, the head is sent to random positions that its axes may take.
  void home(const AxisVec& here, const std::vector<Body>& bodies) {
    ++verdict_.homings;
    if (!job::prove_homing(machine_, *planner_.surroundings(), here)) return;
    AxisVec now = here;
    std::set<int> orders;
    for (const config::Axis& axis : machine_.axes)
      if (axis.homing) orders.insert(axis.homing->order);
    for (const int order : orders) {
      const AxisVec begin = now;
      for (int k = 0; k < 6; ++k) {
        AxisVec q = begin;
        for (const config::Axis& axis : machine_.axes)
          if (axis.homing && axis.homing->order == order)
            q[axis.id.value] += real(0, 1) * (axis.homing->position - q[axis.id.value]);
        for (const Body& standing : bodies)
          for (const Body& head : machine_.head) {
            const double d = least(head, q, q, standing, machine_.clearance_mm);
            if (d < machine_.clearance_mm &&
                d < least(head, begin, begin, standing, machine_.clearance_mm) - kMeasured_mm)
              wrong(verdict_.too_near, fmt::format("homing: {} and {} at {:.6f} mm", head.name, standing.name, d));
          }
      }
      for (const config::Axis& axis : machine_.axes)
        if (axis.homing && axis.homing->order == order) now[axis.id.value] = axis.homing->position;
    }
  }

  RandomBoard b_;
  const config::Machine& machine_;
  const recipes::Recipe& recipe_;
  std::uint64_t number_;
  Verdict& verdict_;
  sim::Head head_;
  sim::CollisionWatch watch_;
  sim::BoardTruth truth_;
  job::BlockPlanner planner_;
  std::mt19937_64 random_;
  std::vector<Body> true_bodies_;
  job::Knowledge known_;
  std::vector<std::size_t> possible_;  ///< features that could be dispensed by themselves
  AxisVec at_{};
  std::uint32_t block_ = 0;
};

}  // namespace

void try_board(const RandomBoard& board, std::uint64_t number, Verdict& verdict) {
  Trial(board, number, verdict).run();
}

}  // namespace gantry::test
