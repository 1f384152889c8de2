// `gantry sim`: the simulated machine in a process of its own. Answers EtherCAT frames on a network interface like a
// ring of real stations would, and the world's questions on a Unix socket.
//   sim::serve(machine, {.interface = "veth1", .world_socket = "/tmp/world"}, stop);   // returns when stop is set
#pragma once
#include <atomic>
#include <string>

#include "config/machine.hpp"
#include "core/error.hpp"
#include "sim/machine/simulated_machine.hpp"

namespace gantry::sim {

struct ServeOptions {
  std::string interface;     ///< raw Ethernet; needs CAP_NET_RAW
  std::string world_socket;  ///< made with mode 0600, removed at the end; a stale one is replaced
  bool script_on_stdin =
      false;  ///< each line of stdin is a script entry: "{at: feature dot 7, do: drive_fault, axis: X}"
  SimulatedMachineOptions world;
};

/// Blocks until `stop`. Fault::InterfaceUnusable, SecondOwner (the socket is in use), and those of
/// SimulatedMachine::open.
Result<void> serve(const config::Machine& machine, const ServeOptions& options, const std::atomic<bool>& stop);

}  // namespace gantry::sim
