// What the wire and the drives show beside the job is told, and where it was.
#include <fmt/format.h>

#include "tests/altered.hpp"
#include "tests/machine/idle.hpp"
#include "tests/machine/said.hpp"

namespace gantry {
namespace {

using test::Idle;
using test::Rig;
using test::Said;

using test::kDemo;

TEST(WireTold, another_master_is_named_with_its_address) {  // R16
  Said said;
  Idle idle("[{at: cycle 20000, do: foreign_frames, count: 12}]");
  idle.pass_to(22'500);
  EXPECT_EQ(said.count({"another EtherCAT master", "12 in the last second", "02:1B:21:0A:0B:0C", "[G119]"}), 1)
      << said.all();
  EXPECT_EQ(idle.now().latched, Fault::None);
  EXPECT_EQ(idle.owner().wire().frames.foreign, 12u);
  EXPECT_EQ(idle.owner().wire().frames.lost, 0u);
  EXPECT_NE(idle.owner().wire().other_master.find("02:1B:21"), std::string::npos);
}

/// R14: frames whose headers were changed, and two of somebody, are counted, and are no master's.
TEST(WireTold, a_frame_that_was_changed_on_the_way_is_no_other_master) {
  Said said;
  Idle idle(
      "[{at: cycle 20000, do: foreign_frames, count: 1}, {at: cycle 22000, do: corrupt_headers, count: 1},\n"
      " {at: cycle 22010, do: corrupt_headers, count: 1}, {at: cycle 24500, do: foreign_frames, count: 1}]");
  idle.pass_to(27'500);
  EXPECT_EQ(said.count({"[G119]"}), 0) << said.all();
  EXPECT_EQ(idle.owner().wire().other_master, "");
  EXPECT_EQ(idle.owner().wire().frames.foreign, 2u);
}

// Another master that sends every 1.5 s for 15 s: ten notes.
TEST(WireTold, a_note_that_comes_again_and_again_is_told_more_and_more_rarely_and_none_is_lost) {
  Said said;
  std::string script = "[";
  for (int i = 0; i < 10; ++i)
    script += fmt::format("{}{{at: cycle {}, do: foreign_frames, count: 3}}", i == 0 ? "" : ", ", 20'000 + 1500 * i);
  Idle idle(script + "]");
  idle.pass_to(20'000 + 15'000 + 31'000);
  EXPECT_EQ(idle.owner().wire().frames.foreign, 30u);
  int told = 0, notes = 0;
  for (const std::string& line : said.lines()) {
    if (line.find("[G119]") == std::string::npos) continue;
    ++told, ++notes;
    if (line.find(" more times since it was last told") != std::string::npos)
      notes += std::stoi(line.substr(line.rfind('(') + 1));
  }
  EXPECT_EQ(notes, 10) << said.all();
  EXPECT_LE(told, 5) << said.all();
}

TEST(WireTold, a_job_counts_each_frame_as_what_it_was) {  // R12
  Rig rig({.placement = "dx=0.3 mm",
           .script =
               "[{at: feature dot 1, do: duplicate_frames, count: 9}, {at: feature dot 2, do: lose_frames, count: "
               "1},\n {at: feature dot 3, do: foreign_frames, count: 4}]"});
  const auto result = rig.run(kDemo);
  EXPECT_EQ(result.exit_code, ExitCode::Done);
  EXPECT_EQ(result.cycles.frames.duplicate, 9u);
  EXPECT_EQ(result.cycles.frames.lost, 1u);
  EXPECT_EQ(result.cycles.frames.foreign, 4u);
  EXPECT_EQ(result.cycles.frames_lost, 1u);
  EXPECT_EQ(result.cycles.working_counter_errors, 0u);
}

TEST(WireTold, a_brake_that_does_not_hold_is_told_as_often_as_the_axis_sinks_on) {  // R53
  Said said;
  Idle idle(
      "[{at: cycle 21000, do: slip_brake, axis: Z, speed: -2 mm/s}, {at: cycle 22000, do: slip_brake, axis: Z, "
      "speed: 0 mm/s}]");
  EXPECT_EQ(said.count({"[G210]"}), 0) << said.all();
  ASSERT_TRUE(idle.owner().disable());
  const double stood = idle.now().actual[2];
  idle.pass_to(20'990);
  EXPECT_EQ(said.count({"[G210]"}), 0) << said.all();  // torque went, and the brake has closed
  idle.pass_to(22'500);
  EXPECT_NEAR(idle.now().actual[2] - stood, -2.0, 0.05);
  EXPECT_GE(said.count({"axis Z", "[G210]"}), 1) << said.all();
  EXPECT_EQ(idle.now().latched, Fault::None);
}

TEST(WireTold, an_axis_without_a_brake_may_be_pushed_by_hand) {
  Said said;
  Idle idle("[{at: cycle 21000, do: slip_brake, axis: X, speed: 5 mm/s}]");
  ASSERT_TRUE(idle.owner().disable());
  idle.pass_to(22'500);
  EXPECT_EQ(said.count({"[G210]"}), 0) << said.all();
}

TEST(WireTold, a_limit_switch_that_is_active_before_any_motion_is_told_and_homing_leads_off_it) {  // R36
  for (const bool on_switch : {true, false}) {
    SCOPED_TRACE(on_switch);
    Said said;
    Rig rig({.wired = [&](auto& m) {
      if (on_switch) m.sim.axes[0].start = m.sim.axes[0].neg_limit - 1;
    }});
    ASSERT_TRUE(rig.owner().bring_up());
    EXPECT_TRUE(rig.owner().enable());
    EXPECT_EQ(said.count({"axis X", "[G212]"}), on_switch ? 1 : 0) << said.all();
    const auto homed = rig.owner().home();
    EXPECT_TRUE(homed) << to_text(homed.error());
  }
}

TEST(WireTold, a_drive_that_has_lost_its_supply_is_named_when_it_is_back) {  // R47
  for (const char* what : {"power_cycle", "cut_link"}) {
    SCOPED_TRACE(what);
    const bool lost = std::string_view(what) == "power_cycle";
    Said said;
    std::string script = std::string("[{at: cycle 20000, do: ") + what + ", station: cu}";
    if (!lost) script += ", {at: cycle 20200, do: heal_link, station: cu}";
    Idle idle(script + "]");
    idle.pass_to(20'050);
    ASSERT_TRUE(idle.until([&] { return idle.whole(); }, 5000)) << said.all();
    idle.pass_to(idle.now().cycle + 200);
    EXPECT_EQ(said.count({"station 5 'cu'", "[G214]"}), lost ? 1 : 0) << said.all();
    EXPECT_EQ(idle.now().referenced & 0b11000u, 0u);
    EXPECT_EQ(idle.now().referenced & 0b00111u, 0b00111u);
  }
}

}  // namespace
}  // namespace gantry
