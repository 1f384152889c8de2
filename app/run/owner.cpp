#include "app/run/owner.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <fmt/format.h>
#include <map>
#include <optional>
#include <set>

#include "app/cycle/crash_stop.hpp"
#include "app/cycle/thread.hpp"
#include "app/cycle/watchdog.hpp"
#include "app/monitor/child.hpp"
#include "app/monitor/snapshot_shm.hpp"
#include "app/record/setpoint_file.hpp"
#include "app/record/setpoint_hash.hpp"
#include "app/record/summary.hpp"
#include "app/record/trace.hpp"
#include "app/run/compose.hpp"
#include "app/run/fault_words.hpp"
#include "app/run/job_files.hpp"
#include "app/run/runner.hpp"
#include "core/log.hpp"
#include "devices/ethercat/master.hpp"
#include "devices/raw_socket_port.hpp"
#include "sim/machine/world_client.hpp"

namespace gantry::run {
namespace {

constexpr double kOperationTimeout_s = 5;
constexpr int kOperationAttempts = 2;
constexpr double kEnableTimeout_s = 4;
constexpr Time kLockTimeout = std::chrono::seconds(5);
constexpr std::int32_t kLocked_ns = 100'000;      // phase error below which SYNC0 and our frames are well apart
constexpr int kRecoverEvery = 100;                // idle steps between two attempts to bring stations back
constexpr Time kQuiet = std::chrono::seconds(1);  // after a note was told, the same one is only counted
constexpr std::string_view kEthercat = "ethercat:";

/// The catalogue numbers what drives report 2xx.
bool of_a_drive(Fault fault) { return static_cast<int>(fault) / 100 == 2; }

}  // namespace

struct Owner::Parts {
  config::Machine machine;
  OwnerOptions options;
  std::unique_ptr<Clock> clock;
  std::unique_ptr<sim::VirtualMachine> virtual_machine;
  std::unique_ptr<sim::WorldClient> world_client;
  std::unique_ptr<devices::RawSocketPort> raw_port;
  sim::WorldAccess* world = nullptr;  // null on a machine of steel
  devices::CanPort* can = nullptr;
  std::unique_ptr<devices::EthercatMaster> bus;
  std::unique_ptr<cycle::Channels> channels = std::make_unique<cycle::Channels>();
  std::unique_ptr<cycle::StopFrame> stop;  // on a bus that others than the loop can send on
  Time stuck_after{};
  std::unique_ptr<cycle::Loop> loop;
  std::unique_ptr<Feed> feed;
  std::unique_ptr<cycle::LoopCpu> loop_cpu;  // these two in real time only
  std::unique_ptr<cycle::LoopThread> thread;
  std::unique_ptr<cycle::Watchdog> watchdog;  // these two while the stations are in OP
  std::unique_ptr<cycle::CrashStop> crash_stop;
  std::unique_ptr<Pump> pump;
  std::unique_ptr<Control> control;
  std::optional<monitor::SnapshotWriter> shared;  // what `gantry publish` reads
  std::unique_ptr<monitor::PublishChild> publisher;
  std::function<void()> poll;
  struct Repeated {
    std::int64_t told_ns = 0;
    int count = 0;  ///< since then, with that one
  };
  std::map<Fault, Repeated> repeated;  // notes that came more than once
  bool up = false;
  bool hangs = false;  // the loop has not ended: what it uses must outlive this program

  // the job that runs
  Runner* runner = nullptr;
  record::Trace* trace = nullptr;
  record::SetpointHash* hash = nullptr;
  std::optional<record::SetpointFile> setpoints;
  record::JobResult* result = nullptr;
  std::set<std::uint32_t> features_seen;
  std::int64_t job_start_ns = 0;
  int idle_short = 0;  ///< idle steps in a row in which a station did not take part

