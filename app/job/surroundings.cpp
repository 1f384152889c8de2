#include "app/job/surroundings.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>

#include "app/job/limits.hpp"
#include "motion/path/chords.hpp"
#include "motion/plan/sweep.hpp"

namespace gantry::job {
namespace {

constexpr double kTipTolerance_mm = 0.5;
constexpr double kDeepest_mm = 5;      // that bodies may overlap by belief and be led apart: a probe's spring
constexpr double kAnyDepth_mm = 1e5;   // the head may be anywhere in a zone, which is no matter, and is led out
constexpr double kMeasured_mm = 1e-5;  // how exactly it is found how near two bodies stand
constexpr double kLying_mm = 1e-6;     // what ends at the board's lower face carries it
constexpr double kSlack_mm = recipes::kHeightSlack_mm;

/// The body of the head at whose lower end a tool has its tip: the one that may come near to what the tool works on.
std::string working_body(const config::Machine& machine, std::string_view tool_name) {
  const config::Tool* tool = config::find_tool(machine, tool_name);
  if (tool == nullptr) return {};
  for (const config::Body& body : machine.head) {
    const Vec3 lower_end = body.centre - Vec3{0, 0, body.shape.size.z / 2};
    if (norm(lower_end - tool->tip) < kTipTolerance_mm) return body.name;
  }
  return {};
}

/// The largest margin that two bodies are proved to keep where they stand, at most `clearance_mm`; below 0 they
/// overlap. Nothing when that is by more than a probe can press in, but for a zone to keep out of.
std::optional<double> margin_kept(const motion::Scene& scene, std::size_t head, std::size_t standing,
                                  const AxisVec& now, double clearance_mm) {
  const motion::BodySweep still(scene, head, now, now);
  double kept = scene.standing()[standing].keep_out ? -kAnyDepth_mm : -kDeepest_mm, not_kept = clearance_mm;
  if (still.prove(standing, not_kept)) return clearance_mm;
  if (!still.prove(standing, kept)) return std::nullopt;
  while (not_kept - kept > kMeasured_mm) {
    const double middle = (kept + not_kept) / 2;
    (still.prove(standing, middle) ? kept : not_kept) = middle;
  }
  return kept;
}

/// What lies under the board: bodies of the machine that end at its lower face or below it, within its outline.
bool under(const config::Body& body, const config::Body& board, double board_bottom) {
  if (body.centre.z + body.shape.size.z / 2 > board_bottom + kLying_mm) return false;
  const motion::Solid a = motion::make_solid(body), b = motion::make_solid(board);
  const auto apart = [&](double Vec3::*c, Vec3 n) {
    return std::abs(a.centre.*c - b.centre.*c) >= motion::extent(a, n) + motion::extent(b, n);
  };
  return !apart(&Vec3::x, {1, 0, 0}) && !apart(&Vec3::y, {0, 1, 0});
}

/// How far any point of a box that rides on the board may be off in the plane. The board turns about its origin.
double furthest_mm(const Belief& belief, Vec2 at, Vec2 size, double rotation_rad = 0) {
  double radius = 0;
  for (const Vec2 corner : {Vec2{size.x, size.y}, Vec2{size.x, -size.y}, Vec2{-size.x, size.y}, Vec2{-size.x, -size.y}})
    radius = std::max(radius, norm(at + rotated(corner * 0.5, rotation_rad)));
  return belief.shift_mm + 2 * radius * std::sin(belief.rotation_rad / 2);
}

}  // namespace

Belief unmeasured(const recipes::Recipe& recipe) {
  Belief belief;
  if (!recipe.marks.empty())
    belief.shift_mm = recipe.mark_rules.max_shift_mm, belief.rotation_rad = recipe.mark_rules.max_rotation_rad;
  if (!recipe.touches.empty()) belief.upwards_mm = recipe.touch_rules.window_mm;
  return belief;
}

Belief belief_of(const config::Machine& machine, const recipes::Recipe& recipe, const Knowledge& known) {
  Belief belief = unmeasured(recipe);
  if (known.offset) belief.offset = *known.offset, belief.shift_mm = belief.rotation_rad = 0;
  if (known.surface) {
    belief.surface = *known.surface, belief.upwards_mm = 0;
    belief.doubt.emplace(recipe, machine);
  }
  return belief;
}

Surroundings::Surroundings(const config::Machine& machine)
    : scene_(machine),
      scene_of_touch_(machine),
      clearance_mm_(kept_mm(machine, scene_)),
      needle_(working_body(machine, "needle")),
      probe_(working_body(machine, "probe")) {}

Surroundings::Surroundings(const config::Machine& machine, const recipes::Recipe& recipe, const Belief& belief)
    : Surroundings(machine) {
  belief_ = belief;
  for (const recipes::Feature& feature : recipe.features) {
    if (const auto& on = std::visit([](const auto& f) -> const std::string& { return f.on; }, feature); !on.empty())
      dispensed_on_.insert(on);
  }
  add_recipe(machine, recipe);
  const Vec3 corner = recipes::to_machine(recipe, machine, {}, {}, {0, 0}, 0);
  const config::Body nominal = recipes::bodies(recipe, machine, {}, {}).front();
  for (const config::Body& body : machine.scene)
    if (under(body, nominal, corner.z - recipe.board.thickness))
      carriers_.emplace_back(body.name, corner.z - body.centre.z - body.shape.size.z / 2);
  tell_in(machine, recipe);
  faces_[kBoard] = {recipe.board.size * 0.5, recipe.board.size, 0, 0};
  for (const recipes::Part& part : recipe.parts)
    if (dispensed_on_.contains(part.name))
      faces_[part.name] = {part.at, {part.size.x, part.size.y}, part.rotation, part.size.z};
}

void Surroundings::tell_in(const config::Machine& machine, const recipes::Recipe& recipe) {
  const motion::BoardFrame frame{recipes::to_machine(recipe, machine, belief_.offset, belief_.surface, {0, 0}, 0),
                                 belief_.offset.rotation, belief_.surface.slope};
  scene_.tell_in(frame), scene_of_touch_.tell_in(frame);
}

/// Each body of the recipe where it is believed to be, grown by how far it may be off. The board's box reaches to where
/// its highest corner may be.
void Surroundings::add_recipe(const config::Machine& machine, const recipes::Recipe& recipe) {
  const Vec2 size = recipe.board.size;
  double highest = -1e9, lowest = 1e9;
  for (const Vec2 corner : std::array{Vec2{0, 0}, Vec2{size.x, 0}, size, Vec2{0, size.y}}) {
    highest = std::max(highest, belief_.surface.at(corner) + (belief_.doubt ? belief_.doubt->mm(corner) : 0));
    lowest = std::min(lowest, belief_.surface.at(corner));
  }
  highest_mm_ = highest, uneven_mm_ = highest - lowest;
  const auto bodies = recipes::bodies(recipe, machine, belief_.offset, belief_.surface);
  std::vector<config::Body> of_travel, of_touch;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    config::Body body = bodies[i];
    const auto grow_up = [&body](double by_mm) { body.shape.size.z += by_mm, body.centre.z += by_mm / 2; };
    const recipes::Part* const part = i == 0 ? nullptr : &recipe.parts[i - 1];
    if (part != nullptr && part->fixture) {
      of_travel.push_back(body), of_touch.push_back(body);
      continue;
    }
    if (part == nullptr) grow_up(highest - belief_.surface.at(size * 0.5));
    const double off = part == nullptr ? furthest_mm(belief_, size * 0.5, size)
                                       : furthest_mm(belief_, part->at, {part->size.x, part->size.y}, part->rotation);
    body.shape.size.x += 2 * off, body.shape.size.y += 2 * off;
    of_touch.push_back(body);
    grow_up(belief_.upwards_mm);
    if (part != nullptr && belief_.doubt) {
      const double doubt_mm = belief_.doubt->mm(part->at, {part->size.x, part->size.y}, part->rotation);
      grow_up(doubt_mm);
      uneven_mm_ = std::max(uneven_mm_, doubt_mm);
    }
    of_travel.push_back(body);
  }
  for (const config::Body& zone : recipes::zones(recipe, machine)) of_travel.push_back(zone), of_touch.push_back(zone);
  scene_.add(of_travel), scene_of_touch_.add(of_touch);
}

