// The output word as events build it. The valve's bits close at once with every hold and stop; afterwards only an event
// that is a dispense command opens them again.
//   OutputWord w(valve_bits);  w.apply(event);  w.close_valve();  std::uint32_t now = w.bits();
#pragma once
#include "motion/types.hpp"

namespace gantry::motion {

class OutputWord {
 public:
  explicit OutputWord(std::uint32_t valve) noexcept : valve_(valve) {}

  void apply(const OutputEvent& e) noexcept {
    if (e.dispense) armed_ = true;
    write(e);
  }
  [[nodiscard]] bool closes(const OutputEvent& e) const noexcept {
    return (e.mask & valve_) != 0 && (e.value & valve_) == 0;
  }
  /// The place of an event was passed while braking for a stop: it closes, but opens nothing.
  void apply_while_stopping(const OutputEvent& e) noexcept { write(e); }

  void close_valve() noexcept {
    armed_ = false;
    bits_ &= ~valve_;
  }
  /// By command, not by the path: never the valve.
  void set(std::uint32_t mask, std::uint32_t bits) noexcept {
    mask &= ~valve_;
    bits_ = (bits_ & ~mask) | (bits & mask);
  }
  [[nodiscard]] std::uint32_t bits() const noexcept { return bits_; }

 private:
  void write(const OutputEvent& e) noexcept {
    const std::uint32_t value = armed_ ? e.value : e.value & ~valve_;
    bits_ = (bits_ & ~e.mask) | (value & e.mask);
  }

  std::uint32_t valve_;
  std::uint32_t bits_ = 0;
  bool armed_ = false;
};

}  // namespace gantry::motion