  void on_step();
  void tell_job(std::string_view state);
  void on_snapshot(const cycle::Snapshot& s);
  void on_event(const cycle::Event& e);
};

Owner::Owner(std::unique_ptr<Parts> parts) : parts_(std::move(parts)) {}

Owner::~Owner() {
  shut_down();
  if (parts_->hangs) static_cast<void>(parts_.release());
}

Result<std::unique_ptr<Owner>> Owner::open(const config::Machine& machine, const OwnerOptions& options) {
  auto p = std::make_unique<Parts>();
  p->machine = machine;
  p->options = options;
  if (auto r = compose_startup(p->machine); !r) return tl::unexpected(r.error());
  if (options.virtual_time)
    p->clock = std::make_unique<VirtualClock>();
  else
    p->clock = std::make_unique<MonotonicClock>();

  devices::FramePort* port = nullptr;
  const bool hardware = options.bus.starts_with(kEthercat);
  if (hardware) {
    auto raw = devices::RawSocketPort::open(options.bus.substr(kEthercat.size()));
    if (!raw) return tl::unexpected(raw.error());
    p->raw_port = std::move(*raw);
    port = p->raw_port.get();
    if (!options.world_socket.empty()) {
      auto client = sim::WorldClient::connect(options.world_socket);
      if (!client) return tl::unexpected(client.error());
      p->world_client = std::move(*client);
      p->world = p->world_client.get();
    }
  } else if (options.bus == "sim") {
    auto vm = sim::VirtualMachine::open(p->machine, *p->clock, options.sim);
    if (!vm) return tl::unexpected(vm.error());
    p->virtual_machine = std::move(*vm);
    p->world = p->virtual_machine.get();
    port = &p->virtual_machine->bus();
    p->can = &p->virtual_machine->can();
  } else {
    return fail(Fault::Usage, fmt::format("'{}' is no bus; write sim or ethercat:IFACE", options.bus), "--bus");
  }

  // A virtual segment behind an interface is still a simulation of the host's making: what counts is whether steel
  // moves.
  auto setup = compose_loop(p->machine, hardware && p->world == nullptr);
  if (!setup) return tl::unexpected(setup.error());
  p->bus = std::make_unique<devices::EthercatMaster>(p->machine, *port, *p->clock);
  if (port->descriptor() >= 0) p->stop = std::make_unique<cycle::StopFrame>(*setup, port->descriptor());
  p->stuck_after = setup->stuck_after();
  p->loop = std::make_unique<cycle::Loop>(*setup, *p->bus, p->can, *p->clock, *p->channels, p->stop.get());
  if (!options.virtual_time) {
    auto cpu = cycle::LoopCpu::take(options.loop_cpu);
    if (!cpu) return tl::unexpected(cpu.error());
    p->loop_cpu = std::move(*cpu);
  }
  if (options.publish) {
    auto shared = monitor::SnapshotWriter::create(monitor::machine_info(p->machine));
    if (!shared) return tl::unexpected(shared.error());
    p->shared.emplace(std::move(*shared));
    p->publisher = std::make_unique<monitor::PublishChild>(p->shared->fd());
  }
  p->feed = std::make_unique<Feed>(*p->channels);
  p->feed->listen([parts = p.get()](const cycle::Snapshot& s) { parts->on_snapshot(s); },
                  [parts = p.get()](const cycle::Event& e) { parts->on_event(e); });
  return std::unique_ptr<Owner>(new Owner(std::move(p)));
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
                                        [&p](const cycle::Event& e) { return in_words(p.machine, e); });
  p.control->on_step([&p] { p.on_step(); });
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

Result<void> Owner::enable() {
  Parts& p = *parts_;
  if (p.control->latest().state == cycle::State::Disabled)
    if (auto r = p.control->command({.kind = cycle::CommandKind::Enable}, kEnableTimeout_s); !r) return r;
  for (const config::Axis& axis : p.machine.axes)
    if (axis.homing && axis.kind == config::AxisKind::Streamed &&
        (p.control->latest().referenced >> axis.id.value & 1u) == 0)
      return home();
  return {};
}

Result<void> Owner::home() {
  Parts& p = *parts_;
  std::set<int> orders;
  for (const config::Axis& axis : p.machine.axes)
    if (axis.homing && axis.kind == config::AxisKind::Streamed) orders.insert(axis.homing->order);
  for (const int order : orders) {
    std::uint32_t mask = 0;
    double timeout_s = 1;
    std::string names;
    for (const config::Axis& axis : p.machine.axes) {
      if (!axis.homing || axis.kind != config::AxisKind::Streamed || axis.homing->order != order) continue;
      mask |= 1u << axis.id.value;
      timeout_s = std::max(timeout_s, axis.homing->timeout_s + 2);
      names += (names.empty() ? "" : ", ") + axis.name;
    }
    log::info("homing {}", names);
    if (auto r = p.control->command({.kind = cycle::CommandKind::Home, .axes = mask}, timeout_s); !r) return r;
  }
  return {};
}

Result<void> Owner::disable() {
  return parts_->control->command({.kind = cycle::CommandKind::Disable}, kEnableTimeout_s);
}

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

// ---- every step, every snapshot, every event ----

void Owner::Parts::on_step() {
  if (publisher) publisher->poll(clock->now());
  if (poll) poll();
}

void Owner::Parts::tell_job(std::string_view state) {
  if (!shared || result == nullptr) return;
  monitor::SharedJob job;
  job.job = result->job;
  job.recipe = result->recipe_name;
  job.state = state;
  job.blocks_done = static_cast<std::uint32_t>(result->blocks_done);
  job.blocks_total = static_cast<std::uint32_t>(result->blocks_total);
  job.features_done = static_cast<std::uint32_t>(features_seen.size());
  job.features_total = static_cast<std::uint32_t>(result->features_total);
  job.elapsed_s = static_cast<double>(control->latest().time_ns - job_start_ns) * 1e-9;
  job.predicted_s = result->predicted_s;
  shared->push(job);
}

void Owner::Parts::on_snapshot(const cycle::Snapshot& s) {
  if (trace != nullptr) trace->add(s);
  if (hash != nullptr) hash->add(s);
  if (setpoints) setpoints->add(s);
  if (shared) shared->push(s);
  if (result == nullptr || s.block == 0 || s.feature == motion::kTravel) return;
  if (features_seen.insert(s.feature).second) tell_job("running");
}

void Owner::Parts::on_event(const cycle::Event& e) {
  if (shared) shared->push(e, e.kind == cycle::EventKind::Fault ? in_words(machine, e).message : "");
  if (e.kind != cycle::EventKind::Fault || info(e.fault).severity == Severity::Info) return;
  std::string words = to_text(in_words(machine, e));
  if (info(e.fault).reaction == Reaction::Note && control) {
    Repeated& r = repeated[e.fault];
    const std::int64_t now_ns = control->latest().time_ns;
    if (r.count > 0 && now_ns - r.told_ns < kQuiet.count()) {
      ++r.count;
      return;
    }
    if (r.count > 1) words += fmt::format(" ({} more times since it was last told)", r.count - 1);
    r = {now_ns, 1};
  }
  log::warn("{}", words);
  if (result != nullptr && control)
    result->events.push_back(
        fmt::format("{:.3f} s  {}", static_cast<double>(control->latest().time_ns - job_start_ns) * 1e-9, words));
}

record::JobResult Owner::run(const recipes::Recipe& recipe, const recipes::Job& job, const RunOptions& options) {
  Parts& p = *parts_;
  record::JobResult result = begin_result(p.machine, recipe, job, options);
  result.bus = p.options.bus;
  const auto wall_start = std::chrono::steady_clock::now();

