// What a drive holds of its own limits (speed, deviation, its soft limits, the filter of its command), beside what the
// machine file asks of the axis. What the machine file states and what cannot work is a mistake; what is a default of
// the manual, and what merely surprises, is a warning of `check`. Each names the key and the remedy.
#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>

#include "config/held_limits.hpp"
#include "config/machine_file.hpp"

namespace gantry::config {
namespace {

enum class From { MachineFile, Station, Manual };

/// A parameter of one axis of a station as it will be: asked for, else what the station was found to hold, else the
/// default of the manual.
struct Held {
  const Parameter* parameter = nullptr;
  double value = 0;  ///< in the parameter's unit
  From from = From::Manual;
};

class DriveLimits {
 public:
  DriveLimits(const Machine& machine, const Axis& axis, const DriveRef& ref, HeldValues read = {})
      : axis_(axis),
        ref_(ref),
        station_(machine.stations[ref.station.value]),
        profile_(station_.profile),
        read_(std::move(read)) {}

  struct Doubt {
    std::string text;
    std::string parameter;
    bool mistake = false;  ///< it cannot work as the machine file or the station has it
    From from = From::Manual;
  };
  std::vector<Doubt> look() {
    if (profile_.drive && axis_.unit_per_rev > 0) {
      speed();
      deviation();
      alarm_delay();
      soft_limits();
      filter();
    }
    return std::move(doubts_);
  }

 private:
  std::optional<Held> held(std::string_view name) const {
    const auto p = std::ranges::find(profile_.parameters, name, &Parameter::name);
    if (p == profile_.parameters.end()) return std::nullopt;
    const ObjectAddress address = in_slot(profile_, p->address, ref_.slot);
    const auto row = std::ranges::find(profile_.startup, address, &StartupRow::address);
    if (row != profile_.startup.end())
      return Held{&*p, static_cast<double>(row->value) / p->per_unit, From::MachineFile};
    if (const auto value = read_ ? read_(station_.id, address) : std::nullopt)
      return Held{&*p, static_cast<double>(*value) / p->per_unit, From::Station};
    const ObjectRow* object = find_object(profile_, p->address);
    if (object == nullptr || !object->initial) return std::nullopt;
    return Held{&*p, static_cast<double>(*object->initial) / p->per_unit, From::Manual};
  }

  void doubt(const Held& h, std::string text, bool mistake) {
    doubts_.push_back({fmt::format("axis {}: stations.{}.parameters.{} ({}) {}", axis_.name, station_.name,
                                   h.parameter->name, to_text(h.parameter->address), text),
                       h.parameter->name, mistake && h.from != From::Manual, h.from});
  }
  static std::string_view source(const Held& h) {
    switch (h.from) {
      case From::MachineFile: return "is";
      case From::Station: return "is not stated, and the station holds";
      case From::Manual: break;
    }
    return "is not stated and is by default";
  }

  /// 6080h, which vendors count in rpm or in pulses/s.
  void speed() {
    const auto h = held("max_speed");
    if (!h) return;
    const double per_rev_s = h->parameter->unit == "rpm" ? 60 : profile_.drive->counts_per_rev;
    const double revs_s = h->value / per_rev_s;
    const double asked = axis_.v_max / axis_.unit_per_rev;
    if (revs_s >= asked * (1 - 1e-9)) return;
    doubt(*h,
          fmt::format("{} {:.6g} {}: the drive turns at {:.6g} rpm at most, and v_max of the axis asks for {:.6g} rpm; "
                      "state at least {:.6g} {}, or lower v_max",
                      source(*h), h->value, h->parameter->unit, revs_s * 60, asked * 60, asked * per_rev_s,
                      h->parameter->unit),
          true);
  }

  /// 2102h, 2030h: at which the drive itself faults.
  void deviation() {
    const auto h = held("position_error_limit");
    if (!h || axis_.following_base <= 0) return;
    double counts_per_rev = 1;
    if (h->parameter->unit != "rev") {
      const auto encoder = held("encoder_counts");
      if (!encoder) return;
      counts_per_rev = encoder->value;
    }
    const double limit_revs = h->value / counts_per_rev;
    const double window_revs = (axis_.following_base + axis_.following_per_speed_s * axis_.v_max) / axis_.unit_per_rev;
    if (limit_revs >= window_revs * (1 - 1e-9)) return;
    doubt(*h,
          fmt::format("{} {:.6g} {}: the drive faults at {:.6g} revolutions behind, before the window of the axis "
                      "({:.6g} at v_max) does; state at least {:.6g} {}, or make `following` narrower",
                      source(*h), h->value, h->parameter->unit, limit_revs, window_revs,
                      std::ceil(window_revs * counts_per_rev * h->parameter->per_unit) / h->parameter->per_unit,
                      h->parameter->unit),
          false);
  }

