// The distributed clock of one virtual ESC: a local clock that starts with the power and may run fast or slow, the copy
// of the system time that it keeps in step with the reference clock, and SYNC0 made from that copy.
//   dc.set_offset(...);                 // 0920h
//   dc.receive(reference_ns, now);      // a frame brings the reference clock's time (0910h written)
//   dc.start_sync0(start_ns, cycle_ns, now);   dc.next_sync0()   // instant of the next pulse on the machine's clock
// Times called `now` are the machine's clock; system times are ns of the segment's distributed clock.
#pragma once
#include <cstdint>

#include "core/clock.hpp"
#include "sim/random.hpp"

namespace gantry::sim {

class DcUnit {
 public:
  /// `bits` of its times count: 32 or 64.
  void power_on(Time now, int bits = 64) noexcept;
  /// From `now` on the local clock gains this much on the machine's.
  void set_drift(double ppm, Time now) noexcept;

  /// Each look at the wire may be off by this much, to either side (MII: the PHY's clock is not the ESC's).
  void set_jitter(std::uint32_t ns, std::uint64_t seed) noexcept;

  /// The local clock, sped up or slowed down by the control loop; the system time is that plus the offset.
  [[nodiscard]] std::uint64_t local(Time now) const noexcept;
  [[nodiscard]] std::uint64_t system(Time now) const noexcept;
  /// The local clock as a receive time shows it, jitter included.
  [[nodiscard]] std::uint64_t latch(Time now) noexcept;

  void set_offset(std::uint64_t offset_ns, Time now) noexcept;
  void set_delay(std::uint32_t delay_ns) noexcept { delay_ns_ = delay_ns; }
  void reset_filter(Time now) noexcept;
  /// Reference time as the frame carries it; `bits` of it are valid (32 or 64). Moves the local copy towards it.
  void receive(std::uint64_t reference_ns, int bits, Time now) noexcept;
  /// As 092Ch shows it: sign (local copy is behind) and magnitude, smoothed.
  [[nodiscard]] std::uint32_t difference() const noexcept;
  /// As 0932h shows it: how much the loop speeds the clock up or slows it down (scale of this model).
  [[nodiscard]] std::uint16_t speed_difference() const noexcept;

  /// Pulses at start, start + cycle ... of the system time. A start in the past never comes, as in a 64-bit ESC; one of
  /// 32 bits starts when its counter comes round.
  void start_sync0(std::uint64_t start_ns, std::uint32_t cycle_ns, Time now) noexcept;
  void stop_sync0() noexcept;
  /// 0981h asks for SYNC1 alone, which is derived from SYNC0.
  void set_sync1_alone(bool alone) noexcept { sync1_alone_ = alone; }
  [[nodiscard]] bool sync1_without_sync0() const noexcept { return sync1_alone_; }
  [[nodiscard]] bool sync0_active() const noexcept { return active_; }
  /// kNever: no pulse is to come.
  [[nodiscard]] Time next_sync0() const noexcept { return next_; }
  [[nodiscard]] std::uint64_t next_sync0_system() const noexcept { return cut(next_system_ns_); }
  [[nodiscard]] std::uint32_t sync0_cycle_ns() const noexcept { return cycle_ns_; }
  [[nodiscard]] std::uint64_t pulses() const noexcept { return pulses_; }  ///< since start_sync0()
  void pulse() noexcept;                                                   ///< the next pulse has been

 private:
  void schedule(Time now) noexcept;
  [[nodiscard]] std::uint64_t cut(std::uint64_t ns) const noexcept { return bits_ == 32 ? ns & 0xFFFFFFFFu : ns; }
  [[nodiscard]] std::uint64_t whole_system(Time now) const noexcept;

  Time on_since_{};
  int bits_ = 64;
  Random random_{1};
  std::uint32_t jitter_ns_ = 0;
  // local = base + (now - drift_since) * (1 + drift) + correction + rate * (now - corrected_at)
  Time drift_since_{};
  std::uint64_t local_base_ = 0;
  double drift_ = 0;
  std::uint64_t offset_ns_ = 0;
  std::uint32_t delay_ns_ = 0;
  double correction_ns_ = 0, rate_ = 0, difference_ns_ = 0;
  Time corrected_at_{};
  bool filter_new_ = true;

  bool active_ = false, missed_ = false, sync1_alone_ = false;
  std::uint64_t next_system_ns_ = 0, pulses_ = 0;
  std::uint32_t cycle_ns_ = 0;
  Time next_ = kNever;
};

}  // namespace gantry::sim
