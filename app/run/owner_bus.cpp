// An owner's bus: from its first scan to the running loop, and down again in order.
#include "app/run/owner_parts.hpp"
#include "app/stations/accepted.hpp"
#include "app/stations/fault_words.hpp"
#include "config/look_alikes.hpp"
#include "core/log.hpp"

namespace gantry::run {
namespace {

constexpr double kOperationTimeout_s = 5;
constexpr int kOperationAttempts = 2;
constexpr double kLockTimeout_s = 5;
constexpr double kFirstCycles_s = 0.02;
constexpr double kDisableTimeout_s = 0.5, kDisableLeast_s = 0.02;
constexpr double kBrakesTimeout_s = 3.5;  // of a bus that answers: a stop may take 3 s until the torque goes

/// The catalogue numbers what drives report 2xx.
bool of_a_drive(Fault fault) { return static_cast<int>(fault) / 100 == 2; }

}  // namespace

Result<void> Owner::bring_up() {
  Parts& p = *parts_;
  const Turn turn(p, Undertaking::BringUp);
  if (!turn.taken()) return turn.refused();
  if (p.on_bus) return fail(Fault::Refused, "the bus is up already");
  if (p.options.interrupted != nullptr) p.bus->heed(p.options.interrupted);
  const auto up = p.bus->bring_up();
  p.bus->heed({});
  if (!up && p.options.interrupted != nullptr && p.options.interrupted())
    return fail(Fault::Interrupted, "interrupted while the bus was brought up; nothing has moved");
  if (!up) return up;
  for (const std::string& note : p.bus->notes()) log::info("{}", note);
  for (std::size_t i = 0; i < p.bus->station_count(); ++i)
    for (const Error& doubt : p.bus->station(i).doubts) log::warn("{}", to_text(doubt));
  for (const config::HeldDoubt& doubt : p.held_limits()) log::warn("{}", doubt.text);
  for (const std::string& doubt : config::look_alikes(p.machine)) log::warn("{}", doubt);
  for (const config::Station& s : p.machine.stations)
    if (s.accepted && !s.accepted->walked.empty() && !config::walked(p.machine, s))
      log::warn("station '{}' was walked {} as '{}', and the machine file says '{}' now: `gantry commission --walk`",
                s.name, s.accepted->walked, s.accepted->walked_as, config::wiring_of(p.machine, s));
  if (const std::string names = p.only_assumed(); !names.empty())
    log::info("what {} are is assumed, and was found so; `gantry commission --all --accept` confirms it", names);
  p.note_restarts();
  p.make_on_bus(p.bus->first_cycle(p.clock->now() + milliseconds(5)));
  return p.go_on_bus();
}

/// Stations on a wire whose identity no manual states and nobody has accepted; a walk does not say what they are.
std::string Owner::Parts::only_assumed() const {
  std::string names;
  for (const config::Station& s : machine.stations)
    if (raw_port && s.bus == config::BusKind::EtherCat && s.profile.identity.assumed &&
        !(s.accepted && s.accepted->compared))
      names += (names.empty() ? "'" : ", '") + s.name + "'";
  return names;
}

/// A station whose supply was off since parameters were written to it acts by them now.
void Owner::Parts::note_restarts() {
  bool any = false;
  for (std::size_t i = 0; i < bus->station_count(); ++i)
    for (config::Station& station : machine.stations)
      if (station.id == bus->station(i).id && bus->station(i).since_power_up && station.restart_pending)
        station.restart_pending = false, any = true;
  if (!any) return;
  const auto kept = stations::write_accepted(stations::accepted_file(options.state, options.bus), machine);
  if (!kept) log::report(kept.error());
}

void Owner::Parts::make_on_bus(Time first) {
  on_bus = std::make_unique<OnBus>(*bus, machine);
  if (options.virtual_time) {
    on_bus->pump = std::make_unique<VirtualPump>(*loop, *clock, first);
  } else {
    on_bus->thread = std::make_unique<cycle::LoopThread>(*loop, *clock, *channels, first, loop_cpu->number());
    on_bus->pump = std::make_unique<RealPump>(*clock, machine.bus.cycle);
    if (!on_bus->thread->rights().refused.empty())
      log::warn("no real-time rights: the system refused {}; cycles may come late", on_bus->thread->rights().refused);
  }
  on_bus->control = std::make_unique<Control>(*channels, *feed, *on_bus->pump, machine.bus.cycle,
                                              [this](const cycle::Event& e) { return stations::in_words(machine, e); });
  control().on_step([this] {
    if (publisher) publisher->poll(clock->now());
    heed_buttons();
    raise_when_shut();
    if (poll) poll();
  });
  control().serve_by([this] { serve(); });
}

Result<void> Owner::Parts::go_on_bus() {
  if (auto r = control().pass(kFirstCycles_s); !r) return r;
  Result<void> operational;
  for (int attempt = 0; attempt < kOperationAttempts; ++attempt) {  // a station may refuse while it is still busy
    if (auto r = bus->request_operation(); !r) return r;
    operational = control().wait([&] { return control().latest().state != cycle::State::Offline; },
                                 kOperationTimeout_s / kOperationAttempts,
                                 Error{Fault::StateChangeRefused, "the stations did not come to OP", ""});
    if (operational || operational.error().fault != Fault::StateChangeRefused) break;
  }
  if (!operational) {
    if (auto why = bus->check_operation(); !why) return why;
    if (!of_a_drive(operational.error().fault)) return with_stations(operational);
  }
  if (stop) {
    on_bus->watchdog = std::make_unique<cycle::Watchdog>(*stop, *clock, stuck_after);
    on_bus->crash_stop = std::make_unique<cycle::CrashStop>(*stop);
    if (on_bus->thread->rights().priority && !on_bus->watchdog->rights().priority)
      log::warn("the loop's watchdog has no real-time rights: the system refused {}",
                on_bus->watchdog->rights().refused);
  }
  // A drive may come up with a fault of its own, and this owner is who can reset it: that ends no bring-up.
  const auto locked = [&] { return control().latest().in_time; };
  const CycleIndex give_up = control().latest().cycle + control().cycles(kLockTimeout_s);
  while (!locked() && control().latest().cycle < give_up && control().alive() && !control().aborting())
    control().idle();
  if (const auto& fault = control().fault(); fault && !of_a_drive(fault->fault))
    return with_stations(tl::unexpected(*fault));
  if (auto r = control().not_aborted(); !r) return r;
  if (locked()) return {};
  return fail(Fault::DcNotLocked, "the loop did not lock to the bus's reference clock");
}

void Owner::shut_down() {
  Parts& p = *parts_;
  if (!p.on_bus) return;
  p.note_restarts();
  // Torque off in order, as far as the machine still answers; then the bus.
  p.control().post({.kind = cycle::CommandKind::Disable});
  const CycleIndex begin = p.control().latest().cycle;
  const double brake_s = p.machine.brake ? p.machine.brake->time_s : 0;  // torque stays until it holds
  const CycleIndex least = p.control().cycles(kDisableLeast_s);
  const auto passed = [&] { return p.control().latest().cycle - begin; };
  const auto most = [&] {
    return p.control().cycles((p.control().latest().inputs_fresh ? kBrakesTimeout_s : kDisableTimeout_s) + brake_s);
  };
  while (p.control().alive() && passed() < most() && (p.control().latest().enabled != 0 || passed() < least))
    p.control().step();
  if (const cycle::Snapshot& last = p.control().latest(); last.inputs_fresh)
    for (const config::Axis& axis : p.machine.axes)
      if ((last.enabled >> axis.id.value & 1u) != 0)
        log::warn(
            "axis {}: a drive of it keeps its torque; nothing but the watchdog of its station may take it now, or its "
            "supply",
            axis.name);
  p.on_bus->watchdog.reset();
  if (p.on_bus->thread && !p.on_bus->thread->join()) {
    p.hangs = true;
    log::report(Error{Fault::LoopDied, std::string(info(Fault::LoopDied).text), ""});
    return;  // the port is still the loop's; the stations' watchdogs have answered
  }
  const std::size_t told = p.bus->notes().size();
  p.bus->shut_down();
  for (std::size_t i = told; i < p.bus->notes().size(); ++i) log::warn("{}", p.bus->notes()[i]);
  p.on_bus->crash_stop.reset();
  p.on_bus.reset();
}

}  // namespace gantry::run
