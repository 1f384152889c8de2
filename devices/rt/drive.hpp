// One CiA 402 axis on a station. A station may carry several (STD402EC: two, objects 0x800 apart, manual 10.2); the
// layout says where in the station's image this one lives.
//   Drive x(layout, scale, {.cycle = milliseconds(1)});   // once, after bring_up(); layout from map_drive()
//   const Feedback& f = x.read(inputs, fresh);            // every cycle: counts -> mm, statusword -> state
//   x.write(outputs, {.goal = DriveGoal::Enabled, .target = mm});   // every cycle: controlword and target
// Bumpless: the target that goes out equals the actual position until the drive is in Operation Enabled and shows mode
// CSP; from then on (Feedback::takes_targets) it is the caller's, who starts from commanded(). While a drive with
// torque changes its mode, the target stands. Lives in the RT loop: no allocation, no lock, no exception.
#pragma once
#include <cstdint>
#include <span>

#include "core/clock.hpp"
#include "core/fault.hpp"
#include "core/rt/fixed_vector.hpp"
#include "devices/input_source.hpp"
#include "devices/rt/cia402.hpp"
#include "devices/rt/pdo.hpp"
#include "devices/rt/scale.hpp"

namespace gantry::devices {

/// What a value of 603Fh means for the machine, from the profile's error rows.
struct CodeMeaning {
  std::uint32_t code = 0;
  Fault fault = Fault::DriveFault;
  bool without_fault_bit = false;  ///< counts although 6041h shows no fault: emergency input, limits, warnings (R31)
};

/// Where one axis lives in its station's process image, and the facts of its drive that the loop needs.
struct DriveLayout {
  // outputs
  PdoField<std::uint16_t> controlword;
  PdoField<std::int8_t> mode;
  PdoField<std::int32_t> target;
  PdoField<std::uint16_t> probe_function;
  // inputs
  PdoField<std::uint16_t> statusword;
  PdoField<std::int8_t> mode_display;
  PdoField<std::int32_t> position;
  PdoField<std::uint16_t> error_code;
  PdoField<std::uint16_t> probe_status;
  PdoField<std::int32_t> probe_rising, probe_falling;
  PdoField<std::uint32_t> digital_inputs;
  // bits of digital_inputs and of probe_status; -1: not known
  std::int8_t neg_limit_bit = -1, pos_limit_bit = -1, home_bit = -1, probe_level_bit = -1;
  std::int8_t follows_bit = -1, limit_bit = -1;  ///< of the statusword, the first in CSP; -1: the manual states none
  bool closed_loop = false;                      ///< false: the position is the command, not a measurement
  rt::FixedVector<CodeMeaning, 32> codes;
};

/// What one cycle says about the axis. Where inputs are stale, everything but `fresh`, `jumped` and `fault` is of the
/// last good cycle.
struct Feedback {
  bool fresh = false;
  DriveState state = DriveState::NotReady;
  std::uint16_t statusword = 0;
  std::int8_t mode = 0;
  Counts counts;
  double position = 0;  ///< mm or rad
  std::uint16_t error_code = 0;
  std::uint32_t digital_inputs = 0;
  InputSource inputs = InputSource::EveryCycle;  ///< how digital_inputs come from the station
  bool neg_limit = false, pos_limit = false, home = false;
  bool limit_shown = false;    ///< by the statusword, where the manual states its bit
  bool follows = true;         ///< its targets in CSP; false where the statusword says that it does not
  bool takes_targets = false;  ///< Operation Enabled and in CSP: write() passes the caller's target on
  std::uint16_t probe_status = 0;
  bool probe_level = false;
  Counts probe_rising, probe_falling;  ///< latched counts, unwrapped beside `counts`
  /// The counter has moved farther since the last good cycle than the axis can travel in that time, whatever else is
  /// wrong: the reference no longer holds. `fault` names it only where nothing graver is wrong.
  bool jumped = false;
  Fault fault = Fault::None;  ///< what is wrong now; nothing is latched here
};

/// What the loop wants of the drive in this cycle.
struct DriveCommand {
  DriveGoal goal = DriveGoal::Disabled;
  std::int8_t mode = wire::cia402::kCsp;
  double target = 0;                 ///< mm or rad
  std::uint16_t mode_bits = 0;       ///< bits 4 to 6 and 8 of the controlword; sent in Operation Enabled only
  std::uint16_t probe_function = 0;  ///< 60B8h, see ProbeArm
};

struct DriveOptions {
  Time cycle = milliseconds(1);
  double step_max = 0;  ///< mm or rad that one cycle may show of the axis; more is a jump; 0: not judged
  double travel = 0;    ///< of them, what the axis does in one cycle at full speed; 0: all
};

class Drive {
 public:
  Drive() = default;
  Drive(const DriveLayout& layout, const AxisScale& scale, const DriveOptions& options = {}) noexcept;

