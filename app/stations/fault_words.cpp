#include "app/stations/fault_words.hpp"

#include <fmt/format.h>

#include "devices/profiles/fault_text.hpp"

namespace gantry::stations {
namespace {

const config::Axis* axis_of(const config::Machine& machine, AxisId id) {
  return id.value < machine.axes.size() ? &machine.axes[id.value] : nullptr;
}

/// The one that the event names; an axis of one drive has no other.
const config::Station* station_of(const config::Machine& machine, const cycle::Event& e, const config::Axis* axis) {
  const bool only = e.station == cycle::kNoStation && axis != nullptr && axis->drives.size() == 1;
  const StationId id = only ? axis->drives.front().station : e.station;
  for (const config::Station& s : machine.stations)
    if (s.id == id) return &s;
  return nullptr;
}

/// What Event::detail adds, by fault.
std::string detail_text(const config::Axis* axis, const cycle::Event& e) {
  const char* unit = axis != nullptr && axis->rotary ? "mrad" : "um";
  switch (e.fault) {
    case Fault::FollowingError: return fmt::format("it lags its target by {} {}", e.detail, unit);
    case Fault::GantrySkew: return fmt::format("by {} {}", e.detail, unit);
    case Fault::ControllerStalled: return fmt::format("for {} cycles", e.detail);
    case Fault::WatchdogStop: return fmt::format("for {} ms", e.detail);
    case Fault::LateCycle: return fmt::format("by {} us", e.detail);
    case Fault::LateCycles: return fmt::format("{} of the last 100", e.detail);
    case Fault::CycleOverrun: return fmt::format("it took {} us", e.detail);
    case Fault::StationLeftOp: return fmt::format("AL states seen: {:02X}h", e.detail);
    case Fault::WorkingCounterLow:
    case Fault::WorkingCounterLost:
    case Fault::WorkingCounterHigh: return fmt::format("working counter {}", e.detail);
    case Fault::DcNotLocked:
    case Fault::DcLost: return fmt::format("by {:.1f} us", e.detail / 1000.0);
    case Fault::DriveDropped:
    case Fault::ImpossibleStatus:
    case Fault::TransitionTimeout:
    case Fault::WrongMode: return fmt::format("statusword {:04X}h", e.detail);
    default: return "";
  }
}

bool tells_code(Fault f) {
  return f == Fault::DriveFault || f == Fault::DriveWarning || f == Fault::DriveEmergencyInput ||
         f == Fault::Undervoltage || f == Fault::LimitSwitch;
}

}  // namespace

Error in_words(const config::Machine& machine, const cycle::Event& e) {
  const FaultInfo& row = info(e.fault);
  const config::Axis* axis = axis_of(machine, e.axis);
  const config::Station* station = station_of(machine, e, axis);
  const bool named = station != nullptr && (e.station == station->id || tells_code(e.fault));
  Error error{e.fault, std::string(row.text), axis != nullptr ? "axis " + axis->name : ""};
  if (named)
    error.where += fmt::format("{}station {} '{}'", error.where.empty() ? "" : ", ", station->position, station->name);
  if (station != nullptr && tells_code(e.fault) && e.detail != 0) {
    const auto text = devices::fault_text(station->profile, static_cast<std::uint32_t>(e.detail));
    error.message += ": " + text.text;
    if (!text.remedy.empty()) error.message += "; " + text.remedy;
  } else if (const std::string more = detail_text(axis, e); !more.empty()) {
    error.message += " (" + more + ")";
  }
  return error;
}

}  // namespace gantry::stations
