#include "sim/segment/frame_faults.hpp"

#include <cmath>

namespace gantry::sim {

void FrameFaults::set_noise(const LineNoise& noise) noexcept {
  noise_ = noise;
  noisy_ = noise.loss > 0 || noise.corrupt > 0 || noise.header > 0 || noise.duplicate > 0 || noise.delay > 0 ||
           noise.reorder > 0;
  random_ = Random(noise.seed);
}

FrameFate FrameFaults::next(int places) noexcept {
  FrameFate fate;
  // One count is used up by one frame; a lost frame uses none of the others.
  const auto happens = [&](int& count, double probability) {
    if (count > 0) {
      --count;
      return true;
    }
    return noisy_ && probability > 0 && random_.unit() < probability;
  };
  fate.lost = happens(lose_, noise_.loss);
  if (fate.lost) return fate;
  if (happens(corrupt_, noise_.corrupt)) {
    fate.hit_at = below(places);
    return fate;
  }
  fate.header = happens(headers_, noise_.header);
  fate.duplicate = happens(duplicate_, noise_.duplicate);
  fate.held = happens(reorder_, noise_.reorder);
  fate.foreign = happens(foreign_, 0);
  if (delay_ > 0) {
    --delay_;
    fate.delay = delay_by_;
  } else if (noisy_ && noise_.delay > 0 && random_.unit() < noise_.delay) {
    fate.delay = Time{std::llround(random_.unit() * static_cast<double>(noise_.delay_max.count()))};
  }
  return fate;
}

}  // namespace gantry::sim
