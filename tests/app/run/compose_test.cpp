// The machine file's durations as the loop's cycles.
#include "app/run/compose.hpp"

#include <gtest/gtest.h>

#include "app/stations/fault_words.hpp"
#include "config/machine.hpp"

namespace gantry::run {
namespace {

/// R11: three late cycles in 100 ms, and what is said of them names that duration, whatever the machine's period.
TEST(Compose, late_cycles_are_counted_in_a_tenth_of_a_second_of_any_period) {
  auto machine = config::load_machine("config/machines/dispenser.yaml");
  ASSERT_TRUE(machine);
  const struct {
    Time period;
    std::int64_t cycles;
  } cases[] = {
      {microseconds(250), 400}, {microseconds(1000), 100}, {microseconds(3000), 33}, {microseconds(10'000), 10}};
  for (const auto& each : cases) {
    machine->bus.cycle = each.period;
    const auto loop = compose_loop(*machine, Host::Hardware);
    ASSERT_TRUE(loop);
    EXPECT_EQ(loop->late_window, each.cycles);
    EXPECT_LE(loop->late_window, cycle::kMostInLateWindow);
    EXPECT_EQ(loop->late_max, 3);
    const Error words =
        stations::in_words(*machine, {.kind = cycle::EventKind::Fault, .fault = Fault::LateCycles, .detail = 3});
    EXPECT_NE(words.message.find("(3 in 100 ms)"), std::string::npos) << words.message;
  }
}

TEST(Compose, a_host_that_may_stand_still_may_be_late_as_often) {
  auto machine = config::load_machine("config/machines/dispenser.yaml");
  ASSERT_TRUE(machine);
  for (const Host host : {Host::Wire, Host::WallClock, Host::VirtualTime})
    EXPECT_EQ(compose_loop(*machine, host)->late_max, machine->bus.stop_after_missed_sim);
  machine->bus.stop_after_missed_hardware = 1;
  EXPECT_EQ(compose_loop(*machine, Host::Hardware)->late_max, 3);
}

}  // namespace
}  // namespace gantry::run
