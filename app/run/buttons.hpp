// The machine's own buttons: which of them was pressed, by the inputs of every cycle. A press is an edge, never a
// level, so that a button that hangs starts nothing; hold is a level as well where a job begins; start has to be seen
// released after power-up, after a stop and after a reset before it counts again.
//   Buttons buttons(machine);   each snapshot: buttons.watch(s.inputs, s.latched != Fault::None);
//   const Pressed pressed = buttons.take();
#pragma once
#include <cstdint>
#include <utility>

#include "config/machine.hpp"

namespace gantry::run {

struct Pressed {
  bool start = false, hold = false, reset = false;
  bool start_in_vain = false;  ///< while a fault was latched
};

class Buttons {
 public:
  explicit Buttons(const config::Machine& machine)
      : start_(wired(machine, config::Input::Start)),
        hold_(wired(machine, config::Input::Hold)),
        reset_(wired(machine, config::Input::Reset)),
        stop_(wired(machine, config::Input::Stop)) {}

  /// `stopped`: a fault is latched. Stop beats all: while it is pressed no other button counts.
  void watch(std::uint32_t inputs, bool stopped) {
    const std::uint32_t before = std::exchange(inputs_, inputs);
    const bool first = !std::exchange(seen_, true);
    const bool stop = (inputs & stop_) != stop_;
    const auto edge = [&](std::uint32_t mask) { return !first && !stop && (inputs & ~before & mask) != 0; };
    if (edge(start_) && start_armed_ && !stopped) pressed_.start = true, start_armed_ = false;
    if (edge(start_) && stopped) pressed_.start_in_vain = true;
    if (edge(hold_)) pressed_.hold = true;
    if (edge(reset_)) pressed_.reset = true;
    if (stop || stopped || pressed_.reset)
      start_armed_ = false;
    else if ((inputs & start_) == 0)
      start_armed_ = true;
  }

  /// Somebody keeps it pressed.
  [[nodiscard]] bool holding() const { return (inputs_ & hold_) != 0; }
  /// What was pressed since the last call.
  Pressed take() { return std::exchange(pressed_, {}); }

 private:
  static std::uint32_t wired(const config::Machine& machine, config::Input input) {
    return machine.inputs[static_cast<std::size_t>(input)] ? config::bit(input) : 0;
  }

  std::uint32_t start_, hold_, reset_, stop_;
  std::uint32_t inputs_ = 0;
  bool seen_ = false, start_armed_ = false;
  Pressed pressed_;
};

}  // namespace gantry::run
