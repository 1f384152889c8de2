#include "app/job/job_times.hpp"

#include <algorithm>
#include <utility>

namespace gantry::job {

JobTimes::JobTimes(const Forecast* forecast, std::size_t features, double cycle_s)
    : features_(features), cycle_s_(cycle_s) {
  if (forecast == nullptr) return;
  forecast_s_ = forecast->s;
  for (const StepTime& step : forecast->steps) steps_.push_back({step.what, step.s, 0, false, false});
  for (std::size_t i = 0; i < std::min(features, forecast->features.size()); ++i)
    features_[i].predicted = forecast->features[i];
}

StepTaken* JobTimes::current() { return begun_ ? &steps_[step_] : nullptr; }

void JobTimes::begin(const std::string& what) {
  if (begun_) return disturb();
  if (step_ == steps_.size()) steps_.push_back({what, std::nullopt, 0, false, false});
  begun_ = true;
  travel_s_ = played_s_ = 0;
  travel_disturbed_ = false;
}

void JobTimes::plan(const std::vector<FeatureTime>& features) {
  for (std::size_t i = 0; i < std::min(features.size(), features_.size()); ++i)
    if (features[i].on_it_s > 0 && features_[i].actual.on_it_s == 0) features_[i].predicted = features[i];
}

void JobTimes::see(const PlayedCycle& cycle) {
  StepTaken* const step = current();
  if (step == nullptr || !cycle.plays) return;
  const bool disturbed = cycle.stopped || cycle.rate != 1;
  step->actual_s += cycle_s_;
  step->disturbed |= disturbed;
  if (!cycle.stopped) played_s_ += cycle_s_ * std::min(cycle.rate, 1.0);
  if (cycle.feature >= features_.size()) {
    travel_s_ += cycle_s_;
    travel_disturbed_ |= disturbed;
    return;
  }
  FeatureTaken& feature = features_[cycle.feature];
  feature.actual.travel_s += std::exchange(travel_s_, 0);
  feature.actual.on_it_s += cycle_s_;
  feature.disturbed |= disturbed || std::exchange(travel_disturbed_, false);
}

void JobTimes::image(double s) {
  images_s_ += s;
  if (StepTaken* const step = current()) step->actual_s += s;
}

void JobTimes::disturb() {
  if (StepTaken* const step = current()) step->disturbed = true;
  travel_disturbed_ = true;
}

void JobTimes::done() {
  if (!begun_) return;
  steps_[step_].done = true;
  over_s_ += steps_[step_].predicted_s.value_or(0);
  played_s_ = 0;
  ++step_;
  begun_ = false;
}

std::optional<double> JobTimes::left_s() const {
  if (forecast_s_ < 0) return std::nullopt;
  const double current_s = begun_ ? std::min(played_s_, steps_[step_].predicted_s.value_or(0)) : 0;
  return std::max(0.0, forecast_s_ - over_s_ - current_s);
}

}  // namespace gantry::job
