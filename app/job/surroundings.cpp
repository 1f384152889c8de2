#include "app/job/surroundings.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "motion/plan/sweep.hpp"

namespace gantry::job {
namespace {

constexpr const char* kBoard = "board";
constexpr double kTipTolerance_mm = 0.5;
constexpr double kDeepest_mm = 5;      // that bodies may overlap by belief and be led apart: a probe's spring
constexpr double kMeasured_mm = 1e-5;  // how exactly it is found how near two bodies stand
constexpr double kSlack_mm = 0.05;     // measured heights and following error may take this much of a gap

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
/// overlap. Nothing when that is by more than a probe can press in.
std::optional<double> margin_kept(const motion::Scene& scene, std::size_t head, std::size_t standing,
                                  const AxisVec& now, double clearance_mm) {
  const motion::BodySweep still(scene, head, now, now);
  double kept = -kDeepest_mm, not_kept = clearance_mm;
  if (still.far(standing, not_kept) || still.prove(standing, not_kept)) return clearance_mm;
  if (!still.prove(standing, kept)) return std::nullopt;
  while (not_kept - kept > kMeasured_mm) {
    const double middle = (kept + not_kept) / 2;
    (still.prove(standing, middle) ? kept : not_kept) = middle;
  }
  return kept;
}

}  // namespace

Belief unmeasured(const recipes::Recipe& recipe) {
  Belief belief;
  if (!recipe.marks.empty())
    belief.sideways_mm = recipe.mark_rules.max_shift_mm + recipe.mark_rules.max_rotation_rad * norm(recipe.board.size);
  if (!recipe.touches.empty()) belief.upwards_mm = recipe.touch_rules.window_mm;
  return belief;
}

Belief belief_of(const recipes::Recipe& recipe, const Knowledge& known) {
  Belief belief = unmeasured(recipe);
  if (known.offset) belief.offset = *known.offset, belief.sideways_mm = 0;
  if (known.surface) belief.surface = *known.surface, belief.upwards_mm = 0;
  return belief;
}

Surroundings::Surroundings(const config::Machine& machine)
    : scene_(machine),
      clearance_mm_(machine.clearance_mm),
      needle_(working_body(machine, "needle")),
      probe_(working_body(machine, "probe")) {}

Surroundings::Surroundings(const config::Machine& machine, const recipes::Recipe& recipe, const Belief& belief)
    : Surroundings(machine) {
  belief_ = belief;
  add_recipe(machine, recipe);
  const double nominal_top = recipes::to_machine(recipe, machine, {}, {}, {0, 0}, 0).z;
  for (const config::Body& body : machine.scene) {
    const double top = body.centre.z + body.shape.size.z / 2;
    if (top <= nominal_top - recipe.board.thickness + 1e-6) below_.emplace_back(body.name, nominal_top - top);
  }
}

/// Each body of the recipe where it is believed to be, grown by how far it may be off. The board's box reaches to its
/// highest corner.
void Surroundings::add_recipe(const config::Machine& machine, const recipes::Recipe& recipe) {
  const Vec2 size = recipe.board.size;
  double highest = -1e9, lowest = 1e9;
  for (const Vec2 corner : std::array{Vec2{0, 0}, Vec2{size.x, 0}, size, Vec2{0, size.y}}) {
    highest = std::max(highest, belief_.surface.at(corner));
    lowest = std::min(lowest, belief_.surface.at(corner));
  }
  uneven_mm_ = highest - lowest;
  const auto bodies = recipes::bodies(recipe, machine, belief_.offset, belief_.surface);
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    config::Body body = bodies[i];
    const bool board = i == 0;
    if (board || !recipe.parts[i - 1].fixture) {
      const double up = belief_.upwards_mm + (board ? highest - belief_.surface.at(size * 0.5) : 0);
      body.shape.size = body.shape.size + Vec3{2 * belief_.sideways_mm, 2 * belief_.sideways_mm, up};
      body.centre.z += up / 2;
    }
    scene_.add(body);
  }
}

motion::PathRules Surroundings::rules(double gap_mm, double press_mm) const {
  motion::PathRules rules{.clearance_mm = clearance_mm_, .approaches = {}};
  const double needle = gap_mm - kSlack_mm - uneven_mm_ - belief_.upwards_mm;
  const double probe = -(press_mm + kSlack_mm + uneven_mm_ + belief_.upwards_mm);
  const auto may = [&](const std::string& body, double keeps) {
    if (body.empty() || keeps >= clearance_mm_) return;
    rules.approaches.push_back({body, kBoard, keeps});
    for (const auto& [name, depth] : below_)
      if (keeps + depth < clearance_mm_) rules.approaches.push_back({body, name, keeps + depth});
  };
  may(needle_, needle);
  may(probe_, probe);
  return rules;
}

motion::PathRules Surroundings::no_nearer_than(const AxisVec& now) const {
  motion::PathRules rules{.clearance_mm = clearance_mm_, .approaches = {}};
  for (std::size_t i = 0; i < scene_.head().size(); ++i)
    for (std::size_t k = 0; k < scene_.standing().size(); ++k)
      if (const auto kept = margin_kept(scene_, i, k, now, clearance_mm_); kept && *kept < clearance_mm_)
        rules.approaches.push_back({scene_.head()[i].name, scene_.standing()[k].name, *kept});
  return rules;
}

}  // namespace gantry::job
