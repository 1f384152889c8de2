#include "devices/rt/cia402.hpp"

#include <array>
#include <cstddef>

namespace gantry::devices {
namespace {

using namespace wire::cia402;

struct StateRow {
  std::uint16_t mask, value;
  DriveState state;
};
// IEC 61800-7-201, state coding. With mask 0x6F a fault of 0x0238 would be 0x28: bit 5 says nothing there.
constexpr std::array kStates{
    StateRow{0x4F, 0x00, DriveState::NotReady},         StateRow{0x4F, 0x40, DriveState::SwitchOnDisabled},
    StateRow{0x4F, 0x0F, DriveState::FaultReaction},    StateRow{0x4F, 0x08, DriveState::Fault},
    StateRow{0x6F, 0x21, DriveState::ReadyToSwitchOn},  StateRow{0x6F, 0x23, DriveState::SwitchedOn},
    StateRow{0x6F, 0x27, DriveState::OperationEnabled}, StateRow{0x6F, 0x07, DriveState::QuickStopActive},
};

constexpr std::size_t kStateCount = static_cast<std::size_t>(DriveState::Unknown) + 1;
constexpr std::size_t index(DriveState s) noexcept { return static_cast<std::size_t>(s); }
constexpr std::size_t index(DriveGoal g) noexcept { return static_cast<std::size_t>(g); }

constexpr std::uint16_t kOff = kDisableVoltage, kDown = kShutdown, kOn = kSwitchOnCommand,
                        kRun = kEnableOperationCommand, kStop = kQuickStop;
// Rows: goal; columns: state, in the order of DriveState. A drive that was to hold torque and shows a state which the
// standard does not know is asked to stop by itself; nothing else can be known to be safe for a moving axis.
// Out of "quick stop active" every goal but QuickStop goes through "switch-on disabled" (transition 12): transition 16,
// straight back to enabled, is optional and depends on 605Ah.
constexpr std::array<std::array<std::uint16_t, kStateCount>, 5> kWords{{
    // not ready, disabled, ready, switched on, enabled, quick stop, fault reaction, fault, unknown
    {kOff, kOff, kOff, kOff, kOff, kOff, kOff, kOff, kOff},       // Disabled
    {kOff, kDown, kDown, kDown, kDown, kOff, kOff, kOff, kOff},   // Ready
    {kOff, kDown, kOn, kOn, kOn, kOff, kOff, kOff, kStop},        // SwitchedOn
    {kOff, kDown, kOn, kRun, kRun, kOff, kOff, kOff, kStop},      // Enabled
    {kOff, kOff, kStop, kStop, kStop, kStop, kOff, kOff, kStop},  // QuickStop
}};

}  // namespace

DriveState decode(std::uint16_t statusword) noexcept {
  for (const auto& row : kStates)
    if ((statusword & row.mask) == row.value) return row.state;
  return DriveState::Unknown;
}

std::uint16_t next_controlword(DriveState state, DriveGoal goal, std::uint16_t last) noexcept {
  if (goal == DriveGoal::FaultReset)
    return state == DriveState::Fault && (last & kFaultReset) == 0 ? kFaultReset : kDisableVoltage;
  return kWords[index(goal)][index(state)];
}

bool reached(DriveState state, DriveGoal goal) noexcept {
  switch (goal) {
    case DriveGoal::Disabled:
      return state == DriveState::SwitchOnDisabled || state == DriveState::NotReady || state == DriveState::Fault;
    case DriveGoal::Ready: return state == DriveState::ReadyToSwitchOn;
    case DriveGoal::SwitchedOn: return state == DriveState::SwitchedOn;
    case DriveGoal::Enabled: return state == DriveState::OperationEnabled;
    case DriveGoal::QuickStop:
      return state == DriveState::QuickStopActive || state == DriveState::SwitchOnDisabled ||
             state == DriveState::NotReady || state == DriveState::Fault;
    case DriveGoal::FaultReset: return state == DriveState::SwitchOnDisabled;
  }
  return false;
}

bool may_follow(DriveState before, DriveState now) noexcept {
  using enum DriveState;
  if (now == before || now == Fault || now == FaultReaction || now == NotReady) return now != Unknown;
  switch (now) {
    case SwitchOnDisabled: return before != FaultReaction;  // 15 leads here from Fault alone, all others may drop here
    case ReadyToSwitchOn: return before == SwitchOnDisabled || before == SwitchedOn || before == OperationEnabled;
    case SwitchedOn: return before == ReadyToSwitchOn || before == OperationEnabled;
    case OperationEnabled: return before == SwitchedOn || before == QuickStopActive;
    case QuickStopActive: return before == OperationEnabled;
    default: return false;
  }
}

}  // namespace gantry::devices