  /// 2041h: how long the drive lets a deviation last.
  void alarm_delay() {
    constexpr double kLong_ms = 1000;
    const auto h = held("position_error_delay");
    if (!h || h->value <= kLong_ms) return;
    doubt(*h,
          fmt::format("{} {:.6g} ms: for so long the drive itself lets a blocked motor push, when nobody watches "
                      "`following`; state 200 ms or so",
                      source(*h), h->value),
          false);
  }

  /// 607Dh, 213Dh/213Fh: counts from the home edge.
  void soft_limits() {
    const auto low = held("soft_limit_low"), high = held("soft_limit_high"), on = held("soft_limits_on");
    if (!low || !high || !axis_.homing || (on && on->value == 0)) return;
    const double sign = ref_.invert ? -1 : 1;
    const auto counts = [&](double at) { return sign * (at - axis_.homing->position) * axis_.counts_per_unit; };
    const double a = counts(axis_.p_min), b = counts(axis_.p_max);
    if (low->value > std::min(a, b))
      doubt(*low,
            fmt::format("{} {:.10g}, and the travel of the axis goes down to {:.10g}; state that or less", source(*low),
                        low->value, std::floor(std::min(a, b))),
            true);
    if (high->value < std::max(a, b))
      doubt(*high,
            fmt::format("{} {:.10g}, and the travel of the axis goes up to {:.10g}; state that or more", source(*high),
                        high->value, std::ceil(std::max(a, b))),
            true);
  }

  /// 2010h in ms; 20E0h of the others has no unit.
  void filter() {
    const auto h = held("filter");
    if (!h || h->parameter->unit != "ms" || h->value <= axis_.response_delay_s * 1e3 * (1 + 1e-9)) return;
    doubt(*h,
          fmt::format(
              "{} {:.6g} ms, more than response_delay of the axis ({:.6g} ms): the axis will be later than is "
              "compensated; state a shorter filter, or measure with `gantry commission {}` and state what it finds",
              source(*h), h->value, axis_.response_delay_s * 1e3, axis_.name),
          false);
  }

  const Axis& axis_;
  const DriveRef& ref_;
  const Station& station_;
  const StationProfile& profile_;
  HeldValues read_;
  std::vector<Doubt> doubts_;
};

}  // namespace

void check_drive_limits(const Machine& m, const written::MachineFile& file, Mistakes& mistakes) {
  for (const Axis& axis : m.axes)
    for (const DriveRef& ref : axis.drives)
      for (const auto& doubt : DriveLimits(m, axis, ref).look()) {
        if (!doubt.mistake) continue;
        const auto& station = file.stations[ref.station.value];
        const auto row = std::ranges::find(station.parameters, doubt.parameter, &written::SettingRow::name);
        mistakes.add(Fault::Inconsistent, doubt.text,
                     row != station.parameters.end() ? row->location : station.location);
      }
}

std::vector<std::string> drive_limit_notes(const Machine& m) {
  std::vector<std::string> out;
  for (const Axis& axis : m.axes)
    for (const DriveRef& ref : axis.drives)
      for (auto& doubt : DriveLimits(m, axis, ref).look())
        if (!doubt.mistake) out.push_back("warning: " + std::move(doubt.text));
  return out;
}

std::vector<HeldDoubt> held_limit_doubts(const Machine& m, const HeldValues& read) {
  std::vector<HeldDoubt> out;
  for (const Axis& axis : m.axes)
    for (const DriveRef& ref : axis.drives)
      for (auto& doubt : DriveLimits(m, axis, ref, read).look())
        if (doubt.from == From::Station) out.push_back({std::move(doubt.text), ref.station, doubt.mistake});
  return out;
}

std::vector<StartupRow> not_pinned(const StationProfile& profile) {
  std::vector<StartupRow> out;
  for (const Parameter& p : profile.parameters)
    for (int slot = 0; slot < std::max(profile.slots, 1); ++slot) {
      const ObjectAddress address = in_slot(profile, p.address, slot);
      if (slot > 0 && address == p.address) break;
      if (std::ranges::find(profile.startup, address, &StartupRow::address) != profile.startup.end()) continue;
      const ObjectRow* object = find_object(profile, p.address);
      out.push_back(
          {address, p.type, object != nullptr ? object->initial.value_or(0) : 0, p.why, p.name, p.rule, p.acts, false});
    }
  return out;
}

bool is_limit(const StartupRow& row) {
  constexpr std::array kLimits{"max_speed",      "position_error_limit", "position_error_delay",
                               "soft_limit_low", "soft_limit_high",      "soft_limits_on",
                               "filter",         "encoder_counts"};
  return std::ranges::find(kLimits, row.name) != kLimits.end();
}

}  // namespace gantry::config
