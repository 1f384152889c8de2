#include "core/steady_speed.hpp"

#include <algorithm>
#include <cmath>

#include "core/change_duration.hpp"

namespace gantry {
namespace {

constexpr double kWindow_mm = 0.4;
constexpr double kLeastSteps = 8, kMostSteps = 400;
constexpr double kHeld_s = 0.05;     // at one speed for so long is no corner
constexpr double kSameSpeed = 0.02;  // but for this part of it
constexpr double kCrept_s = 0.1;
constexpr double kAsNeeded = 1.5;   // of what a straight change needs: a corner's takes a tenth more, and its rounding
constexpr double kRegained = 0.75;  // of what it had lost: so much, and it goes down again into another dip ...
constexpr double kTurns = 0.05;     // ... by this part of what is asked for

}  // namespace

SteadySpeed::SteadySpeed(AskedSpeed asked, double step_s, double strictly)
    : asked_(asked),
      step_s_(step_s),
      strictly_(strictly),
      window_steps_(static_cast<std::size_t>(
          std::clamp(std::ceil(kWindow_mm / (asked.mm_s * step_s)), kLeastSteps, kMostSteps))) {}

bool SteadySpeed::is_good(double mm_s) const { return std::abs(mm_s - asked_.mm_s) <= asked_.tolerance * asked_.mm_s; }

void SteadySpeed::add(double mm, std::uint32_t steps) {
  if (steps * step_s_ >= kHeld_s) held(mm / (steps * step_s_));
  for (std::uint32_t n = 0; n < steps; ++n) step(mm / steps);
}

void SteadySpeed::step(double mm) {
  window_.push_back(mm);
  sum_mm_ += mm;
  if (window_.size() > window_steps_) leave_oldest();
  if (window_.size() == window_steps_) see(sum_mm_ / (static_cast<double>(window_steps_) * step_s_));
}

void SteadySpeed::see(double mean_mm_s) {
  judged_ = true;
  const bool good = is_good(mean_mm_s);
  if (good) good_left_ = window_.size();
  const double low = std::min(run_.low, mean_mm_s), high = std::max(run_.high, mean_mm_s);
  const bool same = run_.steps > 0 && good == run_.good && high - low <= strictly_ * kSameSpeed * high;
  run_ = same ? Run{low, high, good, run_.steps + 1} : Run{mean_mm_s, mean_mm_s, good, 1};
  // All windows that a corner shorter than one is in have one mean.
  const double least_s = std::max(kHeld_s, 2 * window_s()) / strictly_;
  if (static_cast<double>(run_.steps - 1) * step_s_ >= least_s) held(mean_mm_s);
  if (good || mean_mm_s > asked_.mm_s) return end_slow();
  ++slow_steps_;
  slow_mm_ += mean_mm_s * step_s_;
  dip(mean_mm_s);
}

void SteadySpeed::dip(double mean_mm_s) {
  if (slow_steps_ == 1) dip_ = {.from = mean_mm_s, .low = mean_mm_s, .up_to = mean_mm_s};
  const bool regained = dip_.up_to - dip_.low > kRegained * (asked_.mm_s - dip_.low);
  if (regained && dip_.up_to - mean_mm_s > kTurns * asked_.mm_s) {
    const double top = dip_.up_to;
    end_dip();
    dip_ = {.from = top, .low = mean_mm_s, .up_to = mean_mm_s};
  }
  if (mean_mm_s <= dip_.low) dip_.low = dip_.up_to = mean_mm_s;
  dip_.up_to = std::max(dip_.up_to, mean_mm_s);
  ++dip_.steps;
}

void SteadySpeed::end_dip() {
  const auto lasts_s = [&](double mm_s) { return change_duration(mm_s, asked_.a_max, asked_.j_max); };
  const double needs_s = kAsNeeded * (lasts_s(dip_.from - dip_.low) + lasts_s(dip_.up_to - dip_.low));
  dips_.needed_s += needs_s;
  const double beyond_s = static_cast<double>(dip_.steps) * step_s_ - needs_s;
  if (beyond_s > dips_.most_s) dips_.most_s = beyond_s, dips_.low_mm_s = dip_.low;
}

void SteadySpeed::end_slow() {
  const double s = static_cast<double>(slow_steps_) * step_s_;
  if (s >= kCrept_s && slow_mm_ < kCreeps * asked_.mm_s * s) held(slow_mm_ / s);
  if (slow_steps_ > 0 && asked_.a_max > 0 && asked_.j_max > 0) {
    end_dip();
    // Windows of a corner begin before it and end behind it.
    const bool sags = s > (dips_.needed_s + kHeld_s) / strictly_ + window_s();
    if (sags && (!sag_ || s > sag_->lasts_s)) sag_ = {.low_mm_s = dips_.low_mm_s, .lasts_s = s};
  }
  slow_steps_ = 0;
  slow_mm_ = 0;
  dips_ = {};
}

void SteadySpeed::held(double mm_s) {
  if (!held_mm_s_ || std::abs(mm_s - asked_.mm_s) > std::abs(*held_mm_s_ - asked_.mm_s)) held_mm_s_ = mm_s;
}

void SteadySpeed::leave_oldest() {
  const double mm = window_.front();
  window_.pop_front();
  sum_mm_ -= mm;
  all_mm_ += mm;
  if (good_left_ == 0) return;
  good_mm_ += mm;
  --good_left_;
}

void SteadySpeed::end_stretch() {
  if (!judged_ && !window_.empty()) see(sum_mm_ / (static_cast<double>(window_.size()) * step_s_));
  while (!window_.empty()) leave_oldest();
  end_slow();
  sum_mm_ = 0;
  run_ = {};
  judged_ = false;
}

}  // namespace gantry
