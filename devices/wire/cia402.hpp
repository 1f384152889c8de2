// CiA 402 (IEC 61800-7-201): objects, controlword and statusword bits, modes. What a drive does with them beyond the
// standard stands in its profile.
#pragma once
#include <cstdint>
#include <string_view>

namespace gantry::devices::wire {

namespace cia402 {
// Objects of the first axis; the next one lies config::StationProfile::slot_stride higher.
inline constexpr std::uint16_t kErrorCode = 0x603F, kControlword = 0x6040, kStatusword = 0x6041,
                               kQuickStopOption = 0x605A, kMode = 0x6060, kModeDisplay = 0x6061,
                               kActualPosition = 0x6064, kActualVelocity = 0x606C, kTargetPosition = 0x607A,
                               kHomeOffset = 0x607C, kProfileVelocity = 0x6081, kProfileAcceleration = 0x6083,
                               kProfileDeceleration = 0x6084, kQuickStopDeceleration = 0x6085, kHomingMethod = 0x6098,
                               kHomingSpeeds = 0x6099, kHomingAcceleration = 0x609A, kProbeFunction = 0x60B8,
                               kProbeStatus = 0x60B9, kProbe1Rising = 0x60BA, kProbe1Falling = 0x60BB,
                               kProbe2Rising = 0x60BC, kProbe2Falling = 0x60BD, kDigitalInputs = 0x60FD,
                               kDigitalOutputs = 0x60FE, kTargetVelocity = 0x60FF, kSupportedModes = 0x6502;

// Controlword
inline constexpr std::uint16_t kSwitchOn = 0x0001, kEnableVoltage = 0x0002, kNoQuickStop = 0x0004,
                               kEnableOperation = 0x0008, kFaultReset = 0x0080, kHalt = 0x0100;
inline constexpr std::uint16_t kHomingStart = 0x0010;                                              ///< mode 6
inline constexpr std::uint16_t kNewSetPoint = 0x0010, kChangeAtOnce = 0x0020, kRelative = 0x0040;  ///< mode 1
// The commands that the standard names (table "command coding")
inline constexpr std::uint16_t kDisableVoltage = 0x0000, kShutdown = 0x0006, kSwitchOnCommand = 0x0007,
                               kEnableOperationCommand = 0x000F, kQuickStop = 0x0002;

// Statusword
inline constexpr std::uint16_t kReadyToSwitchOn = 0x0001, kSwitchedOn = 0x0002, kOperationEnabled = 0x0004,
                               kFault = 0x0008, kVoltageEnabled = 0x0010, kNoQuickStopActive = 0x0020,
                               kSwitchOnDisabled = 0x0040, kWarning = 0x0080, kRemote = 0x0200, kTargetReached = 0x0400;
inline constexpr std::uint16_t kFollowsCommand = 0x1000;                                 ///< mode 8
inline constexpr std::uint16_t kHomingAttained = 0x1000, kHomingError = 0x2000;          ///< mode 6
inline constexpr std::uint16_t kSetPointAcknowledge = 0x1000, kFollowingError = 0x2000;  ///< mode 1

// Modes of 6060h
inline constexpr std::int8_t kNoMode = 0, kProfilePosition = 1, kProfileVelocityMode = 3, kTorqueMode = 4, kHoming = 6,
                             kCsp = 8, kCsv = 9;

// Probe function 60B8h and status 60B9h ("touch probe" in the standard), probe 1 (probe 2: shifted left by 8)
inline constexpr std::uint16_t kProbeEnable = 0x0001, kProbeContinuous = 0x0002, kProbeRisingEdge = 0x0010,
                               kProbeFallingEdge = 0x0020;
inline constexpr std::uint16_t kProbeEnabled = 0x0001, kProbeRisingLatched = 0x0002, kProbeFallingLatched = 0x0004;
}  // namespace cia402

/// State of the power drive system (IEC 61800-7-201, figure 4).
enum class DriveState : std::uint8_t {
  NotReady,
  SwitchOnDisabled,
  ReadyToSwitchOn,
  SwitchedOn,
  OperationEnabled,
  QuickStopActive,
  FaultReaction,
  Fault,
  Unknown,  ///< no row of the standard's table fits
};
constexpr std::string_view name(DriveState s) noexcept {
  switch (s) {
    case DriveState::NotReady: return "not ready to switch on";
    case DriveState::SwitchOnDisabled: return "switch-on disabled";
    case DriveState::ReadyToSwitchOn: return "ready to switch on";
    case DriveState::SwitchedOn: return "switched on";
    case DriveState::OperationEnabled: return "operation enabled";
    case DriveState::QuickStopActive: return "quick stop active";
    case DriveState::FaultReaction: return "fault reaction active";
    case DriveState::Fault: return "fault";
    case DriveState::Unknown: break;
  }
  return "unknown state";
}

}  // namespace gantry::devices::wire