/// The pair of a tool and what it works on, and the pairs with what carries that.
void Surroundings::let_near(motion::PathRules& rules, const std::string& tool, const std::string& standing,
                            double keeps_mm) const {
  const double asked_mm = clearance_mm_ + motion::kChord_mm;
  if (tool.empty() || keeps_mm >= asked_mm) return;
  rules.approaches.push_back({tool, standing, keeps_mm});
  if (standing != kBoard) return;
  for (const auto& [name, depth_mm] : carriers_)
    if (const double keeps = keeps_mm + highest_mm_ + depth_mm; keeps < asked_mm)
      rules.approaches.push_back({tool, name, keeps});
}

bool Surroundings::by_design(const std::string& head, const std::string& standing) const {
  if (head != needle_ && head != probe_) return false;
  if (head == needle_ && dispensed_on_.contains(standing)) return true;
  return standing == kBoard || std::any_of(carriers_.begin(), carriers_.end(),
                                           [&](const auto& carrier) { return carrier.first == standing; });
}

motion::PathRules Surroundings::kept(const AxisVec& now, bool all) const {
  motion::PathRules rules = apart();
  for (std::size_t i = 0; i < scene_.head().size(); ++i)
    for (std::size_t k = 0; k < scene_.standing().size(); ++k) {
      const std::string &head = scene_.head()[i].name, &standing = scene_.standing()[k].name;
      const bool meant = by_design(head, standing);
      if (!all && !meant) continue;
      if (const auto margin = margin_kept(scene_, i, k, now, clearance_mm_); margin && *margin < clearance_mm_)
        rules.approaches.push_back({head, standing, *margin, meant});
    }
  return rules;
}

