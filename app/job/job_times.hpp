// What was forecast of a job beside what it took, step by step and feature by feature, and how long it will still take.
//   JobTimes times(&forecast, recipe.features.size(), cycle_s);
//   times.begin(words_of(step, recipe));   each cycle: times.see({...});   times.done();
// Waits that the host is to blame for are between blocks, and no step's.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "app/job/forecast.hpp"
#include "motion/types.hpp"

namespace gantry::job {

/// One cycle.
struct PlayedCycle {
  bool plays = false;  ///< a block does
  std::uint32_t feature = motion::kTravel;
  double rate = 1;       ///< the override: planned seconds that pass in a second, above 1 no more than one; 0 while
                         ///< something has stopped it
  bool stopped = false;  ///< by a hold or a fault, or on the way to it
};

struct StepTaken {
  std::string what;
  std::optional<double> predicted_s;  ///< nothing: it was not forecast
  double actual_s = 0;                ///< its blocks from their first tick to their last, and how long an image takes
  bool disturbed = false;             ///< by a hold, a stop, an override, or an image that was taken again
  bool done = false;
};

struct FeatureTaken {
  FeatureTime predicted;  ///< by the forecast, until its motion is planned where the board lies: by that then
  FeatureTime actual;
  bool disturbed = false;
};

class JobTimes {
 public:
  /// A null forecast: nothing is known beforehand.
  JobTimes(const Forecast* forecast, std::size_t features, double cycle_s);

  /// A step begins, or goes on after something has cut it.
  void begin(const std::string& what);
  /// What plays next was planned where the board was found, by index of the features: it is known now how long each
  /// takes that has not been begun. Turned axes allow others of the speeds that were forecast.
  void plan(const std::vector<FeatureTime>& features);
  void see(const PlayedCycle& cycle);
  /// An image is on its way for so long.
  void image(double s);
  /// The step that has begun takes longer than it should for a reason that see() is not shown.
  void disturb();
  void done();

  [[nodiscard]] const std::vector<StepTaken>& steps() const { return steps_; }
  [[nodiscard]] const std::vector<FeatureTaken>& features() const { return features_; }
  /// How long images have taken.
  [[nodiscard]] double images_s() const { return images_s_; }
  /// About how much of what was forecast is left, at an override of 100 %; nothing without a forecast.
  [[nodiscard]] std::optional<double> left_s() const;

 private:
  [[nodiscard]] StepTaken* current();

  std::vector<StepTaken> steps_;  ///< those of the forecast, and behind them what was not forecast
  std::vector<FeatureTaken> features_;
  std::size_t step_ = 0;  ///< that has begun, or comes next
  bool begun_ = false;
  double cycle_s_;
  double forecast_s_ = -1;  ///< below 0: there is none
  double over_s_ = 0;       ///< forecast of the steps that are done
  double played_s_ = 0;     ///< of the step that has begun, as planned
  double travel_s_ = 0;     ///< since the last feature
  bool travel_disturbed_ = false;
  double images_s_ = 0;
};

}  // namespace gantry::job
