// Touch probe 1 of a virtual drive: 60B8h arms it, an edge latches the counter, 60B9h tells. The vendors differ in how
// a single shot is armed again (AMD530B 7.2: only after 60B8h = 0; the others: by a new edge of bit 0) and in the bit
// that shows the input's level.
//   probe.take(function);               // every cycle: 60B8h
//   probe.on_edge(closes, counts);      // at the instant of contact
//   status = probe.status(level);       // 60B9h
#pragma once
#include <cstdint>

#include "devices/wire/cia402.hpp"

namespace gantry::sim {

class ProbeLatch {
 public:
  ProbeLatch(bool rearm_needs_zero, int level_bit) noexcept
      : rearm_needs_zero_(rearm_needs_zero), level_bit_(level_bit) {}

  void take(std::uint16_t function) noexcept {
    using namespace devices::wire::cia402;
    const bool edge = (function & kProbeEnable) != 0 && (last_ & kProbeEnable) == 0;
    if (edge && (!rearm_needs_zero_ || last_ == 0)) {
      status_ = kProbeEnabled;
      rising_armed_ = (function & kProbeRisingEdge) != 0;
      falling_armed_ = (function & kProbeFallingEdge) != 0;
      continuous_ = (function & kProbeContinuous) != 0;
    }
    if (function == 0 || ((function & kProbeEnable) == 0 && !rearm_needs_zero_)) {
      status_ = 0;
      rising_armed_ = falling_armed_ = false;
    }
    last_ = function;
  }

  [[nodiscard]] bool armed() const noexcept { return rising_armed_ || falling_armed_; }

  void on_edge(bool closes, std::int64_t counts) noexcept {
    using namespace devices::wire::cia402;
    bool& armed = closes ? rising_armed_ : falling_armed_;
    if (!armed) return;
    (closes ? rising_ : falling_) = static_cast<std::int32_t>(counts);
    status_ = static_cast<std::uint16_t>(status_ | (closes ? kProbeRisingLatched : kProbeFallingLatched));
    armed = continuous_;
  }

  [[nodiscard]] std::uint16_t status(bool level) const noexcept {
    return static_cast<std::uint16_t>(status_ | (level ? 1u << level_bit_ : 0u));
  }
  [[nodiscard]] std::int32_t rising() const noexcept { return rising_; }
  [[nodiscard]] std::int32_t falling() const noexcept { return falling_; }

 private:
  bool rearm_needs_zero_;
  int level_bit_;
  std::uint16_t last_ = 0, status_ = 0;
  bool rising_armed_ = false, falling_armed_ = false, continuous_ = false;
  std::int32_t rising_ = 0, falling_ = 0;
};

}  // namespace gantry::sim
