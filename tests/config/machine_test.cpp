// The reference machine, and every way to get a machine file wrong across its rows.
#include "config/machine.hpp"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <numbers>
#include <unistd.h>

#include "changed.hpp"
#include "config/bus_notes.hpp"
#include "config/quick_stop.hpp"
#include "config/yaml.hpp"

namespace gantry::config {
namespace {

namespace fs = std::filesystem;

Machine dispenser() {
  auto m = load_machine("config/machines/dispenser.yaml");
  if (!m)
    for (const Error& e : m.error()) ADD_FAILURE() << to_text(e);
  return m ? *m : Machine{};
}

TEST(Machine, the_reference_machine_has_every_drive_of_the_project) {
  const Machine m = dispenser();
  ASSERT_EQ(m.stations.size(), 7u);
  const char* profiles[] = {"dio16", "id286", "amd530b", "amd530b", "id286", "std402ec", "iss57"};
  for (std::size_t i = 0; i < 6; ++i) {
    EXPECT_EQ(m.stations[i].profile.name, profiles[i]);
    EXPECT_EQ(m.stations[i].position, static_cast<int>(i));
    EXPECT_EQ(m.stations[i].bus, BusKind::EtherCat);
  }
  EXPECT_EQ(m.stations[6].bus, BusKind::CanOpen);
  EXPECT_EQ(m.stations[6].position, 1);
  const char* names[] = {"X", "Y", "Z", "C", "U", "F"};
  ASSERT_EQ(m.axes.size(), 6u);
  for (std::size_t i = 0; i < 6; ++i) {
    EXPECT_EQ(m.axes[i].name, names[i]);
    EXPECT_EQ(m.axes[i].id.value, i);
  }
  EXPECT_EQ(m.axes[1].drives.size(), 2u) << "a gantry axis";
  EXPECT_EQ(m.axes[3].drives[0].station, m.axes[4].drives[0].station) << "one station, two axes";
  EXPECT_EQ(m.axes[5].kind, AxisKind::Positioned);
  EXPECT_EQ(m.bus.cycle, milliseconds(1));
}

TEST(Machine, counts_and_units_are_those_of_the_file) {
  const Machine m = dispenser();
  EXPECT_DOUBLE_EQ(m.axes[0].counts_per_unit, 1000);  // 10000 counts, 10 mm
  EXPECT_DOUBLE_EQ(m.axes[2].counts_per_unit, 2000);  // 5 mm
  EXPECT_TRUE(m.axes[3].rotary);
  EXPECT_NEAR(m.axes[3].counts_per_unit * 2 * std::numbers::pi, 100000, 1e-6);  // 36 deg a revolution
  EXPECT_NEAR(m.axes[3].p_max, std::numbers::pi, 1e-12);
  EXPECT_NEAR(m.axes[3].v_max, 2 * std::numbers::pi, 1e-12);
  EXPECT_EQ(m.axes[3].following_base, 0) << "open loop: nothing to watch";
  EXPECT_EQ(m.axes[0].homing->method, 17);
  EXPECT_EQ(m.axes[2].homing->order, 0) << "Z goes first";
}

TEST(Machine, axes_answer_one_cycle_after_their_position_loop) {
  const Machine m = dispenser();
  for (std::size_t i = 0; i < 5; ++i)
    EXPECT_NEAR(m.axes[i].response_delay_s, m.sim.axes[i].lag_s + m.sim.axes[i].delay_s + 0.001, 1e-12);
}

TEST(Machine, homing_edges_stand_where_the_virtual_switches_are) {
  const Machine m = dispenser();
  for (const Axis& a : m.axes) {
    if (!a.homing) continue;
    const SimAxis& s = m.sim.axes[a.id.value];
    const double edge = a.homing->method == 17 ? s.neg_limit : a.homing->method == 18 ? s.pos_limit : s.home_switch;
    EXPECT_DOUBLE_EQ(a.homing->position, edge) << a.name;
  }
}

double bottom(const Body& b, double lift) { return b.centre.z - b.shape.size.z / 2 - (b.on_lift ? lift : 0); }

TEST(Machine, the_lift_makes_the_needle_highest_or_lowest) {
  const Machine m = dispenser();
  const double lift = find_tool(m, "needle")->lift_mm;
  double needle = 0, lowest_else = 1e9;
  for (const Body& b : m.head) {
    if (b.name == "needle")
      needle = bottom(b, 0);
    else
      lowest_else = std::min(lowest_else, bottom(b, b.on_lift ? lift : 0));
  }
  EXPECT_DOUBLE_EQ(needle, find_tool(m, "needle")->tip.z) << "the body ends at the tip";
  EXPECT_DOUBLE_EQ(
      bottom(*std::find_if(m.head.begin(), m.head.end(), [](const Body& b) { return b.name == "probe_stylus"; }), 0),
      find_tool(m, "probe")->tip.z);
  EXPECT_GE(needle, find_tool(m, "probe")->tip.z + 5);
  EXPECT_LE(needle - lift, lowest_else - 20) << "parts of 18 mm pass under all but the needle";
}

TEST(Machine, bodies_of_the_head_do_not_meet_bodies_of_the_scene_at_rest) {
  const Machine m = dispenser();
  for (const Body& h : m.head)
    for (const Body& s : m.scene) {
      double z = 0;
      for (const auto& [axis, position] : m.park)
        if (axis == m.z) z = position;
      EXPECT_GT(bottom(h, 0) + z, s.centre.z + s.shape.size.z / 2) << h.name << " over " << s.name << " when parked";
    }
}

TEST(Machine, channels_have_their_bits) {
  const Machine m = dispenser();
  for (std::size_t i = 0; i < kOutputs; ++i) {
    ASSERT_TRUE(m.outputs[i]) << name(static_cast<Output>(i));
    EXPECT_EQ(m.outputs[i]->bit, i);
  }
  for (std::size_t i = 0; i < kInputs; ++i) ASSERT_TRUE(m.inputs[i]) << name(static_cast<Input>(i));
}

TEST(Machine, what_stops_is_normally_closed) {
  std::vector<std::string_view> names;
  for (std::size_t i = 0; i < kInputs; ++i)
    if (normally_closed(static_cast<Input>(i))) names.push_back(name(static_cast<Input>(i)));
  EXPECT_EQ(names, (std::vector<std::string_view>{"stop", "door_closed", "air_ok", "safety_ok"}));  // issue 4, line 15
}

TEST(Machine, notes_tell_what_is_assumed_and_what_a_bus_loss_costs) {
  auto all = notes(dispenser());
  for (const auto& more : {assumptions(dispenser()), bus_notes(dispenser())})
    all.insert(all.end(), more.begin(), more.end());
  const auto tells = [&](std::string_view what) {
    return std::any_of(all.begin(), all.end(), [&](const std::string& n) { return n.find(what) != std::string::npos; });
  };
  EXPECT_TRUE(tells("iD286-ECFA: identity"));
  EXPECT_TRUE(tells("axis C runs open loop"));
  EXPECT_TRUE(tells("without torque it keeps its reference, because `self_locking` says"));
  EXPECT_TRUE(tells("the valve stays as it is for 100 ms"));
  EXPECT_TRUE(tells("one that goes on at its speed does 50 mm until its watchdog bites"));
}

TEST(Machine, the_kind_of_logical_map_is_separate_unless_it_is_written) {
  EXPECT_EQ(dispenser().bus.map, MapKind::Separate);
  Changed file;
  file.swap("  frames_lost_max: 3", "  frames_lost_max: 3\n  map: overlapped", "map");
  const auto m = file.load();
  ASSERT_TRUE(m) << to_text(m.error().front());
  EXPECT_EQ(m->bus.map, MapKind::Overlapped);
}

TEST(Machine, further_channels_have_names_of_their_own_and_the_bits_behind_the_known_ones) {
  Changed file;
  file.swap("  start:        {station: io, bit: 0}",
            "  vacuum: {station: io, terminal: DI15}\n  start:        {station: io, terminal: DI0}\n"
            "  tray_full: {station: io, bit: 14, invert: true}",
            "x");
  const auto m = file.load();
  ASSERT_TRUE(m) << to_text(m.error().front());
  ASSERT_EQ(m->free_inputs.size(), 2u);
  EXPECT_EQ(m->inputs[0]->bit, 0);
  const auto bits = input_bits(*m);
  ASSERT_EQ(bits.size(), kInputs + 2);
  EXPECT_EQ(bits[kInputs].bit, kInputs);
  EXPECT_EQ(bits[kInputs].name, "vacuum");
  EXPECT_EQ(bits[kInputs].channel.bit, 15);
  EXPECT_EQ(bits[kInputs + 1].bit, kInputs + 1);
  EXPECT_EQ(bits[kInputs + 1].name, "tray_full");
  EXPECT_TRUE(bits[kInputs + 1].channel.invert);
  EXPECT_EQ(output_bits(*m).size(), kOutputs);
}

TEST(Machine, more_than_32_channels_are_refused_at_the_first_that_is_too_many) {
  Changed file;  // on a second station of 16 bits, and the free bits of the first
  std::string rows;
  for (int i = 0; i < 24; ++i)
    rows += "  x" + std::to_string(i) + ": {station: " + (i < 16 ? "io2" : "io") +
            ", bit: " + std::to_string(i < 16 ? i : i - 7) + "}\n";
  file.swap("  feeder: {", "  io2: {profile: dio16, position: 6}\n  feeder: {", "x");
  file.swap("  start:        {station: io, bit: 0}\n", rows + "  start:        {station: io, bit: 8}\n", "x23");
  file.swap("  safety_ok:    {station: io, bit: 8}", "  safety_ok:    {station: io, bit: 0}", "x23");
  const auto m = file.load();
  ASSERT_FALSE(m);
  ASSERT_EQ(m.error().size(), 1u) << to_text(m.error()[1]);
  EXPECT_EQ(m.error()[0].fault, Fault::OutOfRange);
  EXPECT_NE(m.error()[0].message.find("'x23' is one too many"), std::string::npos) << to_text(m.error()[0]);
  EXPECT_EQ(m.error()[0].where, file.where());
}

TEST(Machine, an_analogue_terminal_is_no_channel) {
  Changed file;
  file.swap("  feeder: {", "  a: {profile: aio4, position: 6}\n  feeder: {", "x");
  file.swap("  start:        {station: io, bit: 0}", "  start:        {station: a, terminal: AI1}", "AI1");
  const auto m = file.load();
  ASSERT_FALSE(m);
  EXPECT_EQ(m.error()[0].where, file.where());
  EXPECT_NE(m.error()[0].message.find("carries 16 bits"), std::string::npos) << to_text(m.error()[0]);
}

TEST(Machine, check_warns_where_a_broken_wire_would_read_as_all_well) {
  EXPECT_FALSE(warns(dispenser(), "warning"));
  for (const char* name : {"stop:         ", "door_closed:  ", "air_ok:       ", "safety_ok:    "}) {
    Changed file;
    const std::string row = std::string("  ") + name + "{station: io, ";
    file.swap(row, row + "invert: true, ", "x");
    EXPECT_TRUE(warns(file.load(), "' is inverted: a broken wire reads as all well")) << name;
  }
  Changed other;
  other.swap("  start:        {station: io, ", "  start:        {station: io, invert: true, ", "x");
  EXPECT_FALSE(warns(other.load(), "warning")) << "a button that starts may be wired as one likes";
}

TEST(Machine, an_axis_that_needs_long_to_its_speed_is_told_by_its_acceleration) {
  Changed slow;
  slow.swap("a_max: 4000 mm/s^2", "a_max: 45 mm/s^2", "45");
  const auto m = slow.load();
  ASSERT_FALSE(m);
  EXPECT_EQ(m.error()[0].where, slow.where()) << to_text(m.error()[0]);
  EXPECT_NE(m.error()[0].message.find("needs 11.1 s from rest to its v_max"), std::string::npos);
  EXPECT_NE(m.error()[0].message.find("write at least 100 mm/s^2"), std::string::npos);
  Changed enough;
  enough.swap("j_max: 80000 mm/s^3", "j_max: 20 mm/s^3", "20");
  const auto other = enough.load();
  EXPECT_TRUE(other) << to_text(other.error()[0]) << ": what the message asks for is enough";
}

TEST(Machine, check_warns_of_a_first_touch_that_the_virtual_probe_does_not_bear) {
  Changed file;
  file.swap("speed: 5 mm/s, approach", "fast: 20 mm/s, speed: 5 mm/s, approach", "fast");
  EXPECT_TRUE(warns(file.load(), "warning: probe: fast is 20 mm/s, and the probe is pressed in"));
}

TEST(Machine, check_warns_where_the_io_station_leaves_the_bus_with_the_drives) {
  Changed file;
  file.swap("dio16,    position: 0", "dio16,    position: 1", "x");
  file.swap("id286,    position: 1", "id286,    position: 0", "x");
  EXPECT_TRUE(warns(file.load(), "carries stop, door_closed, air_ok, safety_ok, valve and stands behind drive 'x'"));
}

TEST(Machine, what_is_not_parked_may_end_anywhere) {
  Changed file;
  file.swap("park: {X: 20 mm, Y: 20 mm, Z: -2 mm, C: 0 deg, U: 0 mm}", "park: {}", "park");
  file.swap("scene:\n", "scene:\n  beam: {box: [20 mm, 20 mm, 20 mm], centre: [105 mm, 50 mm, 90 mm]}\n", "beam");
  const auto m = file.load();
  EXPECT_TRUE(m) << to_text(m.error()[0]);
  Changed raised;
  raised.swap("park: {X: 20 mm, Y: 20 mm, ", "park: {X: 20 mm, ", "park");
  raised.swap("scene:\n", "scene:\n  beam: {box: [20 mm, 20 mm, 20 mm], centre: [105 mm, 50 mm, 90 mm]}\n", "beam");
  EXPECT_TRUE(raised.load()) << "where Y stands is not known";
}

TEST(Machine, what_stands_at_the_clearance_from_where_homing_ends_is_no_mistake) {
  for (const auto& [x, fine] : {std::pair{"-82.001", true}, {"-81.999", false}}) {
    Changed file;
    file.swap("scene:\n",
              std::string("scene:\n  rail: {box: [16 mm, 60 mm, 30 mm], centre: [") + x + " mm, 0 mm, 90 mm]}\n",
              "rail");
    EXPECT_EQ(file.load().has_value(), fine) << x;
  }
}

class Rows : public testing::TestWithParam<Wrong> {};

TEST_P(Rows, that_contradict_are_one_mistake_at_its_place) { expect_one_mistake(GetParam()); }

INSTANTIATE_TEST_SUITE_P(
    Machine, Rows,
    testing::Values(
        Wrong{"profile: id286,    position: 1", "profile: id268,    position: 1", "id268", Fault::UnknownReference,
              "'id286'"},
        Wrong{"position: 5, ", "position: 4, ", "4, ", Fault::Inconsistent, "'z'"},
        Wrong{"position: 5, ", "position: 6, ", "6, ", Fault::OutOfRange, "6 stations"},
        Wrong{"run_current: [1 A, 1.2 A]", "run_curent: [1 A, 1.2 A]", "run_curent", Fault::UnknownReference,
              "run_current"},
        Wrong{"run_current: [1 A, 1.2 A]", "run_current: [1 A, 1.2 A, 2 A]", "run_c", Fault::BadValue, "2 axes"},
        Wrong{"run_current: [1 A, 1.2 A]", "run_current: [1 A, 1200]", "1200", Fault::BadUnit, " A'"},
        Wrong{"run_current: [1 A, 1.2 A]", "run_current: [1 A, 4.5 A]", "4.5", Fault::OutOfRange, "0.4 A .. 4 A"},
        Wrong{"run_current: [1 A, 1.2 A]", "run_current: [1 A, 1.20005 A]", "1.20005", Fault::BadValue,
              "steps of 0.001 A"},
        Wrong{"alias: 2, ", "alias: 2, declared: [filtr], ", "filtr", Fault::UnknownReference, "filter"},
        Wrong{"alias: 2, ", "alias: 2, declared: [homing_slo], ", "homing_slo", Fault::UnknownReference, "homing_slow"},
        Wrong{"run_current: 3 A,", "run_current: 3 A, homing_slow: 5,", "homing_slow", Fault::UnknownReference,
              "iD286-ECFA has no parameter 'homing_slow'"},
        Wrong{"{profile: dio16,    position: 0}", "{profile: dio16, position: 0, inputs: {home: 1}}", "{home",
              Fault::Inconsistent, "limit"},
        Wrong{"iss57,    position: 1", "iss57,    position: 0", "0", Fault::OutOfRange, "1 .. 127"},
        Wrong{"cycle: 1 ms", "cycle: 0.5 ms", "0.5", Fault::Inconsistent, "STD402EC"},
        Wrong{"cycle: 1 ms", "cycle: 1", "1", Fault::BadUnit, "lacks a unit"},
        Wrong{"frames_lost_max: 3", "map: overlaped", "overlaped", Fault::BadValue, "overlapped"},
        Wrong{"{hardware: 3,", "{hardware: 1000,", "{hard", Fault::Inconsistent, "watchdog"},
        Wrong{"drives: [{station: x}]", "drives: [{station: y3}]", "y3", Fault::UnknownReference, "'y1'"},
        Wrong{"drives: [{station: x}]", "drives: [{station: io}]", "io}]", Fault::Inconsistent, "no drive"},
        Wrong{"{station: cu, slot: 1}", "{station: cu, slot: 2}", "2}", Fault::OutOfRange, "2 axes"},
        Wrong{"{station: cu, slot: 1}", "{station: cu, slot: 0}", "{station", Fault::Inconsistent, "'C'"},
        Wrong{"travel: [0 mm, 500 mm]", "travel: [500 mm, 0 mm]", "[", Fault::Inconsistent, "less than"},
        Wrong{"v_max: 500 mm/s", "v_max: 500 deg/s", "500", Fault::BadUnit, "mm/s"},
        Wrong{"v_max: 360 deg/s", "v_max: 360 mm/s", "360", Fault::BadUnit, "rad/s"},
        Wrong{"a_max: 4000 mm/s^2", "a_max: 0 mm/s^2", "0", Fault::OutOfRange, "more than 0"},
        Wrong{"v_max: 500 mm/s", "v_max: 500000 mm/s", "500000", Fault::OutOfRange, "3e+06 rpm"},
        Wrong{"    following: {base: 0.5 mm, per_speed: 10 ms}\n", "", "X:\n    drives", Fault::MissingKey,
              "following"},
        Wrong{"order: 0, method: 18", "order: 2, method: 18", "{order: 2", Fault::Inconsistent, "before Z is up"},
        Wrong{"method: 17", "method: 15", "15", Fault::Inconsistent, "methods"},
        Wrong{"  Y:\n    drives: [{station: y1}, {station: y2}]", "  Y:\n    drives: [{station: y1}]", "0.2 mm\n",
              Fault::Inconsistent, "no skew"},
        Wrong{"    skew_max: 0.2 mm\n", "", "Y:\n    drives", Fault::MissingKey, "skew_max"},
        Wrong{"    kind: positioned\n", "", "{station: feeder}", Fault::Inconsistent, "positioned"},
        Wrong{"    per_rev: 36 deg", "    following: {base: 1 deg}\n    per_rev: 36 deg", "1 deg", Fault::Inconsistent,
              "open loop"},
        Wrong{"turn: C", "turn: X", "X", Fault::Inconsistent, "deg"},
        Wrong{"z: Z, turn", "z: F, turn", "F", Fault::Inconsistent, "streamed"},
        Wrong{"lift: U}", "lift: V}", "V", Fault::UnknownReference, "axis 'V'"},
        Wrong{"valve:          {station: io, bit: 0}", "valve:          {station: io, bit: 16}", "16",
              Fault::OutOfRange, "16 bits"},
        Wrong{"valve:          {station: io, bit: 0}", "valve:          {station: io, bit: 3}", "3}\n  stack_yellow",
              Fault::Inconsistent, "bit"},
        Wrong{"valve:          {station: io, bit: 0}", "valve:          {station: x, bit: 0}", "x, bit",
              Fault::Inconsistent, "drive"},
        Wrong{"valve:    ", "valvee:   ", "valvee", Fault::UnknownReference, "did you mean 'valve'?"},
        Wrong{"  stop:  ", "  stopp: ", "stopp", Fault::UnknownReference, "did you mean 'stop'?"},
        Wrong{"safety_ok:", "safty_ok: ", "safty_ok", Fault::UnknownReference, "did you mean 'safety_ok'?"},
        Wrong{"{station: io, bit: 2}", "{station: io}", "camera_trigger", Fault::MissingKey, "bit, terminal"},
        Wrong{"{station: io, bit: 2}", "{station: io, bit: 2, terminal: DO2}", "camera_trigger", Fault::Inconsistent,
              "bit, terminal"},
        Wrong{"{station: io, bit: 2}", "{station: io, terminal: DO22}", "DO22", Fault::UnknownReference,
              "did you mean 'DO2"},
        Wrong{"{station: io, bit: 2}", "{station: io, terminal: DI2}", "DI2", Fault::UnknownReference,
              "no output terminal 'DI2'"},
        Wrong{"{station: io, bit: 2}", "{station: io, terminal: DO3}", "3}\n  stack_yellow", Fault::Inconsistent,
              "'camera_trigger' has this bit"},
        Wrong{"lift: 30 mm", "lift: 60 mm", "60", Fault::OutOfRange, "axis U"},
        Wrong{"{capsule: {diameter: 1.6 mm, height: 26 mm}, ", "{", "needle:       {", Fault::BadValue, "exactly one"},
        Wrong{"safe_z: -5 mm", "safe_z: 5 mm", "5 mm", Fault::OutOfRange, "axis Z"},
        Wrong{"park: {X: 20 mm", "park: {X: -20 mm", "-20", Fault::OutOfRange, "axis X"},
        Wrong{"park: {X: 20 mm", "park: {Q: 20 mm", "Q", Fault::UnknownReference, "axis 'Q'"},
        Wrong{"lift: U}", "lift: Z}", "Z}", Fault::Inconsistent, "axis Z has the role 'z' already"},
        Wrong{"y: Y,", "y: X,", "X, z", Fault::Inconsistent, "axis X has the role 'x' already; write another axis"},
        Wrong{"j_max: 80000 mm/s^3", "j_max: 0.001 mm/s^3", "0.001", Fault::OutOfRange,
              "needs 1.41e+03 s from rest to its v_max; more than 10 s is taken for a slip: write at least 20 mm/s^3"},
        Wrong{"j_max: 80000 mm/s^3", "j_max: 19.9 mm/s^3", "19.9", Fault::OutOfRange, "needs 10 s"},
        Wrong{"exposure: 2 ms", "exposure: 150 ms", "width_px", Fault::Inconsistent,
              "an exposure of 150 ms is not over when its answer takes effect, 150 ms after the trigger"},
        Wrong{"scene:\n", "scene:\n  block: {box: [8 mm, 8 mm, 60 mm], centre: [20 mm, 20 mm, -30 mm]}\n", "X: 20 mm",
              Fault::Inconsistent, "park: there the head's body 'needle' is in 'block' of the scene"},
        Wrong{"scene:\n", "keep_out: {pit: {box: [8 mm, 8 mm, 60 mm], centre: [20 mm, 20 mm, -30 mm]}}\nscene:\n",
              "X: 20 mm", Fault::Inconsistent,
              "park: there the head's body 'needle' is in 'keep-out pit' of the machine"},
        // Where homing ends, at -2 mm, the carriage reaches to X -72 mm; parked to -50 mm.
        Wrong{"scene:\n", "keep_out: {cage: {box: [16 mm, 60 mm, 30 mm], centre: [-70 mm, 0 mm, 90 mm]}}\nscene:\n",
              "cage", Fault::Inconsistent,
              "where homing ends the head's body 'carriage' is in 'keep-out cage' of the machine: no job could begin"},
        Wrong{"scene:\n", "scene:\n  rail: {box: [16 mm, 60 mm, 30 mm], centre: [-81.5 mm, 0 mm, 90 mm]}\n", "rail",
              Fault::Inconsistent, "'carriage' is 1.5 mm from 'rail' of the scene, and 2 mm are kept clear"},
        Wrong{"limits: [-2 mm, 505 mm]", "limits: [2 mm, 505 mm]", "[", Fault::Inconsistent,
              "must stand beyond both ends"},
        Wrong{"start: 230 mm", "start: 830 mm", "830", Fault::OutOfRange, "limit switches"},
        Wrong{"  post:  ", "  needle: ", "needle", Fault::DuplicateKey, "head"}));

TEST(Machine, zones_to_keep_out_of_are_told_apart_from_what_stands) {
  Changed file;
  file.swap("\nscene:\n",
            "\nkeep_out:\n"
            "  door: {box: [40 mm, 20 mm, 50 mm], centre: [450 mm, 380 mm, -50 mm], rotation: 90 deg}\n"
            "  post: {cylinder: {diameter: 20 mm, height: 30 mm}, centre: [450 mm, 300 mm, -50 mm]}\n\nscene:\n",
            "door");
  const auto m = file.load();
  ASSERT_TRUE(m) << to_text(m.error().front());
  EXPECT_EQ(m->scene.size(), 3u);
  for (const Body& body : m->scene) EXPECT_FALSE(body.keep_out);
  ASSERT_EQ(m->keep_out.size(), 2u);
  EXPECT_EQ(m->keep_out[0].name, "keep-out door");
  EXPECT_EQ(m->keep_out[0].centre, (Vec3{450, 380, -50}));
  EXPECT_NEAR(m->keep_out[0].rotation_rad, M_PI / 2, 1e-12);
  EXPECT_EQ(m->keep_out[1].name, "keep-out post") << "a body may have that name too";
  EXPECT_TRUE(m->keep_out[0].keep_out && m->keep_out[1].keep_out);
}

TEST(Machine, names_that_only_miss_their_misspelt_list_are_not_told) {
  Changed file;
  file.swap("\nstations:", "\nstatons:", "statons");
  const auto m = file.load();
  ASSERT_FALSE(m);
  EXPECT_EQ(m.error().size(), 1u) << to_text(m.error().back());
  EXPECT_EQ(m.error()[0].where, file.where());
}

TEST(Machine, a_mistake_in_a_profile_is_told_with_the_profiles_place) {
  const auto folder = fs::path(testing::TempDir()) / ("gantry_profiles_" + std::to_string(::getpid()));
  fs::remove_all(folder);
  fs::copy("config", folder, fs::copy_options::recursive);
  auto text = *read_text_file((folder / "drives/iss57.yaml").string());
  text.replace(text.find("bus: canopen"), 12, "bus: canbus ");
  std::ofstream(folder / "drives/iss57.yaml") << text;
  const auto m = load_machine((folder / "machines/dispenser.yaml").string());
  fs::remove_all(folder);
  ASSERT_FALSE(m);
  ASSERT_EQ(m.error().size(), 1u) << to_text(m.error()[1]);
  EXPECT_NE(m.error()[0].where.find("drives/iss57.yaml:7:6"), std::string::npos) << to_text(m.error()[0]);
}

TEST(Machine, what_a_drive_holds_of_its_own_limits_is_compared_with_its_axis) {
  struct Case {
    const char* from;
    const char* to;
    const char* names;  ///< the parameter, in the warning or the mistake
    bool mistake;
  };
  const Case cases[] = {
      {"position_error_limit: 5500 counts", "position_error_limit: 1000 counts",
       "stations.x.parameters.position_error_limit (2102h)", false},
      {", position_error_limit: 5500 counts", "", "stations.x.parameters.position_error_limit (2102h)", false},
      {"position_error_limit: 5500 counts", "max_speed: 2400 rpm", "stations.x.parameters.max_speed (6080h)", true},
      {"position_error_delay: 200 ms", "max_speed: 400000 P/S", "stations.y1.parameters.max_speed (6080h)", true},
      {"position_error_delay: 200 ms", "position_error_limit: 0.5 rev",
       "stations.y1.parameters.position_error_limit (2030h)", false},
      {", position_error_delay: 200 ms", "", "stations.y1.parameters.position_error_delay (2041h)", false},
      {"filter: 4 ms", "filter: 20 ms", "stations.y1.parameters.filter (2010h)", false},
      {"position_error_limit: 5500 counts", "soft_limit_low: 0, soft_limit_high: 500000",
       "stations.x.parameters.soft_limit_high (607Dh:2)", true},
      {"run_current: [1 A, 1.2 A]",
       "run_current: 1 A, soft_limits_on: 3, soft_limit_low: 0, soft_limit_high: [100000, 80000]",
       "stations.cu.parameters.soft_limit_high (213Dh)", true},
  };
  for (const Case& c : cases) {
    Changed file;
    file.swap(c.from, c.to, "x");
    const auto m = file.load();
    EXPECT_EQ(m.has_value(), !c.mistake) << c.to;
    if (c.mistake && !m) {
      EXPECT_NE(to_text(m.error().front()).find(c.names), std::string::npos) << to_text(m.error().front());
    }
    if (!c.mistake) {
      EXPECT_TRUE(warns(m, c.names)) << c.to;
    }
  }
}

// What the manuals say of 605Ah: AMD530B 8.4 lists it, ISS57 1.2.2 too (0 frees the motor); iD286 and STD402EC do not.
TEST(Machine, a_quick_stop_brakes_where_a_manual_says_so_and_its_ramp_is_set) {
  const Machine m = dispenser();
  const auto of = [&](const Machine& machine, std::string_view name, int slot = 0) {
    return quick_stop_of(std::ranges::find(machine.stations, name, &Station::name)->profile, slot);
  };
  EXPECT_EQ(of(m, "x"), QuickStop::Unknown);
  EXPECT_EQ(of(m, "y1"), QuickStop::Brakes);
  EXPECT_EQ(of(m, "z"), QuickStop::Unknown);
  EXPECT_EQ(of(m, "cu", 1), QuickStop::Absent);
  for (const auto& [to, expected] : {std::pair{"quick_stop_option: 6", QuickStop::Brakes},
                                     {"quick_stop_option: 0", QuickStop::Brakes},
                                     {"quick_stop_option: 1", QuickStop::Unknown},  // 6084h is set by nobody
                                     {"quick_stop_option: 3", QuickStop::Unknown},  // 60C6h is not there
                                     {"quick_stop_deceleration: 0", QuickStop::Unknown}}) {
    Changed file;
    file.swap("position_error_delay: 200 ms", to, "x");
    const auto changed = file.load();
    ASSERT_TRUE(changed) << to << ": " << to_text(changed.error().front());
    EXPECT_EQ(of(*changed, "y1"), expected) << to;
  }
  EXPECT_TRUE(std::ranges::any_of(bus_notes(m), [](const std::string& n) {
    return n.find("axis X") != std::string::npos && n.find("50 mm in every 100 ms") != std::string::npos;
  }));
}

// AMD530B 7.2: DI4 latches with P02.03 = 5 alone; iD286: IN6 with 17.
TEST(Machine, a_probe_whose_input_has_another_function_is_a_mistake) {
  const std::string z =
      "z:      {profile: id286,    position: 4, alias: 4, parameters: {run_current: 3 A, encoder_counts: 10000, "
      "position_error_limit: 4000 counts, brake_mode: 1";
  const auto refused = [&](const std::string& instead, const std::string& why, bool amd) {
    Changed file;
    file.swap(z, instead, "x");
    if (amd) file.swap("response_delay: 2.5 ms", "response_delay: 4 ms", "x");
    const auto m = file.load();
    ASSERT_FALSE(m) << instead;
    EXPECT_NE(to_text(m.error().front()).find(why), std::string::npos) << to_text(m.error().front());
  };
  const std::string amd =
      "z:      {profile: amd530b, position: 4, alias: 4, parameters: {run_current: 3 A, filter: 4 ms";
  refused(amd, "input_4 = 5 (function of DI4; 4 is the emergency stop, 5 probe 1): nothing sets it", true);
  refused(amd + ", input_4: 4", "it is to hold 4; write stations.z.parameters.input_4: 5", true);
  refused(z + ", input_6: 0", "write stations.z.parameters.input_6: 17", false);
}

// AMD530B 7.2: probe 1 is DI4, which is the emergency stop's from the factory.
TEST(Machine, a_probe_that_takes_the_emergency_stop_must_be_acknowledged) {
  EXPECT_TRUE(wanted_on_steel(dispenser()).empty());
  Changed file;
  file.swap(
      "z:      {profile: id286,    position: 4, alias: 4, parameters: {run_current: 3 A, encoder_counts: 10000, "
      "position_error_limit: 4000 counts, brake_mode: 1}}",
      "z:      {profile: amd530b, position: 4, alias: 4, parameters: {run_current: 3 A, filter: 4 ms, input_4: 5}}",
      "x");
  file.swap("response_delay: 2.5 ms", "response_delay: 4 ms", "x");
  const auto m = file.load();
  ASSERT_TRUE(m) << to_text(m.error().front());
  const auto wanted = wanted_on_steel(*m);
  ASSERT_EQ(wanted.size(), 1u);
  EXPECT_NE(wanted.front().find("station 'z'"), std::string::npos) << wanted.front();
  EXPECT_TRUE(warns(m, "emergency_stop_elsewhere"));
  file.swap("filter: 4 ms, input_4: 5}}", "filter: 4 ms, input_4: 5}, emergency_stop_elsewhere: true}", "x");
  const auto acknowledged = file.load();
  ASSERT_TRUE(acknowledged) << to_text(acknowledged.error().front());
  EXPECT_TRUE(wanted_on_steel(*acknowledged).empty());
}

TEST(Machine, a_brake_of_the_machine_is_a_free_output_of_an_axis) {
  EXPECT_FALSE(dispenser().brake);
  Changed file;
  file.swap("  healthy:        {station: io, bit: 7}",
            "  healthy:        {station: io, bit: 7}\n  z_brake: {station: io, bit: 9}", "x");
  file.swap("clearance: 2 mm", "brake: {axis: Z, output: z_brake, time: 60 ms}\nclearance: 2 mm", "x");
  const auto m = file.load();
  ASSERT_TRUE(m) << to_text(m.error().front());
  ASSERT_TRUE(m->brake);
  EXPECT_EQ(m->brake->axis, m->z);
  EXPECT_EQ(m->brake->bit, kOutputs);
  EXPECT_EQ(m->brake->time_s, 0.06);
  EXPECT_EQ(m->brake->release_s, 0.06) << "as long as it takes to hold";
  file.swap("time: 60 ms}", "time: 60 ms, release: 150 ms}", "x");
  const auto slow = file.load();
  ASSERT_TRUE(slow) << to_text(slow.error().front());
  EXPECT_EQ(slow->brake->release_s, 0.15);
  file.swap("output: z_brake", "output: valve", "valve");
  EXPECT_FALSE(file.load()) << "a name that has a meaning is no brake";
}

TEST(Machine, a_row_that_homing_sets_may_be_declared_of_a_drive) {
  Changed file;
  file.swap("position: 1, alias: 1, ", "position: 1, alias: 1, declared: [homing_slow, filter], ", "x");
  const auto m = file.load();
  ASSERT_TRUE(m) << to_text(m.error().front());
  EXPECT_EQ(m->stations[1].profile.declared, (std::vector<std::string>{"homing_slow", "filter"}));
  EXPECT_TRUE(m->stations[4].profile.declared.empty());
  file.swap("position: 0}", "position: 0, declared: [homing_slow]}", "homing_slow");
  EXPECT_FALSE(file.load()) << "a station without a drive homes nothing";
}

}  // namespace
}  // namespace gantry::config
