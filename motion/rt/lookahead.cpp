#include "motion/rt/lookahead.hpp"

#include <algorithm>

namespace gantry::motion {

Bounds bounds_of(const Segment& s, double override_factor) noexcept {
  const double factor = s.kind == SegmentKind::UntilProbe ? std::min(override_factor, 1.0) : override_factor;
  return {std::min(s.v_cap * factor, s.v_max), s.a_max, s.j_max};
}

bool rests_after(const Segment& s) noexcept { return s.kind == SegmentKind::Dwell || s.ends_block || !(s.v_exit > 0); }

void Lookahead::update(std::uint32_t block, double override_factor) noexcept {
  constexpr double kFit = 1 - 1e-9;  // braking must fit beyond rounding
  size_ = 0;
  while (size_ < kWindow) {
    const Segment* s = ring_.peek(size_);
    if (s == nullptr || s->block != block) break;
    ++size_;
    if (rests_after(*s)) break;
  }
  if (size_ == 0) return;
  v_end_[size_ - 1] = 0;
  for (std::size_t i = size_ - 1; i-- > 0;) {
    const Segment &s = *ring_.peek(i), &next = *ring_.peek(i + 1);
    if (next.kind == SegmentKind::Dwell) {
      v_end_[i] = 0;
      continue;
    }
    const Bounds b = bounds_of(next, override_factor);
    double v = std::min(bounds_of(s, override_factor).v, b.v);
    if (override_factor == 1) v = std::min(v, s.v_exit);
    // Braking to rest can be shorter than braking to a low speed (approach.cpp): the better of the two counts.
    const double length = next.geometry.length * kFit;
    v_end_[i] = std::min(v, std::max(speed_over_length(v_end_[i + 1], length, b), speed_over_length(0, length, b)));
  }
}

}  // namespace gantry::motion
