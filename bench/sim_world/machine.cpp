// One cycle of the whole simulated machine in virtual time: master, segment with six stations, plant and world.
#include "config/machine.hpp"

#include <benchmark/benchmark.h>

#include "core/clock.hpp"
#include "devices/ethercat/master.hpp"
#include "sim/machine/simulated_machine.hpp"

namespace gantry::sim {
namespace {

void one_cycle_of_the_simulated_machine(benchmark::State& state) {
  const config::Machine machine = config::load_machine("config/machines/dispenser.yaml").value();
  VirtualClock clock;
  const auto simulated = SimulatedMachine::open(machine, clock, {}).value();
  devices::EthercatMaster master(machine, simulated->bus(), clock);
  if (!master.bring_up() || !simulated->load_board(recipes::load("recipes/demo-board.yaml").value())) {
    state.SkipWithError("the bus did not come up");
    return;
  }
  Time next = master.first_cycle(clock.now() + milliseconds(2));
  const auto cycle = [&] {
    clock.sleep_until(next);
    next += milliseconds(1);
    return master.exchange(next - microseconds(200));
  };
  for (int k = 0; k < 20; ++k) cycle();
  if (!master.request_operation()) state.SkipWithError("the bus did not reach OP");
  for (auto _ : state) benchmark::DoNotOptimize(cycle());
}
BENCHMARK(one_cycle_of_the_simulated_machine);

}  // namespace
}  // namespace gantry::sim
