#include "motion/rt/compensation.hpp"

#include <algorithm>
#include <cmath>

namespace gantry::motion {

Compensation::Compensation(const Limits& limits, const AxisVec& response_delay_s) noexcept
    : axes_(limits.axes), tick_s_(limits.tick_s) {
  constexpr double kSame = 1e-9;  // of a tick
  constexpr double kMost = static_cast<double>(kHistory - 3);
  AxisVec delay{};  // in ticks
  double largest = 0;
  for (std::size_t i = 0; i < axes_; ++i) {
    delay[i] = std::clamp(response_delay_s[i] / tick_s_, 0.0, kMost);
    largest = std::max(largest, delay[i]);
  }
  delay_ticks_ = static_cast<int>(std::ceil(largest - kSame));
  for (std::size_t i = 0; i < axes_; ++i) {
    const double own = std::max(delay_ticks_ - delay[i], 0.0);
    whole_[i] = static_cast<int>(own + kSame);
    fraction_[i] = std::max(own - whole_[i], 0.0);
    if (fraction_[i] < kSame) fraction_[i] = 0;
  }
}

void Compensation::reset(const AxisVec& q, std::uint32_t outputs) noexcept { history_.fill({q, {}, outputs}); }

AxisVec Compensation::go_on(const AxisVec& q, const AxisVec& v, std::uint32_t outputs) noexcept {
  AxisVec planned = q;
  for (std::size_t i = 0; i < axes_; ++i) planned[i] += v[i] * tick_s_ * (whole_[i] + fraction_[i]);
  for (std::size_t k = 0; k < kHistory; ++k) {
    Sample& s = history_[(newest_ + kHistory - k) % kHistory];
    s = {planned, v, outputs};
    for (std::size_t i = 0; i < axes_; ++i) s.q[i] -= v[i] * tick_s_ * static_cast<double>(k);
  }
  return planned;
}

bool Compensation::clear_of(std::uint32_t mask) const noexcept {
  for (int k = 0; k <= delay_ticks_; ++k)
    if ((ago(k).outputs & mask) != 0) return false;
  return true;
}

const Compensation::Sample& Compensation::ago(int ticks) const noexcept {
  return history_[(newest_ + kHistory - static_cast<std::size_t>(ticks)) % kHistory];
}

Compensated Compensation::step(const Setpoint& planned, std::uint32_t safe_mask) noexcept {
  newest_ = (newest_ + 1) % kHistory;
  history_[newest_] = {planned.q, planned.v, planned.outputs};
  if (safe_mask != 0)
    for (Sample& s : history_) s.outputs &= ~safe_mask;

  Compensated out;
  out.q = planned.q;
  out.v = planned.v;
  out.outputs = ago(delay_ticks_).outputs;
  out.settled = true;
  for (std::size_t i = 0; i < axes_; ++i) {
    const Sample& near = ago(whole_[i]);
    out.q[i] = near.q[i];
    out.v[i] = near.v[i];
    if (fraction_[i] > 0) {
      // Between two samples: the cubic through both positions and speeds. Its error at a = 5 m/s^2 with j = 100 m/s^3
      // is below 1e-3 um; a straight line would be off by a h^2 / 8 = 0.6 um.
      const Sample& far = ago(whole_[i] + 1);
      const double h = tick_s_, u = 1 - fraction_[i], w = u * u * (3 - 2 * u);
      out.q[i] = far.q[i] + w * (near.q[i] - far.q[i]) + h * u * (1 - u) * ((1 - u) * far.v[i] - u * near.v[i]);
      out.v[i] = far.v[i] + u * (near.v[i] - far.v[i]);
    }
    for (int k = 0; k <= whole_[i] + 1; ++k) out.settled = out.settled && ago(k).q[i] == planned.q[i];
  }
  return out;
}

}  // namespace gantry::motion
