// Stations' clocks while the machine works (R10): a note, then a path stop, both with the station and the figure; and
// never a word about clocks that keep step.
#include <cmath>
#include <cstdlib>
#include <fmt/format.h>

#include "tests/machine/idle.hpp"
#include "tests/machine/said.hpp"

namespace gantry {
namespace {

using cycle::State;
using test::Idle;
using test::Rig;
using test::Said;

using test::kDemo;
constexpr const char* kNote = "[G117]";
constexpr const char* kStop = "[G118]";

TEST(Clocks, one_that_cannot_follow_is_a_note_and_then_a_path_stop_that_names_it) {
  Said said;
  Idle idle("[{at: cycle 20000, do: jitter, station: y2, by: 400 us}]");
  ASSERT_TRUE(idle.until([&] { return idle.now().latched != Fault::None; }, 3000)) << said.all();
  EXPECT_EQ(idle.now().latched, Fault::DcLost);
  EXPECT_EQ(idle.now().enabled, test::kAllAxes) << "drives stay enabled";
  EXPECT_GE(said.count({"station 3 'y2'", " us", kNote}), 1) << said.all();
  EXPECT_EQ(said.count({"station 3 'y2'", " us", kStop}), 1) << said.all();
  EXPECT_EQ(said.count({"y1", kNote}) + said.count({"y1", kStop}), 0) << said.all();
  EXPECT_LT(said.lines().size(), 12u) << said.all();
}

TEST(Clocks, one_that_strays_beyond_the_bound_in_a_job_ends_it_with_5_on_the_path) {
  Rig rig({.placement = "dx=0.5 mm", .script = "- {at: feature bead 2, do: jitter, station: y1, by: 400 us}"});
  const auto result = rig.run(kDemo);
  EXPECT_EQ(result.exit_code, ExitCode::Device);
  ASSERT_FALSE(result.errors.empty());
  EXPECT_EQ(result.errors.front().fault, Fault::DcLost) << to_text(result.errors.front());
  EXPECT_EQ(result.errors.front().where, "station 2 'y1'");
  EXPECT_EQ(rig.owner().latest().outputs & config::bit(config::Output::Valve), 0u);
  EXPECT_EQ(rig.owner().latest().enabled, test::kAllAxes);
}

TEST(Clocks, a_reset_does_not_hide_what_lasts_and_one_that_is_well_again_can_be_reset) {
  Idle idle(
      "[{at: cycle 20000, do: jitter, station: y1, by: 400 us}, {at: cycle 24000, do: jitter, station: y1, by: 0 us}]");
  ASSERT_TRUE(idle.until([&] { return idle.now().latched == Fault::DcLost; }, 3000));
  ASSERT_TRUE(idle.owner().order({.kind = run::OrderKind::Reset}));
  idle.pass_to(idle.now().cycle + 100);
  EXPECT_EQ(idle.now().latched, Fault::DcLost);
  idle.pass_to(26'000);
  ASSERT_TRUE(idle.owner().order({.kind = run::OrderKind::Reset}));
  idle.pass_to(27'000);
  EXPECT_EQ(idle.now().latched, Fault::None);
  EXPECT_EQ(idle.now().state, State::Ready);
}

TEST(Clocks, nothing_is_said_of_clocks_that_keep_step_while_crystals_differ_and_frames_are_lost) {
  std::string script = "- {at: cycle 100, do: noise, loss: 0.01, seed: 5}\n";
  int ppm = 100;
  for (const char* name : {"x", "y1", "y2", "z", "cu", "io"})
    script += fmt::format("- {{at: cycle 1, do: drift, station: {}, ppm: {}}}\n", name, ppm = -ppm);
  Said said;
  Rig rig({.placement = "dx=0.5 mm", .script = script});
  const auto result = rig.run(kDemo);
  EXPECT_EQ(said.count({kNote}) + said.count({kStop}), 0) << said.all();
}

TEST(Clocks, nothing_is_said_of_a_station_that_is_still_being_set) {
  Said said;
  Idle idle("[{at: cycle 20000, do: power_cycle, station: x}, {at: cycle 20000, do: power_cycle, station: y1}]");
  idle.pass_to(20'050);
  ASSERT_TRUE(idle.owner().order({.kind = run::OrderKind::Reset}));
  ASSERT_TRUE(idle.until([&] { return idle.whole(); }, 3000));
  idle.pass_to(idle.now().cycle + 2000);
  EXPECT_EQ(said.count({kNote}) + said.count({kStop}), 0) << said.all();
}

}  // namespace
}  // namespace gantry
