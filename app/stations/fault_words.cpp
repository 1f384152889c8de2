#include "app/stations/fault_words.hpp"

#include <fmt/format.h>
#include <numbers>

#include "app/cycle/loop_setup.hpp"
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

/// Where the drive is by its 6064h, and where it was sent.
std::string target_text(const config::Axis* axis, const cycle::Event& e) {
  const bool rotary = axis != nullptr && axis->rotary;
  const double unit = rotary ? std::numbers::pi / 180 : 1, at = e.value - e.detail / 1000.0;
  return fmt::format("6064h is at {:.3f} {}, {:.3f} was asked for", at / unit, rotary ? "deg" : "mm", e.value / unit);
}

/// What Event::detail of a fault adds, by its unit in the catalogue. An answer that names a fault counts nothing.
std::string detail_text(const config::Axis* axis, const cycle::Event& e) {
  switch (info(e.fault).detail) {
    case Detail::Distance: return fmt::format("by {} {}", e.detail, axis != nullptr && axis->rotary ? "mrad" : "um");
    case Detail::Target: return target_text(axis, e);
    case Detail::Cycles: return fmt::format("for {} cycles", e.detail);
    case Detail::LateCycles: return fmt::format("{} in {} ms", e.detail, cycle::kLateWindow / milliseconds(1));
    case Detail::Frames: return fmt::format("{} in a row", e.detail);
    case Detail::Nanoseconds: return fmt::format("by {:.1f} us", e.detail / 1000.0);
    case Detail::Microseconds: return fmt::format("by {} us", e.detail);
    case Detail::Milliseconds: return fmt::format("for {} ms", e.detail);
    case Detail::AlStates: return fmt::format("AL states seen: {:02X}h", e.detail);
    case Detail::WorkingCounter: return fmt::format("working counter {}", e.detail);
    case Detail::Statusword: return fmt::format("statusword {:04X}h", e.detail);
    case Detail::None:
    case Detail::DriveCode:
    case Detail::EmergencyCode: break;
  }
  return "";
}

bool tells_code(Fault f) { return info(f).detail == Detail::DriveCode; }

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
  } else if (const std::string more = detail_text(axis, e); !more.empty() && e.kind == cycle::EventKind::Fault) {
    error.message += " (" + more + ")";
  }
  return error;
}

std::string sender_words(const devices::MacAddress& sender) {
  constexpr auto kByStations = std::byte{2};
  std::string text = "from ";
  for (const std::byte b : sender)
    text += fmt::format("{}{:02X}", text.back() == ' ' ? "" : ":", std::to_integer<unsigned>(b));
  if ((sender[0] & kByStations) != std::byte{0}) text += " (stations set the 02h in its first byte)";
  return text;
}

}  // namespace gantry::stations
