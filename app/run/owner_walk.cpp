// An owner's walk: one axis goes a short distance and back in setup, and what a person has seen is kept with the
// stations.
#include <algorithm>
#include <fmt/format.h>

#include "app/job/jog.hpp"
#include "app/job/walk.hpp"
#include "app/run/owner_parts.hpp"
#include "app/stations/accepted.hpp"
#include "config/look_alikes.hpp"
#include "config/same_device.hpp"

namespace gantry::run {

Result<void> Owner::walk(const std::string& axis) {
  const Turn turn(*parts_, Undertaking::Walk);
  if (!turn.taken()) return turn.refused();
  return parts_->walk(axis);
}

Result<void> Owner::Parts::walk(const std::string& name) {
  const auto axis = job::axis_named(machine, name);
  if (!axis) return tl::unexpected(axis.error());
  if ((*axis)->kind == config::AxisKind::Positioned)
    return fail(Fault::PositionedAxisInMove, "it positions by itself, and a walk moves only axes that get targets",
                "axis " + name);
  if (machine.inputs[static_cast<std::size_t>(config::Input::Mode)] && !in_setup())
    return fail(Fault::Refused, "an axis walks in setup only; turn the mode switch to setup");
  if (auto r = torque(); !r) return r;
  const cycle::Snapshot& now = control().latest();
  const bool placed = job::know_position(machine, now.referenced, 0).has_value();
  const auto planned = job::plan_walk(machine, *around, now.target, **axis, placed);
  if (!planned) return tl::unexpected(planned.error());
  const auto played = control().play(*planned, cycle::Purpose::Walk);
  if (played) return {};
  Error why = played.error();
  if (why.fault == Fault::LimitSwitch && now.latched == Fault::None)
    why.message =
        "it stands on a limit switch, and nothing knows how far behind it: without torque, move it off by hand";
  return with_stations(tl::unexpected(std::move(why)));
}

Result<void> Owner::keep_walk(const std::string& date) {
  Parts& p = *parts_;
  for (std::size_t i = 0; i < p.bus->station_count(); ++i) {
    const devices::BusStation& found = p.bus->station(i);
    for (config::Station& s : p.machine.stations) {
      const std::string wiring = config::wiring_of(p.machine, s);
      if (s.id != found.id || wiring.empty()) continue;
      s.accepted = config::kept_of(s, found, date);
      s.accepted->walked = date;
      s.accepted->walked_as = wiring;
    }
  }
  return stations::write_accepted(stations::accepted_file(p.options.state, p.options.bus), p.machine);
}

Result<bool> Owner::forget_walk() {
  Parts& p = *parts_;
  bool any = false;
  for (config::Station& s : p.machine.stations) {
    if (!s.accepted || config::wiring_of(p.machine, s).empty()) continue;
    s.accepted->serial = 0;
    s.accepted->walked.clear(), s.accepted->walked_as.clear();
    any = true;
  }
  if (!any) return false;
  auto written = stations::write_accepted(stations::accepted_file(p.options.state, p.options.bus), p.machine);
  if (!written) return tl::unexpected(written.error());
  return true;
}

/// As the stations were found on the bus.
std::vector<Error> Owner::Parts::not_told_apart() const {
  const auto found = [&](StationId id) -> const devices::BusStation* {
    for (std::size_t i = 0; i < bus->station_count(); ++i)
      if (bus->station(i).id == id) return &bus->station(i);
    return nullptr;
  };
  const auto alike = config::not_told_apart(machine, [&](const config::Station& s) {
    const devices::BusStation* its = found(s.id);
    return its == nullptr ? std::nullopt : std::optional(its->serial);
  });
  std::vector<Error> doubts;
  for (const config::Alike& a : alike) doubts.push_back({Fault::IdentityMismatch, a.text, found(a.station)->where});
  return doubts;
}

}  // namespace gantry::run