motion::PathRules Surroundings::travelling(const AxisVec& now) const { return kept(now, false); }
motion::PathRules Surroundings::no_nearer_than(const AxisVec& now) const { return kept(now, true); }

motion::PathRules Surroundings::approaching(const AxisVec& now, double approach_mm) const {
  motion::PathRules rules = travelling(now);
  let_near(rules, probe_, kBoard, approach_mm - kSlack_mm);
  return rules;
}

motion::PathRules Surroundings::touching(double press_mm) const {
  motion::PathRules rules = apart();
  let_near(rules, probe_, kBoard, -(press_mm + kSlack_mm + uneven_mm_));
  return rules;
}

double Surroundings::gap_kept_mm(const Work& work) {
  return work.gap_mm - std::min(work.cut_mm, work.gap_mm / 2) - kSlack_mm;
}

motion::PathRules Surroundings::dispensing(const std::vector<Work>& works) const {
  motion::PathRules rules = apart();
  std::map<std::string, double> keeps;
  const auto take = [&](const std::string& on, double height_mm) {
    const double keep = std::min(height_mm - uneven_mm_ - belief_.upwards_mm, clearance_mm_);
    const auto [known, added] = keeps.emplace(on, keep);
    if (!added) known->second = std::min(known->second, keep);
  };
  for (const Work& work : works) {
    const double gap_mm = gap_kept_mm(work);
    take(kBoard, work.top_mm + gap_mm);
    if (work.on != kBoard) take(work.on, gap_mm);
  }
  for (const auto& [on, keep] : keeps) let_near(rules, needle_, on, keep);
  return rules;
}

}  // namespace gantry::job
