// Stations that cannot be told apart, outputs that are on while nobody writes them, and bounds that never bite.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "changed.hpp"
#include "config/look_alikes.hpp"

namespace gantry::config {
namespace {

class OfTheBus : public testing::TestWithParam<Wrong> {};
TEST_P(OfTheBus, what_cannot_be_right_is_one_mistake_at_its_place) { expect_one_mistake(GetParam()); }

INSTANTIATE_TEST_SUITE_P(
    Machine, OfTheBus,
    testing::Values(
        Wrong{"position: 4, alias: 4", "position: 4, alias: 1", "1, par", Fault::Inconsistent,
              "'z' looks like 'x' (iD286-ECFA) and has the same alias"},
        Wrong{"position: 3, alias: 3", "position: 3, alias: 2", "2, par", Fault::Inconsistent, "'y2' looks like 'y1'"},
        Wrong{"valve:          {station: io, bit: 0}", "valve:          {station: io, bit: 0, invert: true}", "true",
              Fault::Inconsistent, "an inverted valve is open whenever nobody writes its output"},
        // Every watchdog of the shipped stations bites at 100 ms.
        Wrong{"frames_lost_max: 3", "frames_lost_max: 100", "100", Fault::Inconsistent,
              "a loss of frames of 100 ms is tolerated, but watchdogs bite earlier: 'io' (100 ms)"},
        // Drives interpolate over a cycle; X answers after 3 ms, C and U after 2.
        Wrong{"cycle: 1 ms", "cycle: 4 ms", "4 ms", Fault::Inconsistent, "X (3 ms), Z (2.5 ms), C (2 ms), U (2 ms)"},
        Wrong{"skew_max: 0.2 mm", "skew_max: 300 mm", "300", Fault::Inconsistent, "less than 11 mm"},
        Wrong{"rack_max: 12 mm", "rack_max: 400 mm", "400", Fault::OutOfRange, "it watches nothing"},
        Wrong{"skew_max: 0.2 mm\n    response_delay: 4 ms\n    homing: {",
              "skew_max: 0.2 mm\n    response_delay: 4 ms\n    homing: {square_max: -1 mm, ", "-1", Fault::OutOfRange,
              "more than 0"},
        // X is 4 ms late at 500 mm/s: 2 mm.
        Wrong{"{base: 0.5 mm, per_speed: 10 ms}", "{base: 0.5 mm, per_speed: 2 ms}", "0.5", Fault::Inconsistent,
              "at 500 mm/s the window is 1.5 mm, and a sound axis is 2 mm behind"},
        Wrong{"{base: 0.5 mm, per_speed: 10 ms}", "{base: 0.5 mm}", "0.5", Fault::Inconsistent, "per_speed: 4 ms"},
        // 2 counts of 10000 in 10 mm.
        Wrong{"{base: 0.5 mm, per_speed: 10 ms}", "{base: 0.0019 mm, per_speed: 10 ms}", "0.0019", Fault::OutOfRange,
              "less than 2 counts of the drive (0.002 mm)"},
        Wrong{"skew_max: 0.2 mm", "skew_max: 0.0002 mm", "0.0002", Fault::OutOfRange, "less than 2 counts"},
        Wrong{"    per_rev: 10 mm", "    per_rev: 10000 mm", "0.5 mm, per", Fault::OutOfRange, "correct per_rev"},
        Wrong{"a_max: 4000 mm/s^2", "a_max: 4000000 mm/s^2", "4000000", Fault::OutOfRange,
              "would have v_max after 0.125 ms, within one cycle; 5e+05 mm/s^2 or less"},
        // What the program counts on.
        Wrong{"run_current: 3 A,", "run_current: 3 A, counts_per_rev: 20000,", "20000", Fault::Inconsistent,
              "the program counts on counts_per_rev = 10000 of iD286-ECFA"},
        Wrong{"run_current: 3 A,", "run_current: 3 A, motor_mode: 0,", "0, enc", Fault::Inconsistent, "closed loop"},
        Wrong{"run_current: 3 A,", "run_current: 0 A,", "0 A", Fault::OutOfRange, "no torque worth its name"},
        Wrong{"run_current: 3 A,", "run_current: 0.003 A,", "0.003 A", Fault::OutOfRange, "takes up to 6.5 A"},
        // Tools that the proofs do not know.
        Wrong{"needle: {tip: [0 mm, 0 mm, -40 mm]", "needle: {tip: [0 mm, 0 mm, -43 mm]", "needle: {tip",
              Fault::Inconsistent, "the tip of 'needle' is 3 mm from the lower end of the nearest body"},
        Wrong{"probe:  {tip: [-40 mm, 0 mm, -46 mm]}", "probe:  {tip: [-48 mm, 0 mm, -46 mm]}", "probe:  {tip",
              Fault::Inconsistent, "is 6.5 mm from the lower end of the nearest body of the head ('probe_stylus')"},
        Wrong{"    needle:       {capsule: {diameter: 1.6 mm, height: 26 mm}, centre: [0 mm, 0 mm, -27 mm], on_lift: "
              "true}\n",
              "", "needle: {tip", Fault::Inconsistent, "('syringe')"},
        Wrong{"centre: [0 mm, 0 mm, -27 mm], on_lift: true}", "centre: [0 mm, 0 mm, -27 mm]}", "30 mm}\n    camera",
              Fault::Inconsistent, "'needle' does not ride on it"},
        Wrong{"probe: {axis: Z", "probe: {axis: X", "X", Fault::Inconsistent, "write axis: Z"},
        Wrong{"travel: 8 mm", "travel: 3 mm", "3 mm, retract", Fault::Inconsistent, "gives up after 3 mm"},
        Wrong{"{base: 0.5 mm, per_speed: 10 ms}", "{base: 500 mm, per_speed: 10 ms}", "500", Fault::OutOfRange,
              "it watches nothing"}));

/// With a jerk limit of 8000 mm/s^3 a stop from 500 mm/s never comes to a_max: at 250 mm/s it brakes with sqrt(v j) =
/// 2000 mm/s^2, and an axis that is 5 ms late is 2000 * 0.005^2 / 2 = 25 um behind what its speed makes of these.
TEST(Timing, a_window_that_a_sound_axis_leaves_in_a_stop_of_jerk_alone_is_refused) {
  for (const bool narrow : {true, false}) {
    Changed file;
    file.swap("j_max: 80000 mm/s^3\n    following: {base: 0.5 mm, per_speed: 10 ms}\n    skew_max: 0.2 mm",
              fmt::format("j_max: 8000 mm/s^3\n    following: {{base: {}, per_speed: 5 ms}}\n    skew_max: 0.02 mm",
                          narrow ? "24 um" : "26 um"),
              "x");
    const auto m = file.load();
    ASSERT_EQ(!m, narrow) << (m ? "" : to_text(m.error().front()));
    if (!narrow) continue;
    EXPECT_NE(m.error()[0].message.find("at 247 mm/s"), std::string::npos) << to_text(m.error()[0]);
    EXPECT_NE(m.error()[0].message.find("every fast move would stop"), std::string::npos) << to_text(m.error()[0]);
  }
}

/// The same at 4 ms: with delays that are right for that cycle, Y is 11 ms late, and leaves 0.5 mm + 10 ms * v where it
/// brakes. The simulated machine stops on the way from there to 340 mm/s, with 4.152 mm (G207).
TEST(Timing, a_window_that_a_sound_axis_leaves_while_it_brakes_is_refused) {
  Changed file;
  file.swap("cycle: 1 ms", "cycle: 4 ms", "x");
  file.swap("response_delay: 3 ms", "response_delay: 6 ms", "x");
  file.swap("response_delay: 4 ms", "response_delay: 7 ms", "x");
  file.swap("response_delay: 2.5 ms", "response_delay: 5.5 ms", "x");
  file.swap("response_delay: 2 ms", "response_delay: 5 ms", "x");
  file.swap("response_delay: 2 ms", "response_delay: 5 ms", "x");
  const auto m = file.load();
  ASSERT_FALSE(m);
  ASSERT_EQ(m.error().size(), 1u) << to_text(m.error()[1]);
  EXPECT_NE(m.error()[0].message.find("at 396.3 mm/s the window is 4.463 mm, and a sound axis is 4.588 mm behind"),
            std::string::npos)
      << to_text(m.error()[0]);
  file.swap("skew_max: 0.2 mm", "skew_max: 0.3 mm", "x");
  file.swap("following: {base: 0.5 mm, per_speed: 10 ms}\n    skew_max",
            "following: {base: 0.5 mm, per_speed: 11 ms}\n    skew_max", "x");
  const auto wider = file.load();
  EXPECT_TRUE(wider) << to_text(wider.error().front());
}

/// 61 cycles: at 0.5 ms that is 30.5 ms.
TEST(Timing, a_delay_of_more_cycles_than_are_compensated_is_refused) {
  for (const bool longer : {false, true}) {
    Changed file;
    file.swap_in_profile("std402ec.yaml", "cycle_times_us: [1000,", "cycle_times_us: [500, 1000,");
    file.swap("cycle: 1 ms", "cycle: 0.5 ms", "x");
    file.swap("response_delay: 4 ms", longer ? "response_delay: 30.6 ms" : "response_delay: 30.5 ms", "30");
    const auto m = file.load();
    ASSERT_FALSE(m) << "its window of `following` is too narrow for either";
    const auto told = std::ranges::find_if(m.error(), [](const Error& e) {
      return e.message.find("more than 30.5 ms cannot be compensated at a cycle of 0.5 ms") != std::string::npos;
    });
    ASSERT_EQ(told != m.error().end(), longer) << to_text(m.error().front());
    EXPECT_TRUE(!longer || told->where == file.where()) << file.where();
  }
}

TEST(Timing, check_warns_where_the_simulated_machine_answers_otherwise) {
  Changed file;
  file.swap("cycle: 1 ms", "cycle: 2 ms", "x");
  const auto m = file.load();
  ASSERT_TRUE(m) << to_text(m.error().front());
  EXPECT_TRUE(warns(m, "axis X states a response_delay of 3 ms, and answers after 4 ms on the simulated machine"));
}

/// At a cycle of 2 ms the simulated X answers 1 ms later than its file says: 0.5 mm at 500 mm/s.
TEST(Timing, check_names_a_path_error_that_delays_and_speed_exceed) {
  Changed file;
  file.swap("cycle: 1 ms", "cycle: 2 ms", "x");
  file.swap("response_delay: 3 ms", "response_delay: 3 ms\n    path_error: 0.4 mm", "x");
  const auto m = file.load();
  ASSERT_TRUE(m) << to_text(m.error().front());
  EXPECT_EQ(m->axes[0].path_error, 0.4);
  EXPECT_TRUE(warns(m, "axis X states a path_error of 0.4 mm"));
  EXPECT_TRUE(warns(m, "write path_error: 0.5 mm"));
  file.swap("path_error: 0.4 mm", "path_error: 0.5 mm", "x");
  EXPECT_FALSE(warns(file.load(), "states a path_error"));

  Changed measured;
  measured.swap("response_delay: 3 ms", "response_delay: 3 ms\n    path_error: 0.1 mm", "x");
  auto found = measured.load();
  ASSERT_TRUE(found) << to_text(found.error().front());
  EXPECT_FALSE(warns(found, "states a path_error"));
  found->axes[0].measured =
      config::MeasuredDelay{.delay_s = 0.0028, .within_s = 0.0001, .speed = 50, .date = "2026-11-25"};
  EXPECT_TRUE(warns(found, "write path_error: 0.15 mm"));  // 500 mm/s for 0.2 ms and 0.1 ms
}

TEST(Windows, check_warns_of_one_that_lets_the_head_out_of_its_clearance) {
  Changed file;
  file.swap("{base: 0.5 mm, per_speed: 10 ms}", "{base: 2.5 mm, per_speed: 10 ms}", "x");
  EXPECT_TRUE(warns(file.load(), "axis X may be 2.5 mm off its target at rest"));
  Changed beam;
  beam.swap("skew_max: 0.2 mm", "skew_max: 1.5 mm", "x");
  EXPECT_TRUE(warns(beam.load(), "that watches only what is fast"));
}

TEST(Turn, a_body_on_turn_needs_the_role) {
  Changed file;
  file.swap("turn: C, lift: U}", "lift: U}", "x");
  file.swap("centre: [60 mm, 0 mm, 8 mm]}", "centre: [60 mm, 0 mm, 8 mm], on_turn: true}", "true");
  const auto m = file.load();
  ASSERT_FALSE(m);
  ASSERT_EQ(m.error().size(), 1u) << to_text(m.error()[1]);
  EXPECT_EQ(m.error()[0].where, file.where());
  EXPECT_NE(m.error()[0].message.find("'camera_body' is to turn, and no axis has the role `turn`"), std::string::npos)
      << to_text(m.error()[0]);
}

/// Parked at 20, 20 with C at 90 deg a camera 60 mm to the right of the needle stands 60 mm behind it.
TEST(Turn, a_body_is_where_park_turns_it) {
  const auto with_block = [](const char* block, const char* turn) {
    Changed file;
    file.swap("centre: [60 mm, 0 mm, 8 mm]}", "centre: [60 mm, 0 mm, 8 mm], on_turn: true}", "x");
    file.swap("scene:\n", std::string("scene:\n  block: {box: [10 mm, 10 mm, 10 mm], centre: ") + block + "}\n", "x");
    file.swap("C: 0 deg, U", std::string("C: ") + turn + " deg, U", "x");
    return file.load();
  };
  EXPECT_FALSE(with_block("[80 mm, 20 mm, 6 mm]", "0"));
  EXPECT_TRUE(with_block("[80 mm, 20 mm, 6 mm]", "90"));
  EXPECT_FALSE(with_block("[20 mm, 80 mm, -10 mm]", "90"));
  const auto free = with_block("[20 mm, 80 mm, -10 mm]", "0");
  ASSERT_TRUE(free);
  EXPECT_TRUE(free->head[3].on_turn);
  EXPECT_FALSE(free->head[0].on_turn);
}

TEST(Probe, is_no_faster_than_the_axis_that_carries_it) {
  Changed file;
  file.swap("    v_max: 150 mm/s", "    v_max: 40 mm/s", "x");
  file.swap("probe: {axis: Z, ", "probe: {axis: Z, fast: 41 mm/s, ", "41");
  const auto m = file.load();
  ASSERT_FALSE(m);
  EXPECT_EQ(m.error()[0].where, file.where()) << to_text(m.error()[0]);
  EXPECT_NE(m.error()[0].message.find("v_max of axis Z, 40 mm/s"), std::string::npos) << to_text(m.error()[0]);
}

TEST(Check, warns_of_what_surprises) {
  struct Case {
    const char *from, *to, *says;
  };
  for (const Case& c :
       {Case{"speed: 5 mm/s, approach", "speed: 20 mm/s, approach", "pressed in for 25 ms and a stop (0.58 mm)"},
        Case{"search: 7 mm", "search: 8 mm", "half of the image is 7.68 mm"},
        Case{"filter: 4 ms, position_error_delay: 200 ms}}\n  z", "filter: 5 ms, position_error_delay: 200 ms}}\n  z",
             "the sides of axis Y are asked for different filter: 4 ms of 'y1', 5 ms of 'y2'"},
        Case{"run_current: 3 A,", "run_current: 3 A, input_1: 9,", "input_1 is 9, and the profile counts on 10"},
        Case{", rack_max: 12 mm", "", "axis Y may home with one side 53.75 mm farther than the other"},
        Case{"j_max: 80000 mm/s^3", "j_max: 80000000 mm/s^3", "axis X has a_max after 0.05 ms, within one cycle"},
        Case{"stack_green:    {station: io, bit: 5}", "stack_green:    {station: io, bit: 5, invert: true}",
             "'stack_green' is inverted"}}) {
    Changed file;
    file.swap(c.from, c.to, "x");
    const auto m = file.load();
    ASSERT_TRUE(m) << c.to << ": " << to_text(m.error().front());
    EXPECT_TRUE(warns(m, c.says)) << c.to;
  }
}

TEST(Stations, that_look_alike_are_told_of_until_something_tells_them_apart) {
  Changed file;
  EXPECT_TRUE(look_alikes(*file.load()).empty());
  file.swap("position: 2, alias: 2", "position: 2", "x");
  EXPECT_TRUE(look_alikes(*file.load()).empty()) << "what has no alias does not have that of the other one";
  file.swap("position: 3, alias: 3", "position: 3", "x");
  auto m = file.load();
  ASSERT_TRUE(m) << to_text(m.error().front());
  ASSERT_EQ(look_alikes(*m).size(), 1u);
  EXPECT_TRUE(warns(m, "warning: stations 'y1', 'y2' (HCFA AMD530B) look alike"));
  m->stations[2].accepted = Accepted{.serial = 7, .date = "2026-11-23"};
  EXPECT_EQ(look_alikes(*m).size(), 1u) << "another one at its place is taken for a spare part";
  m->stations[3].accepted = Accepted{.serial = 7, .date = "2026-11-23"};
  EXPECT_EQ(look_alikes(*m).size(), 1u);
  m->stations[3].accepted->serial = 8;
  EXPECT_EQ(look_alikes(*m).size(), 1u) << "nobody has compared them: a walk has found them there";
  m->stations[2].accepted->compared = m->stations[3].accepted->compared = true;
  EXPECT_TRUE(look_alikes(*m).empty());
}

TEST(Outputs, a_brake_that_is_released_while_nobody_writes_it_is_refused) {
  Changed file;
  file.swap("  healthy:        {station: io, bit: 7}",
            "  healthy:        {station: io, bit: 7}\n  z_brake: {station: io, bit: 9, invert: true}", "x");
  file.swap("clearance: 2 mm", "brake: {axis: Z, output: z_brake, time: 60 ms}\nclearance: 2 mm", "z_brake");
  const auto m = file.load();
  ASSERT_FALSE(m);
  EXPECT_EQ(m.error()[0].where, file.where());
  EXPECT_NE(m.error()[0].message.find("the axis would fall"), std::string::npos) << to_text(m.error()[0]);
}

}  // namespace
}  // namespace gantry::config