  /// `fresh`: the inputs are of this cycle's exchange (FieldBus::fresh). `elapsed`: cycles since the last call,
  /// more than 1 when the host stalled: the drive then catches up with a target that went on meanwhile (R61).
  /// `digital_inputs`, `mode`: how these come from the station. A mode that is not in every cycle's inputs may be shown
  /// later.
  const Feedback& read(std::span<const std::byte> inputs, bool fresh, std::int64_t elapsed = 1,
                       InputSource digital_inputs = InputSource::EveryCycle,
                       InputSource mode = InputSource::EveryCycle) noexcept;
  void write(std::span<std::byte> outputs, const DriveCommand& command) noexcept;

  [[nodiscard]] const Feedback& feedback() const noexcept { return feedback_; }
  /// The target as it was last sent, in mm or rad: where a caller starts from when takes_targets turns true.
  [[nodiscard]] double commanded() const noexcept { return scale_.to_position(sent_); }
  [[nodiscard]] Counts commanded_counts() const noexcept { return sent_; }
  [[nodiscard]] const AxisScale& scale() const noexcept { return scale_; }

  /// Its station has stopped taking part: nothing of what was known of the drive counts any more. When it comes back,
  /// it begins anew, with its counter as it is then.
  void lose() noexcept;

  /// After homing: the drive has set its counter so that the home edge has the counts `home` (607Ch); that edge is the
  /// coordinate `position`. Standing, and not while targets are followed.
  void set_reference(Counts home, double position) noexcept;
  /// The target that was sent last is the coordinate `position` from now on. It stays on the wire as it is, so that a
  /// drive with torque does not leap to where its counter says that it stands.
  void call_target(double position) noexcept;

 private:
  [[nodiscard]] Fault judge(DriveState before, bool gap) noexcept;
  [[nodiscard]] Fault judge_code() const noexcept;
  void count_missed(bool fresh, std::int64_t elapsed) noexcept;
  [[nodiscard]] bool judge_step(Counts before) noexcept;
  [[nodiscard]] std::uint16_t reset_word() noexcept;

  DriveLayout layout_;
  AxisScale scale_;
  Unwrap unwrap_;
  Feedback feedback_;
  DriveGoal goal_ = DriveGoal::Disabled;
  std::int8_t mode_ = wire::cia402::kCsp;
  std::uint16_t word_ = 0;  ///< controlword as last sent
  Counts sent_;
  bool target_stands_ = false;  ///< it has torque and is not homing: sent_ does not go after its position
  std::int64_t step_max_counts_ = 0, travel_counts_ = 0;
  std::int64_t timeout_cycles_ = 1000, mode_grace_cycles_ = 100, polled_mode_grace_cycles_ = 1000;
  bool mode_is_polled_ = false;
  std::int64_t waiting_ = 0;     ///< cycles without progress towards the goal
  std::uint16_t passed_ = 0;     ///< states since the goal was set, a bit each: one that is seen again is no progress
  std::int64_t mode_asked_ = 0;  ///< cycles since the mode was asked for
  int level_held_ = 0;           ///< acknowledged cycles for which bit 7 has had its level
  std::int64_t stale_ = 0;       ///< cycles since the last fresh inputs
  std::int64_t missed_ = 0;      ///< cycles in which nobody could look, before the last inputs
  int catching_up_ = 0;          ///< cycles for which the drive may go faster than it can, towards its target
  bool known_ = false;           ///< inputs were fresh at least once since it is there
  bool asked_to_home_ = false;   ///< mode 6 was asked for and may still be shown: the drive may set its counter
};

}  // namespace gantry::devices
