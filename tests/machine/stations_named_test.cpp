// Messages about the bus say which station, and where it can be read why.
#include <fmt/format.h>

#include "app/stations/culprits.hpp"
#include "tests/devices/ethercat/bus_bench.hpp"
#include "tests/machine/idle.hpp"
#include "tests/machine/said.hpp"

namespace gantry {
namespace {

using test::Idle;
using test::Rig;
using test::Said;

using test::kDemo;

TEST(StationsNamed, a_lost_station_ends_a_job_with_its_name) {
  Rig rig({.placement = "dx=0.5 mm", .script = "- {at: feature dot 5, do: power_cycle, station: cu}"});
  const auto result = rig.run(kDemo);
  EXPECT_EQ(result.exit_code, ExitCode::Device);
  ASSERT_FALSE(result.errors.empty());
  EXPECT_EQ(result.errors.front().fault, Fault::StationSilent);
  EXPECT_EQ(result.errors.front().where, "station 5 'cu'") << to_text(result.errors.front());
}

TEST(StationsNamed, all_behind_a_cut_are_named_and_none_before_it) {
  Said said;
  Idle idle("[{at: cycle 20000, do: cut_link, station: z}]");
  idle.pass_to(20'100);
  EXPECT_EQ(said.count({"station 4 'z', station 5 'cu'", "[G104]"}), 1) << said.all();
  EXPECT_EQ(said.count({"station 3", "[G104]"}), 0) << said.all();
}

/// The bus alone, without anybody who brings stations back.
struct Asked : devices::BusBench {
  Asked() {
    operate();
    culprits = std::make_unique<stations::Culprits>(*master);
    pass(50);
  }
  void pass(int n) {
    for (int i = 0; i < n; ++i) {
      cycle();
      culprits->watch({.complete = last.complete, .operational = last.operational});
    }
  }
  stations::Culprits::Known who(Fault fault) {
    culprits->ask({.kind = cycle::EventKind::Fault, .fault = fault});
    for (int i = 0; i < 100; ++i) {
      pass(1);
      if (auto known = culprits->next()) return *known;
    }
    ADD_FAILURE() << "nobody is named after 100 cycles";
    return {};
  }
  std::unique_ptr<stations::Culprits> culprits;
};

TEST(StationsNamed, a_station_that_left_op_is_named_with_its_al_status_code) {
  Asked b;
  b.segment.cut_link(5);  // behind the cut it falls by its watchdog, and takes part again when the cable is whole
  b.pass(300);
  b.segment.heal_link(5);
  b.pass(2);
  EXPECT_EQ(b.last.ethercat.al_states, 0x1C);
  b.pass(150);
  const auto known = b.who(Fault::StationLeftOp);
  EXPECT_EQ(known.where, "station 5 'cu'");
  EXPECT_NE(known.what.find("SAFE_OP: AL status code 001Bh, "), std::string::npos) << known.what;
}

TEST(StationsNamed, beyond_four_they_are_counted) {
  Asked b;
  b.segment.lose_frames(150);
  b.pass(160);
  const auto known = b.who(Fault::StationLeftOp);
  EXPECT_EQ(known.where, "station 0 'io', station 1 'x', station 2 'y1', station 3 'y2' and 2 more");
}

TEST(StationsNamed, nobody_is_blamed_for_a_single_cycle_or_for_what_was_over_before) {
  Asked b;
  b.segment.cut_link(4);
  b.pass(10);
  b.segment.heal_link(4);
  b.pass(300);
  const auto known = b.who(Fault::TooFewTookPart);
  EXPECT_EQ(known.where, "");
  EXPECT_EQ(known.what, "");
}

TEST(StationsNamed, one_that_comes_back_has_its_reason_told) {
  for (const char* cut : {"z", "cu"}) {
    Said said;
    Idle idle(
        fmt::format("[{{at: cycle 20000, do: cut_link, station: {0}}},"
                    " {{at: cycle 21000, do: heal_link, station: {0}}}]",
                    cut));
    ASSERT_TRUE(idle.until([&] { return idle.now().cycle > 21'000 && idle.whole(); }, 2000)) << said.all();
    idle.pass_to(idle.now().cycle + 50);
    EXPECT_EQ(said.count({fmt::format("'{}': takes part again", cut), "SAFE_OP", "001Bh"}), 1) << said.all();
    EXPECT_EQ(said.count({"every station takes part again"}), 1) << said.all();
  }
}

TEST(StationsNamed, errors_that_a_station_counts_on_its_link_are_told_with_port_and_number_and_not_each_time) {
  Said said;
  Idle idle(
      "[{at: cycle 20000, do: count_errors, station: z, port: 1, count: 3},"
      " {at: cycle 20050, do: count_errors, station: y1, port: 0, count: 1},"
      " {at: cycle 22000, do: count_errors, station: z, port: 1, count: 2},"
      " {at: cycle 24000, do: count_errors, station: z, port: 1, count: 5}]");
  idle.pass_to(29'000);
  EXPECT_EQ(said.count({"station 4 'z'", "port 1: 3 frames with a wrong checksum", "[G129]"}), 1) << said.all();
  EXPECT_EQ(said.count({"station 2 'y1'", "port 0: 1 ", "[G129]"}), 1) << said.all();
  EXPECT_EQ(said.count({"[G129]"}), 2) << said.all();
  idle.pass_to(31'000);
  EXPECT_EQ(said.count({"station 4 'z'", "port 1: 7 ", "[G129]"}), 1) << said.all();
  EXPECT_EQ(idle.now().latched, Fault::None);
}

}  // namespace
}  // namespace gantry
