#include "app/run/owner.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <set>

#include "app/job/jog.hpp"
#include "app/job/prove_homing.hpp"
#include "app/run/owner_parts.hpp"
#include "core/log.hpp"

namespace gantry::run {
namespace {

constexpr double kEnableTimeout_s = 4;
constexpr double kSettled_s = 0.005;

}  // namespace

Owner::Owner(std::unique_ptr<Parts> parts) : parts_(std::move(parts)) {}

Owner::~Owner() {
  on_step({});  // who listened was made after this owner, and is gone
  shut_down();
  if (parts_->hangs) static_cast<void>(parts_.release());
}

Owner::Turn::Turn(Parts& parts, Undertaking what, Begin begin)
    : parts_(parts), what_(what), taken_(parts.undertaking == Undertaking::None && !parts.ending) {
  if (!taken_) return;
  parts_.undertaking = what;
  parts_.button_holds = false;
  if (!parts_.on_bus) return;
  parts_.control().begin();
  parts_.on_bus->named.reset();
  if (what != Undertaking::Job) parts_.acted(std::string(name(what)));
  if (begin == Begin::AtOnce) return;
  parts_.control().hold_next(true);
  parts_.acted(std::string(name(OrderKind::Hold)));
}

Owner::Turn::~Turn() {
  if (!taken_) return;
  parts_.undertaking = Undertaking::None;
  if (parts_.on_bus) parts_.control().end();
}

Result<void> Owner::Turn::refused() const {
  if (parts_.ending) return tl::unexpected(*parts_.ending);
  return fail(Fault::Refused, refusal(what_, parts_.standing()));
}

Result<void> Owner::Parts::not_latched() {
  constexpr double kReset_s = 5;
  const auto over = [&] {
    if (on_bus->reset && !on_bus->reset_answer) on_bus->reset_answer = control().answer(*on_bus->reset);
    return !on_bus->reset || on_bus->reset_answer;
  };
  if (!over()) {
    auto r = control().wait(over, kReset_s, Error{Fault::TransitionTimeout, "the reset has no answer", ""});
    if (r) r = control().pass(seconds(machine.bus.cycle));  // what it came to is told in the cycle of the answer
    if (!r) return r;
  }
  const Fault latched = control().latest().latched;
  if (latched == Fault::None) return {};
  std::string where, words = std::string(info(latched).text);
  for (const Error& e : active.list(machine, control().latest()))
    if (e.fault == latched && !e.where.empty()) where = e.where, words = e.message;
  return fail(Fault::Latched,
              fmt::format("{} is refused while {} is latched: {}", in_quotes(undertaking),
                          std::string_view(code(latched)), words),
              where);
}

Result<void> Owner::Parts::torque() {
  if (auto r = not_latched(); !r) return r;
  if (auto r = stations_confirmed(); !r) return r;
  if (control().latest().state == cycle::State::Ready) return {};
  auto enabled = command({.kind = cycle::CommandKind::Enable}, kEnableTimeout_s);
  if (!enabled && control().latest().state == cycle::State::Enabling)
    control().post({.kind = cycle::CommandKind::Abort});  // nobody waits for it any more
  if (!enabled || on_bus->compared) return enabled;
  return still_as_given();
}

/// A drive that changes what it was given when it is enabled is not trusted: it loses its torque again.
Result<void> Owner::Parts::still_as_given() {
  bus->step_by([this] { control().step(); });
  auto same = bus->compare_parameters();
  bus->step_by({});
  if (same) same = stations_confirmed();
  on_bus->compared = same.has_value();
  if (!same) static_cast<void>(command({.kind = cycle::CommandKind::Disable}, kEnableTimeout_s));
  return same;
}

std::vector<config::HeldDoubt> Owner::Parts::held_limits() const {
  return config::held_limit_doubts(machine, [&](StationId id, config::ObjectAddress object) {
    std::optional<std::int64_t> value;
    for (std::size_t i = 0; i < bus->station_count(); ++i)
      if (bus->station(i).id == id)
        for (const auto& held : bus->station(i).held)
          if (held.object == object) value = held.value;
    return value;
  });
}

Result<void> Owner::Parts::stations_confirmed() const {
  const Error* first = nullptr;
  std::size_t all = 0;
  for (std::size_t i = 0; i < bus->station_count(); ++i) {
    const devices::BusStation& station = bus->station(i);
    if (first == nullptr && !station.doubts.empty()) first = &station.doubts.front();
    all += station.doubts.size();
  }
  for (const config::HeldDoubt& doubt : held_limits())
    if (first == nullptr && doubt.refuses)
      return fail(Fault::ParameterDiffers, doubt.text,
                  fmt::format("station '{}'", machine.stations[doubt.station.value].name));
  if (first == nullptr && raw_port && undertaking != Undertaking::Walk)
    if (const auto alike = not_told_apart(); !alike.empty()) return tl::unexpected(alike.front());
  if (first == nullptr) return {};
  Error why = *first;
  if (all > 1) why.message += fmt::format(" (and {} more: `gantry commission --all` shows them)", all - 1);
  return tl::unexpected(std::move(why));
}

bool Owner::Parts::all_referenced() const {
  return std::all_of(machine.axes.begin(), machine.axes.end(), [&](const config::Axis& axis) {
    return axis.kind != config::AxisKind::Streamed || (control().latest().referenced >> axis.id.value & 1u) != 0;
  });
}

std::uint32_t Owner::Parts::unreferenced() const {
  const std::uint32_t known = control().latest().referenced;
  return job::head_is_placed(machine, known) ? ~known : ~0u;
}

Result<void> Owner::enable() {
  const Turn turn(*parts_, Undertaking::Enable);
  if (!turn.taken()) return turn.refused();
  return parts_->torque();
}

Result<void> Owner::home(const std::vector<std::string>& axes, Begin begin) {
  const Turn turn(*parts_, Undertaking::Home, begin);
  if (!turn.taken()) return turn.refused();
  if (axes.empty()) return parts_->home();
  std::uint32_t named = 0;
  for (const std::string& name : axes) {
    const auto axis = job::axis_named(parts_->machine, name);
    if (!axis) return tl::unexpected(axis.error());
    if ((*axis)->kind == config::AxisKind::Positioned)
      return fail(Fault::PositionedAxisInMove, "it positions by itself, and is not homed by this order",
                  "axis " + name);
    named |= 1u << (*axis)->id.value;
  }
  if (!job::head_is_placed(parts_->machine, latest().referenced))
    return fail(
        Fault::NotReferenced,
        "axes are homed alone only where X, Y and Z say where the head stands; `gantry home` homes all of them, "
        "Z first");
  return parts_->home(named);
}

/// Homing watches the limits of its axes: where a station does not show them it does not begin. What is polled may have
/// to be waited for. `tell`: warns of axes whose limits the machine file leaves to the drive alone.
Result<void> Owner::Parts::see_limits(std::uint32_t named, bool tell) {
  constexpr double kFirstLook_s = 2;
  for (const config::Axis& axis : machine.axes) {
    if ((named >> axis.id.value & 1u) == 0 || !axis.homing || axis.kind != config::AxisKind::Streamed) continue;
    for (const config::DriveRef& drive : axis.drives) {
      const config::Station& s = machine.stations[drive.station.value];
      if (!s.cyclic()) continue;
      const config::ObjectAddress inputs = config::in_slot(s.profile, {0x60FD, 0}, drive.slot);
      const auto source = [&] { return bus->source(s.id, inputs); };
      const auto unseen = [&](std::string_view why) {
        return Error{Fault::SwitchesUnseen,
                     fmt::format("it is not homed: {} of station '{}' (digital inputs) {}", config::to_text(inputs),
                                 s.name, why),
                     "axis " + axis.name};
      };
      if (source() == devices::InputSource::Absent && axis.homing->limits_unseen) {
        if (tell)
          log::warn("axis {} homes without a watch over its limit switches: station '{}' does not show them", axis.name,
                    s.name);
        continue;
      }
      if (source() == devices::InputSource::Absent)
        return tl::unexpected(unseen(
            "is not there, so that its limit switches cannot be watched; `homing: {limits_unseen: true}` of this "
            "axis in the machine file leaves them to the drive alone"));
      if (auto seen = control().wait([&] { return source() != devices::InputSource::Silent; }, kFirstLook_s,
                                     unseen("is read by SDO and does not answer"));
          !seen)
        return seen;
    }
  }
  return {};
}

Result<void> Owner::Parts::home(std::uint32_t named) {
  if (in_setup()) return fail(Fault::SetupMode, std::string(info(Fault::SetupMode).text));
  for (const config::Axis& axis : machine.axes)
    if (axis.kind == config::AxisKind::Streamed && !axis.homing)
      return fail(Fault::NotReferenced,
                  "the machine file states no `homing` for it, so that nothing can say where it stands; add it",
                  "axis " + axis.name);
  if (auto r = see_limits(named); !r) return r;
  if (auto r = torque(); !r) return r;
  const cycle::Snapshot& now = control().latest();
  if (job::head_is_placed(machine, now.referenced))
    if (auto free = job::prove_homing(machine, *around, now.target, {.referenced = now.referenced, .homed = named});
        !free)
      return free;
  if (auto r = see_limits(named, true); !r) return r;  // what is polled may have grown old meanwhile
  std::set<int> orders;
  for (const config::Axis& axis : machine.axes)
    if (axis.homing && axis.kind == config::AxisKind::Streamed) orders.insert(axis.homing->order);
  for (const int order : orders) {
    std::uint32_t mask = 0;
    double timeout_s = 1;
    std::string names;
    for (const config::Axis& axis : machine.axes) {
      if (!axis.homing || axis.kind != config::AxisKind::Streamed || axis.homing->order != order) continue;
      if ((named >> axis.id.value & 1u) == 0) continue;
      mask |= 1u << axis.id.value;
      timeout_s = std::max(timeout_s, axis.homing->timeout_s + 2);
      names += (names.empty() ? "" : ", ") + axis.name;
    }
    if (mask == 0) continue;
    if (auto r = control().wait_for_resume(); !r) return r;
    log::info("homing {}", names);
    auto homed = command({.kind = cycle::CommandKind::Home, .axes = mask}, timeout_s);
    if (!homed && homed.error().fault == Fault::GantrySkew)
      homed.error().message +=
          "; one of them has gone as much farther than the other, which is more than `homing.rack_max` and braking "
          "explain: look at "
          "the beam. If it was racked before, it is so by that much less, and `reset` and `home` go on from there; if "
          "it "
          "stood square, it is racked now: a side does not see its switch";
    if (!homed) return homed;
  }
  return control().pass(kSettled_s);  // positions are reported in the new reference
}

Result<void> Owner::disable() {
  const Turn turn(*parts_, Undertaking::Disable);
  if (!turn.taken()) return turn.refused();
  return parts_->command({.kind = cycle::CommandKind::Disable}, kEnableTimeout_s);
}

void Owner::on_step(std::function<void()> poll) { parts_->poll = std::move(poll); }

Result<void> Owner::idle() {
  Control& control = parts_->control();
  control.idle();
  if (auto alive = control.alive(); !alive) return alive;
  parts_->on_bus->recovery.step(control);
  parts_->report_restarts();
  return {};
}

sim::WorldAccess* Owner::world() const { return parts_->world; }

const cycle::Snapshot& Owner::latest() const { return parts_->feed->latest(); }

std::vector<Error> Owner::active_faults() const { return parts_->active.list(parts_->machine, latest()); }

void Owner::aside(const std::function<void()>& work) {
  if (parts_->options.virtual_time || !parts_->on_bus) return work();
  parts_->aside_thread.run(work, [this] {
    static_cast<void>(idle());  // of a loop that has died whoever serves says so
    return true;
  });
}

Result<void> Owner::Parts::aside(const std::function<void()>& work) {
  if (options.virtual_time) {
    work();
    return {};
  }
  // What has ended it before is why the work is done now, such as to ask the world what lies on the board. Such a world
  // is asked in vain only where its bus is silent, too.
  const bool aborted = control().aborting(), was_over = !control().ended();
  const auto newly_over = [&] { return was_over ? !aborted && control().aborting() : !control().ended(); };
  std::optional<Time> since;
  aside_thread.run(work, [&] {
    control().idle();
    if (control().stopped() || world == nullptr) return true;  // a job that is stopped goes on
    const bool in_vain = newly_over() || (was_over && !control().latest().answered);
    if (!in_vain) since.reset();
    if (in_vain && !since) since = clock->now();
    if (since && clock->now() - *since >= kSilentWorld) world->give_up();
    return true;
  });
  return newly_over() ? control().ended() : Result<void>{};
}

Undertaking Owner::undertaking() const { return parts_->undertaking; }

}  // namespace gantry::run
