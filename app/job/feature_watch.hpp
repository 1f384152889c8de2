// What became of each feature, from what the loop shows in every cycle: which feature the path is on, whether the valve
// is open, and whether a stop has hold of the machine.
//   FeatureWatch watch(recipes::dispensed_by(job));
//   each snapshot: watch.see(state.features, {.block = s.block, .feature = s.feature, .valve_open = ..., .stopped =
//   ...});
// A feature is done when its valve has closed as planned, not when the path reaches it. Each feature opens the valve
// once, perhaps ahead of it (by the valve's lead) and perhaps behind (by the delay that the loop's outputs have).
#pragma once
#include <cstdint>
#include <optional>
#include <vector>

#include "app/job/job_state.hpp"
#include "motion/types.hpp"

namespace gantry::job {

/// One cycle.
struct ValveCycle {
  std::uint32_t block = 0;  ///< 0: no block plays
  std::uint32_t feature = motion::kTravel;
  bool valve_open = false;
  bool stopped = false;  ///< held, stopping, stopped, or without torque
};

class FeatureWatch {
 public:
  /// The features of the job, in the order in which it dispenses them: the valve opens ahead of the next of these.
  explicit FeatureWatch(std::vector<std::size_t> order);
  /// True when a feature has changed its state.
  bool see(std::vector<FeatureState>& features, const ValveCycle& cycle);

 private:
  bool opens(std::vector<FeatureState>& features, bool named);
  bool closes(std::vector<FeatureState>& features, bool by_stop);
  /// The path has left the feature, and the valve was never open for it.
  bool judge_left(std::vector<FeatureState>& features);

  std::vector<std::size_t> order_;
  std::vector<std::size_t> place_;     ///< in order_, by feature; one that is not in it: 0
  std::optional<std::uint32_t> on_;    ///< the feature that the path is on, or was on last
  int cycles_since_ = 0;               ///< since the path has left it
  bool had_opening_ = false;           ///< the valve was opened for it
  std::optional<std::uint32_t> open_;  ///< the feature that the valve is open for, or was opened for last
  bool ahead_ = false;                 ///< the path has not come to that one yet
  bool valve_ = false;
};

}  // namespace gantry::job
