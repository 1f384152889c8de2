// Builds an owner from its machine file and options: clock, bus, loop, readers.
#include <fmt/format.h>

#include "app/job/surroundings.hpp"
#include "app/run/compose.hpp"
#include "app/run/owner_parts.hpp"
#include "app/stations/accepted.hpp"
#include "core/log.hpp"
#include "devices/ethercat/master.hpp"

namespace gantry::run {
namespace {

constexpr std::string_view kEthercat = "ethercat:", kSimulatedHere = "sim";

}  // namespace

Result<devices::FramePort*> Owner::Parts::open_bus() {
  if (options.bus == kSimulatedHere) {
    auto simulated = sim::SimulatedMachine::open(options.sim.wired ? *options.sim.wired : machine, *clock, options.sim);
    if (!simulated) return tl::unexpected(simulated.error());
    simulated_machine = std::move(*simulated);
    world = simulated_machine.get();
    can = &simulated_machine->can();
    for (const std::string& wanted : config::wanted_on_steel(machine)) log::warn("{}{}", wanted, config::kOnSteel);
    return &simulated_machine->bus();
  }
  if (auto wanted = config::wanted_on_steel(machine); !wanted.empty())
    return fail(Fault::MissingKey, std::move(wanted.front()), machine.file);
  auto raw = devices::RawSocketPort::open(options.bus.substr(kEthercat.size()));
  if (!raw) return tl::unexpected(raw.error());
  raw_port = std::move(*raw);
  if (!options.world_socket.empty()) {
    auto client = sim::WorldClient::connect(options.world_socket);
    if (!client) return tl::unexpected(client.error());
    world_client = std::move(*client);
    world = world_client.get();
  }
  return raw_port.get();
}

Result<void> check(const OwnerOptions& options) {
  if (options.bus != kSimulatedHere && (!options.bus.starts_with(kEthercat) || options.bus.size() == kEthercat.size()))
    return fail(Fault::Usage, fmt::format("'{}' is no bus; write sim or ethercat:IFACE", options.bus), "--bus");
  if (options.bus == kSimulatedHere && !options.world_socket.empty())
    return fail(
        Fault::Usage,
        "the virtual bus has its world in itself; for that of a `gantry sim` name its bus: --bus ethercat:IFACE",
        "--world");
  if (options.bus != kSimulatedHere)
    for (const auto& [option, value] :
         {std::pair{"--sim-board", &options.sim.placement}, std::pair{"--sim-script", &options.sim.script_file},
          std::pair{"--sim-state", &options.sim.state_dir}})
      if (!value->empty())
        return fail(
            Fault::Usage,
            fmt::format("goes with the simulated machine, and the machine is on '{}'; leave one of both out (of a "
                        "`gantry sim` at that bus, give it to that)",
                        options.bus),
            option);
  if (options.bus == kSimulatedHere)
    if (auto fits = sim::check(options.sim); !fits) return fits;
  if (!options.virtual_time)
    if (auto usable = cycle::LoopCpu::check(options.loop_cpu); !usable) return usable;
  if (!options.publish) return {};
  if (auto fits = monitor::check(options.network); !fits) return fits;
  return options.name.empty() ? Result<void>{} : monitor::check_name(options.name);
}

Result<std::unique_ptr<Owner>> Owner::open(const config::Machine& machine, const OwnerOptions& options) {
  if (auto fits = check(options); !fits) return tl::unexpected(fits.error());
  auto p = std::make_unique<Parts>();
  p->machine = machine;
  p->options = options;
  if (!options.state.empty())
    if (auto r = stations::read_accepted(stations::accepted_file(options.state, options.bus), p->machine); !r)
      return tl::unexpected(r.error());
  if (auto r = compose_startup(p->machine); !r) return tl::unexpected(r.error());
  if (options.virtual_time)
    p->clock = std::make_unique<VirtualClock>();
  else if (options.bus == kSimulatedHere)
    p->clock = std::make_unique<PatientClock>();
  else
    p->clock = std::make_unique<MonotonicClock>();

  const auto port = p->open_bus();
  if (!port) return tl::unexpected(port.error());

  const Host host = p->raw_port != nullptr ? (p->world == nullptr ? Host::Hardware : Host::Wire)
                    : options.virtual_time ? Host::VirtualTime
                                           : Host::WallClock;
  auto setup = compose_loop(p->machine, host);
  if (!setup) return tl::unexpected(setup.error());
  p->bus = std::make_unique<devices::EthercatMaster>(p->machine, **port, *p->clock);
  if ((*port)->descriptor() >= 0) p->stop = std::make_unique<cycle::StopFrame>(*setup, (*port)->descriptor());
  p->around = std::make_shared<job::Surroundings>(p->machine);
  p->stuck_after = setup->stuck_after();
  p->frames_lost_max = setup->frames_lost_max;
  p->loop = std::make_unique<cycle::Loop>(*setup, *p->bus, p->can, *p->clock, *p->channels, p->stop.get());
  if (!options.virtual_time) {
    auto cpu = cycle::LoopCpu::take(options.loop_cpu);
    if (!cpu) return tl::unexpected(cpu.error());
    p->loop_cpu = std::move(*cpu);
  }
  if (options.publish) {
    auto info = monitor::machine_info(p->machine);
    if (!options.name.empty()) info.name = options.name;
    auto shared = monitor::SnapshotWriter::create(info);
    if (!shared) return tl::unexpected(shared.error());
    p->shared.emplace(std::move(*shared));
    p->publisher = std::make_unique<monitor::PublishChild>(
        p->shared->fd(), monitor::ChildOptions{.arguments = monitor::words(options.network)});
  }
  p->feed = std::make_unique<Feed>(*p->channels);
  p->feed->listen([parts = p.get()](const cycle::Snapshot& s) { parts->on_snapshot(s); },
                  [parts = p.get()](const cycle::Event& e) { parts->on_event(e); });
  return std::unique_ptr<Owner>(new Owner(std::move(p)));
}

}  // namespace gantry::run
