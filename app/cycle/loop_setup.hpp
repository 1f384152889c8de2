// What the loop must know, as plain values: made once from the machine file and the bus's layout (app/run/compose.cpp),
// before the loop starts.
#pragma once
#include <array>
#include <cstdint>

#include "app/cycle/channels.hpp"
#include "app/cycle/own_braking.hpp"
#include "config/drive.hpp"
#include "core/clock.hpp"
#include "core/rt/fixed_vector.hpp"
#include "devices/rt/drive.hpp"
#include "devices/rt/homing.hpp"
#include "devices/rt/scale.hpp"
#include "motion/types.hpp"

namespace gantry::cycle {

/// R11: three late cycles in 100 ms are too many. A machine's cycle is 0.25 ms or longer.
inline constexpr Time kLateWindow = milliseconds(100);
inline constexpr std::int64_t kMostInLateWindow = 400;
inline constexpr int kLateMax = 3;

struct DriveSetup {
  StationId station;
  AxisId axis;
  devices::DriveLayout layout;
  devices::AxisScale scale;
  /// By its manual a quick stop brakes it. Of any other drive that is not hoped for: it is braked by its targets, and
  /// its torque goes when it stands.
  bool quick_stop_brakes = false;
  double brake_give = 0;        ///< mm or rad that the axis may move while its brake is closed; 0: it has none
  bool keeps_reference = true;  ///< when its torque goes while it stands: it measures where it is, or nothing moves it
  BrakingReach reach{};         ///< of what it brakes with by itself
  BrakingReach homing_reach{};  ///< of what it stops its homing with
  config::ObjectAddress homing_ramp{devices::wire::cia402::kHomingAcceleration, 0};
  config::ObjectAddress digital_inputs{devices::wire::cia402::kDigitalInputs, 0};
  config::ObjectAddress mode_display{devices::wire::cia402::kModeDisplay, 0};
};

struct HomingSetup {
  double position = 0;  ///< coordinate at the home edge, mm or rad
  devices::HomingLimits limits;
  // Of an axis with two drives, mm:
  double skew_max = 0;      ///< how much farther one side may go than the other while both search; 0: not watched
  double square_max = 0;    ///< what squaring removes when both have homed; more is refused
  double square_speed = 1;  ///< mm/s
};

struct AxisSetup {
  bool streamed = true;
  rt::FixedVector<std::uint8_t, 2> drives;  ///< indices of LoopSetup::drives
  bool quick_stop_brakes = false;           ///< each of them by itself, and strongly enough: else all by their targets
  double following_base = 0, following_per_speed_s = 0;
  double skew_max = 0;
  double response_delay_s = 0;
  HomingSetup homing;
};

/// One bit of the output or input word in a station's process image.
struct ImageBit {
  std::uint8_t word_bit = 0;  ///< in the loop's word
  StationId station;
  std::uint16_t byte = 0;
  std::uint8_t mask = 0;
  bool invert = false;
};

struct LoopSetup {
  Time period = milliseconds(1);
  motion::Limits limits;
  rt::FixedVector<AxisSetup, kMaxAxes> axes;
  rt::FixedVector<DriveSetup, kMaxDrives> drives;
  rt::FixedVector<ImageBit, 32> outputs, inputs;
  AxisId probe_axis = kNoAxis;     ///< the probe latches on this axis's first drive
  std::uint32_t valve_mask = 0;    ///< closed by every stop
  std::uint32_t held_mask = 0;     ///< the clamp: what only an order switches, and no stop
  std::uint32_t healthy_mask = 0;  ///< toggled while all is well
  std::uint32_t brake_mask = 0;    ///< released while `brake_axis` has torque
  AxisId brake_axis = kNoAxis;
  Time brake_time{};                               ///< until it holds
  Time brake_release{};                            ///< until it is open
  std::array<std::uint32_t, kLamps> lamp_masks{};  ///< of the stack light, by Lamp
  // Inputs; 0: the machine has none. All of these are 1 while all is well.
  std::uint32_t door_mask = 0, air_mask = 0, clamp_mask = 0, stop_mask = 0, safety_mask = 0;
  std::uint32_t mode_mask = 0;  ///< 1: automatic, 0: setup
  // R10: how far a station's clock may be from the one that comes by. Where it has been for the first, it is said; at
  // the second an axis at 500 mm/s is 12 um from where the others believe it.
  std::int32_t clock_note_ns = 10'000, clock_stop_ns = 25'000;
  AxisVec walk_max{};  ///< mm or rad that an axis goes at most from where a walk began
  int stop_after_missed = 3;
  std::int64_t late_window = 100;  ///< kLateWindow in cycles
  int late_max = kLateMax;         ///< so many late cycles in it are too many
  int frames_lost_max = 3;         ///< cyclic frames in a row that may be missing (R02)
  int counter_low_max = 3;         ///< cycles in a row in which a station may not take part (R04)

  /// Without a beat for this long the loop is stuck (R62): as many as are tolerated are missing, and the next one too.
  [[nodiscard]] Time stuck_after() const noexcept { return (stop_after_missed + 1) * period; }
};

}  // namespace gantry::cycle
