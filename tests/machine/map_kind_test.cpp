// The machine file's `bus: {map: overlapped}`: the same job by shorter frames.
#include <gtest/gtest.h>

#include "tests/devices/ethercat/bus_bench.hpp"
#include "tests/machine/rig.hpp"

namespace gantry {
namespace {

TEST(MapKind, overlapped_regions_are_as_long_as_the_longer_of_the_two) {
  devices::BusBench b;
  b.machine.bus.map = config::MapKind::Overlapped;
  b.operate();
  std::size_t shorter = 0;
  for (const auto& s : b.master->stations()) {
    EXPECT_EQ(s.region_bytes, std::max(s.output_bytes, s.input_bytes)) << s.where;
    EXPECT_EQ(s.input_at, 0u) << s.where;
    shorter += s.region_bytes < s.output_bytes + s.input_bytes;
  }
  EXPECT_GE(shorter, 5u);
  b.enable();
  b.cycles(100);
  EXPECT_EQ(b.last.fault, Fault::None);
  EXPECT_EQ(b.last.ethercat.working_counter, b.last.ethercat.expected);
}

TEST(MapKind, a_job_comes_out_the_same_by_either) {
  const auto recipe = test::load_recipe("recipes/demo-board.yaml");
  std::vector<record::JobResult> results;
  for (const auto map : {config::MapKind::Separate, config::MapKind::Overlapped}) {
    auto machine = config::load_machine("config/machines/dispenser.yaml");
    ASSERT_TRUE(machine);
    machine->bus.map = map;
    const auto job = recipes::compile(recipe, *machine);
    ASSERT_TRUE(job);
    run::OwnerOptions options;
    options.virtual_time = true;
    options.sim.placement = "dx=0.5 mm";
    auto owner = run::Owner::open(*machine, options);
    ASSERT_TRUE(owner) << to_text(owner.error());
    const auto up = (*owner)->bring_up();
    ASSERT_TRUE(up) << to_text(up.error());
    results.push_back((*owner)->run(recipe, *job, {}));
    EXPECT_EQ(results.back().exit_code, ExitCode::Done);
  }
  EXPECT_EQ(results[0].setpoint_hash, results[1].setpoint_hash);
  EXPECT_EQ(results[0].deposits.size(), results[1].deposits.size());
}

}  // namespace
}  // namespace gantry