  record::Trace trace(p.machine);
  record::SetpointHash hash;
  if (!options.out.empty()) {
    if (auto file = record::SetpointFile::create(options.out + "/setpoints.bin"))
      p.setpoints.emplace(std::move(*file));
    else
      log::report(file.error());
  }
  p.trace = &trace, p.hash = &hash, p.result = &result;
  p.features_seen.clear();
  p.control->begin();
  p.job_start_ns = p.control->latest().time_ns;
  p.tell_job("running");

  Result<void> ended;
  if (p.world != nullptr) {
    const auto loaded = p.world->board_loaded();
    if (!loaded)
      ended = tl::unexpected(loaded.error());
    else if (!*loaded)
      ended = p.world->load_board(recipe);
    if (ended) ended = p.world->begin_job();
  }
  if (ended) ended = enable();
  Runner runner({p.machine, *p.control, p.world != nullptr ? &p.world->camera() : nullptr}, recipe, job, result);
  p.runner = &runner;
  if (ended) ended = runner.run();
  if (!ended) {
    result.errors.push_back(ended.error());
    result.exit_code = info(ended.error().fault).exit_code;
  }

  p.tell_job(record::result_word(result));
  p.runner = nullptr, p.trace = nullptr, p.hash = nullptr, p.result = nullptr;
  trace.fill(result, recipe);
  result.features_done = p.features_seen.size() - std::min(p.features_seen.size(), result.interrupted.size());
  result.setpoint_hash = hash.value();
  result.setpoint_ticks = hash.ticks();
  result.setpoint_stream_complete = hash.complete() && p.channels->lost.load() == 0;
  result.cycles.virtual_time = p.options.virtual_time;
  if (p.thread)
    result.cycles.real_time_priority = p.thread->rights().priority,
    result.cycles.memory_locked = p.thread->rights().memory;
  if (p.setpoints) {
    if (auto closed = p.setpoints->close(); !closed) log::report(closed.error());
    p.setpoints.reset();
  }
  if (p.world != nullptr) add_world(result, *p.world, options);
  result.wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - wall_start).count();
  return result;
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
      if (state != State::Running) return refuse("a job that runs");
      p.control->post({.kind = CommandKind::Hold});
      return {};
    case OrderKind::Resume:
      if (state != State::Held) return refuse("a job on hold");
      p.control->post({.kind = CommandKind::Resume});
      return {};
    case OrderKind::Override: p.control->post({.kind = CommandKind::Override, .value = order.value}); return {};
    case OrderKind::Reset:
      p.control->post({.kind = CommandKind::Reset});
      p.control->begin();
      return {};
    case OrderKind::Abort:
      if (p.runner == nullptr) return refuse("a job that runs");
      interrupt(Error{Fault::Aborted, "the operator aborted the job", ""});
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
  // Stations that have stopped taking part are brought back between two orders. Their axes stay disabled.
  const cycle::Snapshot& now = latest();
  const bool short_of = now.working_counter < now.expected && now.working_counter != 0;
  p.idle_short = short_of ? p.idle_short + 1 : 0;
  if (p.idle_short < kRecoverEvery) return {};
  p.idle_short = 0;
  p.bus->step_by([&p] { p.control->step(); });
  const auto back = p.bus->recover();
  p.bus->step_by({});
  if (back)
    log::info("every station takes part again; reset, then enable and home the axes that were away");
  else
    log::debug("recovery: {}", to_text(back.error()));
  return {};
}

const cycle::Snapshot& Owner::latest() const { return parts_->feed->latest(); }

Progress Owner::progress() const {
  const Parts& p = *parts_;
  Progress progress;
  if (p.result == nullptr) return progress;
  progress.features_done = p.features_seen.size();
  progress.features_total = p.result->features_total;
  progress.doing = p.runner != nullptr ? p.runner->doing() : "homing";
  progress.elapsed_s = static_cast<double>(latest().time_ns - p.job_start_ns) * 1e-9;
  return progress;
}

}  // namespace gantry::run
