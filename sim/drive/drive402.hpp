// One CiA 402 axis of a virtual station: the state machine of IEC 61800-7-201, CSP and homing, quick stop, limits,
// faults and the touch probe, with the values and quirks that the vendor's profile states. It talks through objects of
// its station's dictionary and through nothing else.
// Once a cycle, in this order:
//   drive.advance(dt_s);        // the motor moves to this instant under the last command
//   drive.sample();             // actual values -> objects (6041h, 6064h, 60B9h ...)
//   drive.take(cycle_s, true);  // controlword, mode and target from the objects
// No allocation after construction.
#pragma once
#include <array>
#include <cstdint>
#include <optional>

#include "config/drive.hpp"
#include "devices/wire/cia402.hpp"
#include "sim/drive/drive_lies.hpp"
#include "sim/drive/drive_memory.hpp"
#include "sim/drive/drive_motion.hpp"
#include "sim/drive/homing_methods.hpp"
#include "sim/drive/motor.hpp"
#include "sim/drive/probe_latch.hpp"
#include "sim/objects/object_dictionary.hpp"

namespace gantry::sim {

class Drive402 {
 public:
  /// `slot`: which axis of the station. The dictionary, the profile behind it and the motor outlive the drive.
  Drive402(ObjectDictionary& objects, int slot, Motor& motor, double counts_per_unit, bool invert);
  Drive402(const Drive402&) = delete;
  Drive402& operator=(const Drive402&) = delete;

  void advance(double dt_s) noexcept;
  void sample() noexcept;
  /// `remote`: the station is in PRE_OP at least; below that the controlword is not executed.
  void take(double cycle_s, bool remote) noexcept;

  /// The outputs are not valid any more. Not orderly (watchdog, lost SYNC0): an enabled drive faults with its bus-loss
  /// code; orderly: it stops and disables.
  void outputs_lost(bool orderly) noexcept;
  /// As if the drive had found this error itself; what follows is its profile's row for it, a fault where it has none.
  void inject(std::uint32_t code) noexcept;
  void tell(const DriveLies& lies) noexcept;
  /// 6041h stays at what it shows now.
  void stick_statusword(bool stuck) noexcept { status_stuck_ = stuck; }
  /// The code of an emergency message that is due, once.
  std::optional<std::uint16_t> take_emergency() noexcept;

  [[nodiscard]] devices::wire::DriveState state() const noexcept { return state_; }
  [[nodiscard]] bool faulted() const noexcept;
  [[nodiscard]] DriveMemory memory() const noexcept { return {motor_->position(), motion_.count_zero()}; }
  void restore(const DriveMemory& memory) noexcept { motion_.restore(memory.position, memory.count_zero); }

 private:
  using State = devices::wire::DriveState;
  enum class HomingState : std::uint8_t { Idle, Running, Stopping, Done, Failed };
  enum class AfterStop : std::uint8_t { Nothing, Disable, Fault };

  [[nodiscard]] Object& object(std::uint16_t index, std::uint8_t sub = 0);
  [[nodiscard]] std::uint16_t statusword() const noexcept;
  [[nodiscard]] std::uint16_t enabled_statusword(const config::StatuswordRow& row) const noexcept;
  [[nodiscard]] std::uint16_t shown_error() const noexcept;
  void show_position() noexcept;
  void show_probe() noexcept;
  /// The input that the probe is wired to has the probe's function.
  [[nodiscard]] bool input_is_probes() const noexcept;
  [[nodiscard]] std::uint32_t visible(std::uint32_t inputs) const noexcept;

  void on_inputs(std::uint32_t changed, std::uint32_t levels) noexcept;
  void step_state(std::uint16_t controlword) noexcept;
  void enable() noexcept;
  void disable() noexcept;
  void leave() noexcept;
  void quick_stop() noexcept;
  void fault(std::uint16_t code) noexcept;
  void finish_stop() noexcept;
  void take_mode() noexcept;
  void follow_target(double cycle_s) noexcept;
  void take_homing(std::uint16_t controlword) noexcept;
  void start_homing() noexcept;
  void next_homing_phase() noexcept;
  void fail_homing() noexcept;
  void on_homing_input(std::uint32_t changed, std::uint32_t levels) noexcept;
  [[nodiscard]] double decel_counts_s2(const Object& object) const noexcept;

  const config::DriveFacts& facts_;
  Motor* motor_;
  DriveMotion motion_;
  ProbeLatch probe_;
  const Object* probe_input_ = nullptr;  ///< the function of its input; none: it has no other
  config::StatuswordRow status_row_;     ///< of the mode that is active

  ObjectDictionary& objects_;
  int slot_;
  std::array<Object, 32> absent_;  ///< stand in for objects that the station does not have
  std::size_t absent_used_ = 0;
  Object &controlword_, &status_, &mode_wanted_, &mode_shown_, &actual_, &velocity_, &demand_, &target_, &error_,
      &probe_function_, &probe_status_, &probe_rising_, &probe_falling_, &inputs_, &home_offset_, &homing_method_,
      &homing_fast_, &homing_slow_, &homing_acceleration_, &quick_option_, &deceleration_, &quick_deceleration_;
  std::uint32_t inputs_base_ = 0;  ///< bits of 60FDh that are always set (AMD530B)

  State state_ = State::SwitchOnDisabled;
  std::int8_t mode_ = 0, mode_before_ = 0;         ///< before_: as 6061h shows it
  int mode_wanted_for_ = 0, mode_is_new_for_ = 0;  ///< cycles
  std::uint16_t last_control_ = 0;
  bool remote_ = false;
  AfterStop after_stop_ = AfterStop::Nothing;
  bool needs_zero_control_ = false;  ///< AMD530B 8.4, after a quick stop with 605Ah 5..7
  std::int64_t target_counts_ = 0;   ///< of CSP, unwrapped
  std::uint32_t levels_ = 0;         ///< inputs when last looked at
  std::uint16_t fault_code_ = 0, warning_code_ = 0;
  bool power_cycle_needed_ = false, status_stuck_ = false;
  std::optional<std::uint16_t> emergency_;

  HomingState homing_ = HomingState::Idle;
  const HomingMethod* method_ = nullptr;
  HomingList phases_;
  bool may_bounce_ = false;
  DriveLies lies_;
  std::uint64_t noise_ = 0;
  std::int64_t samples_ = 0;  ///< since the supply came
  int enabling_ = 0;          ///< cycles for which "enable operation" waits
};

}  // namespace gantry::sim
