#include "app/run/owner.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <fmt/format.h>
#include <set>

#include "app/run/owner_parts.hpp"
#include "app/stations/fault_words.hpp"
#include "core/log.hpp"

namespace gantry::run {
namespace {

constexpr double kOperationTimeout_s = 5;
constexpr int kOperationAttempts = 2;
constexpr double kEnableTimeout_s = 4;
constexpr double kSettled_s = 0.005;
constexpr Time kLockTimeout = std::chrono::seconds(5);
constexpr std::int32_t kLocked_ns = 100'000;  // phase error below which SYNC0 and our frames are well apart

/// The catalogue numbers what drives report 2xx.
bool of_a_drive(Fault fault) { return static_cast<int>(fault) / 100 == 2; }

}  // namespace

Owner::Owner(std::unique_ptr<Parts> parts) : parts_(std::move(parts)) {}

Owner::~Owner() {
  shut_down();
  if (parts_->hangs) static_cast<void>(parts_.release());
}

Result<void> Owner::bring_up() {
  Parts& p = *parts_;
  if (auto r = p.bus->bring_up(); !r) return r;
  for (const std::string& note : p.bus->notes()) log::debug("{}", note);
  const Time first = p.bus->first_cycle(p.clock->now() + milliseconds(5));
  if (p.options.virtual_time) {
    p.pump = std::make_unique<VirtualPump>(*p.loop, *p.clock, first);
  } else {
    p.thread = std::make_unique<cycle::LoopThread>(*p.loop, *p.clock, *p.channels, first, p.loop_cpu->number());
    p.pump = std::make_unique<RealPump>(*p.clock, p.machine.bus.cycle);
    if (!p.thread->rights().refused.empty())
      log::warn("no real-time rights: the system refused {}; cycles may come late", p.thread->rights().refused);
  }
  p.control = std::make_unique<Control>(*p.channels, *p.feed, *p.pump,
                                        [&p](const cycle::Event& e) { return stations::in_words(p.machine, e); });
  p.control->on_step([&p] { p.on_step(); });
  p.recovery = std::make_unique<Recovery>(*p.bus);
  p.culprits = std::make_unique<stations::Culprits>(*p.bus);
  p.news = std::make_unique<stations::StationNews>(*p.bus, p.machine);
  p.up = true;

  if (auto r = p.control->pass(0.02); !r) return r;
  Result<void> operational;
  for (int attempt = 0; attempt < kOperationAttempts; ++attempt) {  // a station may refuse while it is still busy
    if (auto r = p.bus->request_operation(); !r) return r;
    operational = p.control->wait([&] { return p.control->latest().state != cycle::State::Offline; },
                                  kOperationTimeout_s / kOperationAttempts,
                                  Error{Fault::StateChangeRefused, "the stations did not come to OP", ""});
    if (operational || operational.error().fault != Fault::StateChangeRefused) break;
  }
  if (!operational) {
    if (auto why = p.bus->check_operation(); !why) return why;
    if (!of_a_drive(operational.error().fault)) return operational;
  }
  if (p.stop) {
    p.watchdog = std::make_unique<cycle::Watchdog>(*p.stop, *p.clock, p.stuck_after);
    p.crash_stop = std::make_unique<cycle::CrashStop>(*p.stop);
    if (p.thread->rights().priority && !p.watchdog->rights().priority)
      log::warn("the loop's watchdog has no real-time rights: the system refused {}", p.watchdog->rights().refused);
  }
  // A drive may come up with a fault of its own, and this owner is who can reset it: that ends no bring-up.
  const auto locked = [&] { return std::abs(p.control->latest().dc_error_ns) < kLocked_ns; };
  const CycleIndex give_up = p.control->latest().cycle + kLockTimeout / p.machine.bus.cycle;
  while (!locked() && p.control->latest().cycle < give_up && p.control->alive()) p.control->step();
  if (const auto& fault = p.control->fault(); fault && !of_a_drive(fault->fault)) return tl::unexpected(*fault);
  if (locked()) return {};
  return fail(Fault::DcNotLocked, "the loop did not lock to the bus's reference clock");
}

Result<void> Owner::Parts::not_latched() const {
  const Fault latched = control->latest().latched;
  if (latched == Fault::None) return {};
  return fail(Fault::Latched, fmt::format("{} is latched: {}", code(latched), info(latched).text));
}

Result<void> Owner::Parts::torque() {
  if (auto r = not_latched(); !r) return r;
  if (control->latest().state != cycle::State::Disabled) return {};
  return command({.kind = cycle::CommandKind::Enable}, kEnableTimeout_s);
}

Result<void> Owner::enable() {
  Parts& p = *parts_;
  if (auto r = p.torque(); !r) return r;
  for (const config::Axis& axis : p.machine.axes)
    if (axis.homing && axis.kind == config::AxisKind::Streamed &&
        (p.control->latest().referenced >> axis.id.value & 1u) == 0)
      return home();
  return {};
}

Result<void> Owner::home() {
  Parts& p = *parts_;
  auto done = p.home();
  if (p.recording == nullptr) p.control->forget_abort();
  return done;
}

Result<void> Owner::Parts::home() {
  if (auto r = torque(); !r) return r;
  std::set<int> orders;
  for (const config::Axis& axis : machine.axes)
    if (axis.homing && axis.kind == config::AxisKind::Streamed) orders.insert(axis.homing->order);
  for (const int order : orders) {
    std::uint32_t mask = 0;
    double timeout_s = 1;
    std::string names;
    for (const config::Axis& axis : machine.axes) {
      if (!axis.homing || axis.kind != config::AxisKind::Streamed || axis.homing->order != order) continue;
      mask |= 1u << axis.id.value;
      timeout_s = std::max(timeout_s, axis.homing->timeout_s + 2);
      names += (names.empty() ? "" : ", ") + axis.name;
    }
    log::info("homing {}", names);
    if (auto r = command({.kind = cycle::CommandKind::Home, .axes = mask}, timeout_s); !r) return r;
  }
  return control->pass(kSettled_s);  // positions are told in the new reference
}

Result<void> Owner::disable() { return parts_->command({.kind = cycle::CommandKind::Disable}, kEnableTimeout_s); }

void Owner::shut_down() {
  Parts& p = *parts_;
  if (!p.up) return;
  p.up = false;
  // Torque off in order, as far as the machine still answers; then the bus.
  p.control->post({.kind = cycle::CommandKind::Disable});
  for (int i = 0; i < 500 && (p.control->latest().enabled != 0 || i < 20); ++i) p.control->step();
  p.watchdog.reset();
  if (p.thread && !p.thread->join()) {
    p.hangs = true;
    log::report(Error{Fault::LoopDied, std::string(info(Fault::LoopDied).text), ""});
    return;  // the port is still the loop's; the stations' watchdogs have answered
  }
  p.bus->shut_down();
  p.crash_stop.reset();
}

// ---- orders ----

Result<void> Owner::order(const Order& order) {
  using cycle::CommandKind;
  using cycle::State;
  Parts& p = *parts_;
  const State state = latest().state;
  const auto refuse = [&](std::string_view waits_for) -> Result<void> {
    return fail(Fault::Refused,
                fmt::format("'{}' needs {}; the machine is {}", name(order.kind), waits_for, cycle::name(state)));
  };
  switch (order.kind) {
    case OrderKind::Hold:
      if (state != State::Running) return refuse("a job or a jog that runs");
      p.control->post({.kind = CommandKind::Hold});
      return {};
    case OrderKind::Resume:
      if (state != State::Held) return refuse("a job or a jog on hold");
      p.control->post({.kind = CommandKind::Resume});
      return {};
    case OrderKind::Override: p.control->post({.kind = CommandKind::Override, .value = order.value}); return {};
    case OrderKind::Reset:
      p.control->post({.kind = CommandKind::Reset});
      p.control->begin();
      p.named.reset();
      return {};
    case OrderKind::Abort:
      if (p.recording == nullptr && !p.jogs && state != State::Homing && state != State::Enabling)
        return refuse("a job that runs, a jog, or homing");
      interrupt(Error{Fault::Aborted, "the operator aborted it", ""});
      return {};
    case OrderKind::Status: return {};
    default: return refuse("an owner that is idle");
  }
}

void Owner::interrupt(Error why) {
  if (parts_->control) parts_->control->abort(std::move(why));
}

void Owner::on_step(std::function<void()> poll) { parts_->poll = std::move(poll); }

Result<void> Owner::idle() {
  Parts& p = *parts_;
  p.control->step();
  if (auto alive = p.control->alive(); !alive) return alive;
  p.on_bus = true;
  p.recovery->step(*p.control);
  p.on_bus = false;
  return {};
}

sim::WorldAccess* Owner::world() const { return parts_->world; }

const cycle::Snapshot& Owner::latest() const { return parts_->feed->latest(); }

}  // namespace gantry::run
