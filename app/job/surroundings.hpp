// What stands around the head while a job runs: the machine's own bodies, the board and its parts where they are
// believed to be, and how near each tool may come to what it works on.
//   Surroundings s(machine, recipe, belief);   find_path(s.scene(), from, to, s.rules());
#pragma once
#include <string>
#include <utility>
#include <vector>

#include "app/job/job_state.hpp"
#include "config/machine.hpp"
#include "motion/plan/find_path.hpp"
#include "motion/plan/scene.hpp"
#include "recipes/job.hpp"

namespace gantry::job {

/// Where the board is, and how far it may be from there.
struct Belief {
  recipes::WorkOffset offset;
  recipes::Surface surface;
  double sideways_mm = 0;  ///< any point of the board may be this far off in the plane
  double upwards_mm = 0;   ///< its surface may be this much higher
};

/// What is believed before anything was measured: nominal, and off by what the recipe's rules allow.
Belief unmeasured(const recipes::Recipe& recipe);
/// What is believed with what is known: a settled offset or surface is taken as it is.
Belief belief_of(const recipes::Recipe& recipe, const Knowledge& known);

class Surroundings {
 public:
  /// The machine's own bodies alone.
  explicit Surroundings(const config::Machine& machine);
  Surroundings(const config::Machine& machine, const recipes::Recipe& recipe, const Belief& belief);

  [[nodiscard]] const motion::Scene& scene() const { return scene_; }
  /// Full clearance, but for tools over the surface that they work on: the needle keeps `gap_mm`, the probe may press
  /// in by `press_mm` (after it has touched it stands pressed in by its stopping distance).
  [[nodiscard]] motion::PathRules rules(double gap_mm, double press_mm = 0.2) const;
  /// Full clearance, but for bodies that stand nearer to each other now (the needle over a dot, the probe on the
  /// surface): they come no nearer than that, nor to what is nowhere higher (motion/plan/sweep.hpp).
  [[nodiscard]] motion::PathRules no_nearer_than(const AxisVec& now) const;
  [[nodiscard]] double sideways_mm() const { return belief_.sideways_mm; }

 private:
  void add_recipe(const config::Machine& machine, const recipes::Recipe& recipe);

  Belief belief_;
  motion::Scene scene_;
  double clearance_mm_ = 0;
  std::string needle_, probe_;  ///< bodies of the head; empty: the tool has none
  double uneven_mm_ =
      0;  ///< the board's box reaches to its highest corner: elsewhere the surface is lower by up to this
  /// Bodies under the board, and how far their top is below its surface.
  std::vector<std::pair<std::string, double>> below_;
};

}  // namespace gantry::job
