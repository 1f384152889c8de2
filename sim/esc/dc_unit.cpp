#include "sim/esc/dc_unit.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "sim/whole.hpp"

namespace gantry::sim {
namespace {
// The control loop of the local copy, loosely that of an ESC (Beckhoff ESC data sheet, section I, 9.1.3.4): a share of
// each difference at once, a smaller share into the rate. A step is bounded, so that an offset that was never written
// is not made good by the loop.
constexpr double kShare = 0.25, kRateShare = 0.01, kStep_ns = 1000, kRateMax = 1e-3;
constexpr double kSmoothing = 1.0 / 16;
constexpr std::uint32_t kShortestCycle_ns = 10'000;  // shorter ones reach no station's application
constexpr std::int64_t kMissed_ns = 10'000;          // the loop may move the clock by this much past a pulse
constexpr Time kRateSpan = microseconds(20);  // differences that follow closer than this say nothing about the rate
}  // namespace

void DcUnit::power_on(Time now, int bits) noexcept {
  const double drift = drift_;
  const auto jitter = jitter_ns_;
  const Random random = random_;
  *this = DcUnit{};
  drift_ = drift;
  jitter_ns_ = jitter;
  random_ = random;
  bits_ = bits;
  on_since_ = drift_since_ = corrected_at_ = now;
}

void DcUnit::set_drift(double ppm, Time now) noexcept {
  const std::int64_t elapsed = (now - drift_since_).count();
  local_base_ += static_cast<std::uint64_t>(elapsed + whole(drift_ * static_cast<double>(elapsed)));
  drift_since_ = now;
  drift_ = ppm * 1e-6;
  schedule(now);
}

void DcUnit::set_jitter(std::uint32_t ns, std::uint64_t seed) noexcept {
  jitter_ns_ = ns;
  random_ = Random(seed);
}

std::uint64_t DcUnit::local(Time now) const noexcept { return cut(whole_system(now) - offset_ns_); }
std::uint64_t DcUnit::system(Time now) const noexcept { return cut(whole_system(now)); }

std::uint64_t DcUnit::whole_system(Time now) const noexcept {
  const std::int64_t elapsed = (now - drift_since_).count();
  const double adjust = correction_ns_ + rate_ * static_cast<double>((now - corrected_at_).count());
  return local_base_ + static_cast<std::uint64_t>(elapsed + whole(drift_ * static_cast<double>(elapsed))) +
         static_cast<std::uint64_t>(whole(adjust)) + offset_ns_;
}

std::uint64_t DcUnit::latch(Time now) noexcept {
  if (jitter_ns_ == 0) return local(now);
  return local(now + Time{whole(random_.symmetric(jitter_ns_))});
}

void DcUnit::set_offset(std::uint64_t offset_ns, Time now) noexcept {
  offset_ns_ = offset_ns;
  difference_ns_ = 0;
  filter_new_ = true;
  schedule(now);
}

void DcUnit::reset_filter(Time now) noexcept {
  correction_ns_ += rate_ * static_cast<double>((now - corrected_at_).count());
  corrected_at_ = now;
  rate_ = difference_ns_ = 0;
  filter_new_ = true;
  schedule(now);
}

void DcUnit::receive(std::uint64_t reference_ns, int bits, Time now) noexcept {
  const Time seen = jitter_ns_ == 0 ? now : now + Time{whole(random_.symmetric(jitter_ns_))};
  const std::uint64_t mine = system(seen) - delay_ns_;
  const std::int64_t difference = bits == 32 || bits_ == 32
                                      ? static_cast<std::int32_t>(static_cast<std::uint32_t>(mine - reference_ns))
                                      : static_cast<std::int64_t>(mine - reference_ns);
  const auto d = static_cast<double>(difference);
  difference_ns_ = filter_new_ ? d : difference_ns_ + kSmoothing * (d - difference_ns_);
  filter_new_ = false;
  if (difference == 0 && rate_ == 0) return;  // in step to the ns: nothing moves
  const Time since = now - corrected_at_;
  correction_ns_ += rate_ * static_cast<double>(since.count()) - std::clamp(kShare * d, -kStep_ns, kStep_ns);
  if (since >= kRateSpan && std::abs(d) < kStep_ns)
    rate_ = std::clamp(rate_ - kRateShare * d / static_cast<double>(since.count()), -kRateMax, kRateMax);
  corrected_at_ = now;
  schedule(now);
}

std::uint32_t DcUnit::difference() const noexcept {
  // Bit 31: the local copy is smaller than the received time.
  const double magnitude = std::min(std::abs(difference_ns_), 2147483647.0);
  return static_cast<std::uint32_t>(magnitude) | (difference_ns_ < 0 && magnitude >= 1 ? 0x80000000u : 0);
}

std::uint16_t DcUnit::speed_difference() const noexcept {
  constexpr double kSteps = 1 << 20;  // assumed
  return static_cast<std::uint16_t>(static_cast<std::int16_t>(std::clamp(rate_ * kSteps, -32767.0, 32767.0)));
}

void DcUnit::start_sync0(std::uint64_t start_ns, std::uint32_t cycle_ns, Time now) noexcept {
  active_ = true;
  const std::uint64_t here = whole_system(now);
  next_system_ns_ = bits_ == 32 ? here + static_cast<std::uint32_t>(start_ns - here) : start_ns;
  cycle_ns_ = cycle_ns;
  pulses_ = 0;
  missed_ = static_cast<std::int64_t>(next_system_ns_ - here) < 0 || (cycle_ns != 0 && cycle_ns < kShortestCycle_ns);
  schedule(now);
}

void DcUnit::stop_sync0() noexcept { active_ = false, next_ = kNever; }

void DcUnit::pulse() noexcept {
  ++pulses_;
  const Time from = next_;
  next_system_ns_ += cycle_ns_;
  missed_ = cycle_ns_ == 0;  // single shot: no other one
  schedule(from);
}

void DcUnit::schedule(Time now) noexcept {
  if (!active_) return;
  const auto ahead = static_cast<std::int64_t>(next_system_ns_ - whole_system(now));
  // The unit compares for equality: where the system time was set beyond the next pulse, that pulse never comes.
  if (ahead < -std::max<std::int64_t>(cycle_ns_, kMissed_ns)) missed_ = true;
  constexpr std::int64_t kNeverSoon_ns = 1'000'000'000'000'000'000;  // 31 years: keeps sums of times in range
  const auto soon = std::min(ahead, kNeverSoon_ns);
  const double rate = 1 + drift_ + rate_;
  next_ = missed_ ? kNever : now + Time{rate == 1.0 ? soon : whole(static_cast<double>(soon) / rate)};
}

}  // namespace gantry::sim
