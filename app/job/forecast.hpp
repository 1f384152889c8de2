// How long a job takes, as planned before anything moves: with the board at its nominal placement, every touch at its
// nominal height, every mark found in its first image.
//   NominalProof proof = ...;   proof.forecast.s;   from_here(proof.forecast, machine, recipe, job, at, shut_s).s
#pragma once
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "app/job/job_state.hpp"
#include "app/job/proven_block.hpp"
#include "config/machine.hpp"
#include "core/axis_vec.hpp"
#include "core/breath.hpp"
#include "motion/plan/known_ways.hpp"
#include "recipes/job.hpp"

namespace gantry::job {

struct FeatureTime {
  double travel_s = 0;  ///< on the way to it, from where the feature before it was left
  double on_it_s = 0;   ///< a dot's wait and shot; a bead with its run-up and run-out
};

struct StepTime {
  std::string what;  ///< "mark 'A'", "dispense 35 features"
  double s = 0;      ///< its motions, and how long an image takes
};

/// The step that purges, and where the axes are before and behind it.
struct PurgeStep {
  std::size_t step = 0;
  AxisVec from{}, to{};
};

struct Forecast {
  double s = 0;                       ///< all steps
  std::vector<StepTime> steps;        ///< those with motion, in order
  std::vector<FeatureTime> features;  ///< by index in Recipe::features; 0 of those that the job leaves out
  std::optional<PurgeStep> purge{};
  /// Ways around bodies that it counts with: the job goes the same ones where they are free.
  std::shared_ptr<motion::KnownWays> ways{};
};

/// "mark 'A'"; "" where nothing moves in this step.
std::string words_of(const Next& step, const recipes::Recipe& recipe);

/// Of a block without its touch, and where its axes rest.
struct BlockEnd {
  double s = 0;
  AxisVec at{};
};
/// Of a block that ends where the probe latches, with the probe's axis at `surface` there (axis coordinates of the
/// touch).
BlockEnd touched(const config::Machine& machine, const ProvenBlock& block, const AxisVec& surface);

/// Adds what a block of features takes to what is known of them.
void add_times(std::vector<FeatureTime>& features, const ProvenBlock& block, const Breath& breath = {});

/// The same job from where the axes stand, with a valve that has been shut for `shut_s` (nothing: nobody knows).
/// Nominal as it is, from the park position, where that cannot be planned from there.
Forecast from_here(Forecast forecast, const config::Machine& machine, const recipes::Recipe& recipe,
                   const recipes::Job& job, const AxisVec& at, std::optional<double> shut_s);

}  // namespace gantry::job
