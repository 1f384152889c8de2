// Made-up values of the shared memory for the tests of the monitor.
#pragma once
#include <limits>

#include "app/monitor/shared_values.hpp"
#include "config/machine.hpp"

namespace gantry::monitor {

inline MachineInfo bench_machine() {
  MachineInfo info;
  info.name = "bench";
  info.axes = 2;
  info.axis[0] = {std::string_view("X"), false};
  info.axis[1] = {std::string_view("C"), true};
  for (std::size_t i = 0; i < config::kOutputs; ++i) info.output[i] = config::name(static_cast<config::Output>(i));
  for (std::size_t i = 0; i < config::kInputs; ++i) info.input[i] = config::name(static_cast<config::Input>(i));
  info.input[config::kInputs] = std::string_view("tray_full");  // a channel with a name of the machine's own
  return info;
}

inline SharedSnapshot running_snapshot() {
  SharedSnapshot shared;
  shared.wall_ns = 1'700'000'000'123'456'789;
  auto& s = shared.snapshot;
  s.cycle = 4711;
  s.state = cycle::State::Running;
  s.block = 7;
  s.tick = 42;
  s.feature = 3;
  s.axes = 2;
  s.enabled = 3;
  s.referenced = 1;
  s.target = {123.5, 1.5};
  s.actual = {123.25, 1.5};
  s.following = {0.25, std::numeric_limits<double>::quiet_NaN()};
  s.outputs = config::bit(config::Output::Valve) | config::bit(config::Output::StackGreen);
  s.inputs = config::bit(config::Input::AirOk) | 1u << config::kInputs | 1u << (config::kInputs + 1);
  return shared;
}

}  // namespace gantry::monitor
