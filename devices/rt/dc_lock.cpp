#include "devices/rt/dc_lock.hpp"

#include <algorithm>
#include <cmath>

namespace gantry::devices {

bool DcLock::is_outlier(std::int64_t error_ns) noexcept {
  const bool far = any_used_ && std::abs(error_ns - error_ns_) > options_.outlier.count();
  outliers_ = far ? outliers_ + 1 : 0;
  if (outliers_ >= options_.believed_after) outliers_ = 0;
  return outliers_ > 0;
}

void DcLock::judge_lock(bool used) noexcept {
  if (!used) {
    if (++silent_ >= options_.unknown_after) locked_ = false, against_ = 0;
    return;
  }
  silent_ = 0;
  const std::int64_t error = std::abs(error_ns_);
  const bool against = locked_ ? error > options_.unlock_beyond.count() : error < options_.lock_below.count();
  against_ = against ? against_ + 1 : 0;
  if (against_ < (locked_ ? options_.unlock_after : options_.lock_after)) return;
  locked_ = !locked_;
  against_ = 0;
}

Time DcLock::step(std::uint64_t dc_time_ns) noexcept {
  double wanted = -integral_ns_;
  const std::int64_t cycle = options_.cycle.count();
  auto sample = static_cast<std::int64_t>(dc_time_ns % static_cast<std::uint64_t>(cycle)) - options_.phase.count();
  if (sample > cycle / 2) sample -= cycle;
  if (sample < -cycle / 2) sample += cycle;
  const bool used = dc_time_ns != 0 && !is_outlier(sample);
  if (used) {
    error_ns_ = sample;
    any_used_ = true;
    const auto error = static_cast<double>(error_ns_);
    const auto rate_max = static_cast<double>(options_.rate_max.count());
    const auto correction_max = static_cast<double>(options_.correction_max.count());
    wanted = -options_.kp * error - integral_ns_;
    if (std::abs(wanted) < correction_max)  // does not wind up while the output is at its limit
      integral_ns_ = std::clamp(integral_ns_ + options_.ki * error, -rate_max, rate_max);
    wanted = std::clamp(wanted, -correction_max, correction_max);
  }
  judge_lock(used);
  // What is less than a nanosecond is kept for the next cycle, so that the rate is exact in the mean.
  fraction_ns_ += wanted;
  const double whole = std::trunc(fraction_ns_);
  fraction_ns_ -= whole;
  return Time{static_cast<std::int64_t>(whole)};
}

}  // namespace gantry::devices
