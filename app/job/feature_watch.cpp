#include "app/job/feature_watch.hpp"

#include <algorithm>
#include <utility>

#include "motion/rt/compensation.hpp"

namespace gantry::job {
namespace {

constexpr int kMostDelay = static_cast<int>(motion::Compensation::kHistory);  // cycles, of the loop's outputs

bool change(FeatureState& state, FeatureState from, FeatureState to) {
  if (state != from) return false;
  state = to;
  return true;
}

}  // namespace

FeatureWatch::FeatureWatch(std::vector<std::size_t> order) : order_(std::move(order)) {
  if (!order_.empty()) place_.resize(*std::max_element(order_.begin(), order_.end()) + 1);
  for (std::size_t i = 0; i < order_.size(); ++i) place_[order_[i]] = i;
}

bool FeatureWatch::see(std::vector<FeatureState>& features, const ValveCycle& cycle) {
  bool changed = false;
  const bool named = cycle.block != 0 && cycle.feature < features.size();
  if (cycle.block == 0) {
    on_.reset();  // what ended the block may have kept the valve shut: then nothing of the feature is dispensed
  } else if (named && on_ != cycle.feature) {
    changed = judge_left(features);
    on_ = cycle.feature;
    had_opening_ = open_ == cycle.feature;
    if (had_opening_) ahead_ = false;
    cycles_since_ = 0;
  } else if (!named && on_ && ++cycles_since_ > kMostDelay) {
    changed = judge_left(features);
    on_.reset();
  }
  if (cycle.valve_open && !valve_) changed |= opens(features, named);
  if (!cycle.valve_open && valve_) changed |= closes(features, cycle.stopped);
  valve_ = cycle.valve_open;
  return changed;
}

bool FeatureWatch::opens(std::vector<FeatureState>& features, bool named) {
  if (on_ && (named || !had_opening_)) {
    open_ = on_;
    had_opening_ = true;
  } else if (!ahead_) {  // of the next one; a stop that takes the command back lets it be given again
    const auto from = order_.begin() + (open_ ? static_cast<std::ptrdiff_t>(place_[*open_]) + 1 : 0);
    const auto next =
        std::find_if(from, order_.end(), [&](std::size_t f) { return features[f] == FeatureState::Open; });
    if (next == order_.end()) return false;
    open_ = static_cast<std::uint32_t>(*next);
    ahead_ = true;
  }
  return change(features[*open_], FeatureState::Open, FeatureState::Begun);
}

bool FeatureWatch::closes(std::vector<FeatureState>& features, bool by_stop) {
  return open_ &&
         change(features[*open_], FeatureState::Begun, by_stop ? FeatureState::Interrupted : FeatureState::Done);
}

bool FeatureWatch::judge_left(std::vector<FeatureState>& features) {
  return on_ && !had_opening_ && change(features[*on_], FeatureState::Open, FeatureState::Interrupted);
}

}  // namespace gantry::job
