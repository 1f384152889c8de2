#include "sim/world/world.hpp"

#include <filesystem>
#include <gtest/gtest.h>

#include "sim/script/script.hpp"
#include "sim/world/world_log.hpp"
#include "tests/sim/world/sample.hpp"

namespace gantry::sim {
namespace {

using config::bit;
using config::Input;
using config::Output;
using sample::Stepper;
using sample::tool_at;

class InWorld : public testing::Test {
 protected:
  explicit InWorld(
      const char* placement = "dx=1.2 mm, dy=-0.8 mm, rot=1.1 deg, dz=0.2 mm, tilt_x=0.03 deg, tilt_y=0 deg")
      : machine(sample::machine()), world(machine, clock, 7, *parse_placement(placement)), step{world} {
    EXPECT_TRUE(world.load_board(board_plan(sample::recipe())));
    world.begin_job();
    const BoardPlacement p = draw_placement(machine.sim, 7, 0, *parse_placement(placement));
    truth = BoardTruth(board_plan(sample::recipe()), {100, 80, 0}, p);
  }
  std::vector<ScriptEntry> script(const char* yaml) const { return *parse_script(yaml, "test", machine); }
  AxisVec needle_over(Vec2 board, double gap) const { return tool_at(machine, "needle", truth.to_machine(board, gap)); }

  VirtualClock clock;
  config::Machine machine;
  World world;
  Stepper step;
  BoardTruth truth;
};

TEST_F(InWorld, a_bead_begins_and_ends_where_the_valve_truly_moves) {
  // 20 mm/s along x from 25 to 65 at y = 60; the valve lags 2.3 ms and 1.7 ms.
  const AxisVec a = needle_over({25, 60}, 0.3), b = needle_over({65, 60}, 0.3);
  step.to(a);
  const auto at = [&](double x) {
    AxisVec q = a;
    const double t = (x - 25) / 40;
    for (std::size_t i = 0; i < q.size(); ++i) q[i] += (b[i] - a[i]) * t;
    return q;
  };
  double x = 25;
  for (int k = 0; k < 2000; ++k) {
    x += 0.02;
    step.outputs = (x >= 30 - 1e-9 && x < 60 - 1e-9) ? bit(Output::Valve) : 0;
    step.to(at(x));
  }
  const auto d = world.deposits();
  ASSERT_EQ(d.size(), 1u);
  EXPECT_EQ(d[0].id, "b1");
  EXPECT_NEAR(d[0].board_mm.front().x, 30 + 20 * 0.0023, 1e-9);
  EXPECT_NEAR(d[0].board_mm.back().x, 60 + 20 * 0.0017, 1e-9);
  for (const Vec3& p : d[0].board_mm) {
    EXPECT_NEAR(p.y, 60, 1e-9);
    EXPECT_NEAR(p.z, 0.3, 1e-9);
  }
}

TEST_F(InWorld, the_hidden_boards_place_is_what_decides) {
  // The controller believes in the nominal placement: every deposit is off by the placement, turned into the board's
  // frame.
  const BoardTruth nominal(board_plan(sample::recipe()), {100, 80, 0}, {});
  const AxisVec q = tool_at(machine, "needle", nominal.to_machine({20, 20}, 2));
  step.to(q);
  step.outputs = bit(Output::Valve);
  step.move(q, q, 20);
  step.outputs = 0;
  step.move(q, q, 20);
  const auto d = world.deposits();
  ASSERT_EQ(d.size(), 1u);
  const double angle = 1.1 * std::numbers::pi / 180;
  const Vec2 expected = rotated(Vec2{20, 20} - Vec2{1.2, -0.8}, -angle);
  EXPECT_NEAR(d[0].board_mm[0].x, expected.x, 1e-9);
  EXPECT_NEAR(d[0].board_mm[0].y, expected.y, 1e-9);
  EXPECT_EQ(d[0].id, "d1");
  EXPECT_NEAR(d[0].error_mm, norm(expected - Vec2{20, 20}), 1e-9);
}

TEST_F(InWorld, the_probe_closes_at_the_true_surface_and_on_parts) {
  const auto contact_over = [&](Vec3 machine_point) {
    AxisVec q = tool_at(machine, "probe", machine_point);
    return step.to(q).probe_contact - (machine_point.z - 0 + 90 + 15 - machine_point.z);
  };
  const Vec3 bare = truth.to_machine({90, 30}, 0);
  EXPECT_NEAR(contact_over({bare.x, bare.y, 40}), bare.z, 1e-9);
  const Vec3 relay = truth.to_machine({60, 40}, 15);
  EXPECT_NEAR(contact_over({relay.x, relay.y, 40}), relay.z, 1e-9);
  EXPECT_NEAR(contact_over({350, 250, 70}), 60, 1e-9) << "the post";
  EXPECT_NEAR(contact_over({10, 10, 40}), 0, 1e-9) << "the pallet";
  EXPECT_LT(step.to(tool_at(machine, "probe", {-50, 10, 40})).probe_contact, -1e6) << "nothing there";
}

TEST_F(InWorld, the_probe_does_not_touch_what_hangs_over_its_tip) {
  machine.scene.push_back({"shelf", {config::Shape::Kind::Box, {40, 40, 4}}, {10, 10, 60}, 0, false});
  World roofed(machine, clock, 7, {});
  Stepper in_it{roofed};
  const AxisVec below = tool_at(machine, "probe", {10, 10, 40}), above = tool_at(machine, "probe", {10, 10, 70});
  const auto height_of_contact = [&](const AxisVec& q, double tip) {
    return in_it.to(q).probe_contact - q[machine.probe.axis.value] + tip;
  };
  EXPECT_NEAR(height_of_contact(below, 40), 0, 1e-9) << "the pallet";
  in_it.to(tool_at(machine, "probe", {100, 10, 70}));  // nobody gets there through the shelf
  EXPECT_NEAR(height_of_contact(above, 70), 62, 1e-9) << "from above it is the shelf";
}

TEST_F(InWorld, a_zone_to_keep_out_of_is_no_matter) {
  machine.keep_out = {{"keep-out pit", {config::Shape::Kind::Box, {60, 60, 80}}, {10, 10, 40}, 0, false, false, true}};
  World zoned(machine, clock, 7, {});
  Stepper in_it{zoned};
  const AxisVec above = tool_at(machine, "probe", {10, 10, 90}), within = tool_at(machine, "probe", {10, 10, 40});
  in_it.to(above);
  in_it.move(above, within, 100);
  EXPECT_TRUE(zoned.collisions().empty());
  EXPECT_NEAR(in_it.to(within).probe_contact - within[machine.probe.axis.value] + 40, 0, 1e-9) << "the pallet";
}

TEST_F(InWorld, a_crash_is_counted_with_bodies_point_and_time) {
  AxisVec a = tool_at(machine, "needle", truth.to_machine({60, 40}, 30)),
          b = tool_at(machine, "needle", truth.to_machine({60, 40}, 10));
  step.to(a);
  step.move(a, b, 100);
  const auto c = world.collisions();
  ASSERT_EQ(c.size(), 1u);
  EXPECT_EQ(c[0].moving, "needle");
  EXPECT_EQ(c[0].standing, "relay");
  EXPECT_NEAR(c[0].at.z, truth.to_machine({60, 40}, 15).z, 0.3);
  EXPECT_GT(c[0].t_s, 0);
  world.begin_job();
  EXPECT_TRUE(world.collisions().empty());
}

TEST_F(InWorld, the_camera_shows_where_the_head_was_when_the_trigger_rose) {
  const AxisVec q = tool_at(machine, "camera", truth.to_machine({10, 10}, 0));
  step.outputs = bit(Output::CameraLight);
  step.to(q);
  EXPECT_EQ(world.camera().latest(), 0u);
  EXPECT_FALSE(world.camera().fetch(0, milliseconds(5)));
  step.outputs |= bit(Output::CameraTrigger);
  step.to(q);
  step.to(q);
  ASSERT_EQ(world.camera().latest(), 1u) << "a level is one exposure";
  const auto frame = world.camera().fetch(0, milliseconds(5));
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->counter, 1u);
  EXPECT_GT(frame->image.at(320, 256), 180);
  EXPECT_LT(frame->image.at(320 + 60, 256), 120) << "50 px radius";
  // A new trigger is a new attempt with new noise; a new job begins with the same noise again.
  step.outputs &= ~bit(Output::CameraTrigger);
  step.to(q);
  step.outputs |= bit(Output::CameraTrigger);
  step.to(q);
  EXPECT_NE(world.camera().fetch(1, {})->image.pixels, frame->image.pixels);
  world.begin_job();
  step.outputs &= ~bit(Output::CameraTrigger);
  step.to(q);
  step.outputs |= bit(Output::CameraTrigger);
  step.to(q);
  EXPECT_EQ(world.camera().fetch(2, {})->image.pixels, frame->image.pixels);
}

TEST_F(InWorld, buttons_door_air_and_clamp_are_inputs) {
  machine.outputs[static_cast<std::size_t>(Output::Clamp)] = config::Channel{};
  World w(machine, clock, 1, std::nullopt);
  Stepper s{w};
  const std::uint32_t rest = bit(Input::Stop) | bit(Input::DoorClosed) | bit(Input::AirOk) | bit(Input::SafetyOk) |
                             bit(Input::Mode);  // contacts that stop are closed, the mode is automatic, no button is on
  EXPECT_EQ(s.to({}).inputs, rest) << "the clamp follows its output";
  s.outputs = bit(Output::Clamp);
  EXPECT_EQ(s.to({}).inputs, rest | bit(Input::ClampClosed));
  EXPECT_TRUE(
      w.add_script(script("- {do: press, input: start, hold: 3 ms}\n"
                          "- {at: cycle 8, do: set_input, input: door_closed, on: false}\n")));
  std::vector<bool> start, closed;
  for (int k = 3; k < 12; ++k) {
    const auto in = s.to({}).inputs;
    start.push_back(in & bit(Input::Start));
    closed.push_back(in & bit(Input::DoorClosed));
  }
  EXPECT_EQ(start, (std::vector<bool>{1, 1, 1, 0, 0, 0, 0, 0, 0}));
  EXPECT_EQ(closed, (std::vector<bool>{1, 1, 1, 1, 1, 0, 0, 0, 0}));
}

TEST_F(InWorld, a_broken_wire_reads_0_for_good_and_an_emergency_stop_opens_the_safety_chain) {
  World w(machine, clock, 1, std::nullopt);
  Stepper s{w};
  const auto on = [&](Input input) { return (s.to({}).inputs & bit(input)) != 0; };
  EXPECT_TRUE(on(Input::Stop));
  ASSERT_TRUE(w.add_script(script("- {do: break_wire, input: stop}\n- {do: break_wire, input: start}\n")));
  s.to({});
  EXPECT_FALSE(on(Input::Stop)) << "a stop button whose wire is broken is pressed";
  ASSERT_TRUE(
      w.add_script(script("- {do: press, input: start, hold: 5 ms}\n- {do: set_input, input: stop, on: true}\n")));
  s.to({});
  EXPECT_FALSE(on(Input::Start));
  EXPECT_FALSE(on(Input::Stop));
  ASSERT_TRUE(w.add_script(script("- {do: emergency_stop}\n")));
  EXPECT_EQ(s.to({}).bus.size(), 1u) << "the bus side takes the drives' supply";
  EXPECT_FALSE(on(Input::SafetyOk));
  EXPECT_TRUE(on(Input::DoorClosed));
  ASSERT_TRUE(w.add_script(script("- {do: emergency_release}\n")));
  s.to({});
  EXPECT_TRUE(on(Input::SafetyOk));
}

TEST_F(InWorld, a_stop_button_opens_its_contact_while_it_is_pressed) {
  World w(machine, clock, 1, std::nullopt);
  Stepper s{w};
  s.to({});
  ASSERT_TRUE(w.add_script(script("- {do: press, input: stop, hold: 3 ms}\n")));
  std::vector<bool> closed;
  for (int k = 0; k < 5; ++k) closed.push_back(s.to({}).inputs & bit(Input::Stop));
  EXPECT_EQ(closed, (std::vector<bool>{0, 0, 0, 1, 1}));
}

TEST_F(InWorld, the_board_changes_while_the_clamp_is_open_and_only_then) {
  World w(machine, clock, 7, std::nullopt);
  ASSERT_TRUE(w.load_board(board_plan(sample::recipe())));
  Stepper s{w};
  const auto clamp = [&](bool closed, int cycles) {
    s.outputs = closed ? bit(Output::Clamp) : 0u;
    for (int k = 0; k < cycles; ++k) s.to({});
  };
  const auto placed = [&](std::uint64_t board) { return to_text(draw_placement(machine.sim, 7, board, std::nullopt)); };
  clamp(false, 500);
  EXPECT_EQ(w.placement(), placed(0)) << "it lies there open, and nobody changes what was never clamped";
  clamp(true, 500);
  w.begin_job();
  EXPECT_EQ(w.placement(), placed(0));
  ASSERT_TRUE(w.add_script(script("- {do: remove_mark, name: M1}\n")));
  clamp(true, 5);
  w.begin_job();  // again without opening the clamp
  EXPECT_EQ(w.placement(), placed(0)) << "the same board";
  clamp(false, 100);
  clamp(true, 10);
  EXPECT_EQ(w.placement(), placed(0)) << "100 ms are too short for a pair of hands";
  clamp(false, 400);
  EXPECT_EQ(w.placement(), placed(0)) << "what was made is there until the next one";
  clamp(true, 1);
  EXPECT_EQ(w.placement(), placed(1));
  EXPECT_TRUE(w.holds_board(board_plan(sample::recipe())));
  EXPECT_TRUE(w.add_script(script("- {at: mark M1, do: camera_dead}\n"))) << "the new board has all its marks";
  clamp(false, 400);
  w.begin_job();
  EXPECT_EQ(w.placement(), placed(2)) << "and what a script does at job start it does to the new board";
  clamp(true, 400);
  EXPECT_EQ(w.placement(), placed(2)) << "once";
  clamp(false, 400);
  ASSERT_TRUE(w.load_board(board_plan(sample::recipe())));
  clamp(true, 400);
  EXPECT_EQ(w.placement(), placed(3)) << "one that is put in by order is not changed again";
}

TEST_F(InWorld, a_clamp_that_nobody_commands_keeps_its_board) {
  World w(machine, clock, 7, std::nullopt);
  ASSERT_TRUE(w.load_board(board_plan(sample::recipe())));
  const std::string first = w.placement();
  Time now{};
  std::uint64_t cycle = 0;
  for (int k = 0; k < 1500; ++k) {
    const bool alive = k < 500 || k >= 1000;  // the controller dies and is started again
    w.step(++cycle, now += milliseconds(1), {{}, alive ? bit(Output::Clamp) : 0u, alive});
  }
  EXPECT_EQ(w.placement(), first);
}

TEST_F(InWorld, scripts_wait_for_what_the_world_sees) {
  ASSERT_TRUE(
      world.add_script(script("- {at: feature dot 2, do: drive_fault, axis: X, code: 0x7500}\n"
                              "- {at: mark M1, do: remove_mark, name: M1}\n")));
  const auto dot = [&](Vec2 at) {
    const AxisVec q = needle_over(at, 0.3);
    step.to(q);
    step.outputs = bit(Output::Valve);
    std::size_t actions = 0;
    for (int k = 0; k < 10; ++k) actions += step.to(q).bus.size();
    step.outputs = 0;
    for (int k = 0; k < 10; ++k) actions += step.to(q).bus.size();
    return actions;
  };
  EXPECT_EQ(dot({20, 20}), 0u);
  EXPECT_EQ(dot({25, 20}), 1u);
  EXPECT_EQ(dot({25, 20}), 0u) << "once";
  const AxisVec q = tool_at(machine, "camera", truth.to_machine({10, 10}, 0));
  step.outputs = bit(Output::CameraLight);
  step.to(q);
  step.outputs |= bit(Output::CameraTrigger);
  step.to(q);
  const auto frame = world.camera().fetch(0, {});
  ASSERT_TRUE(frame);
  EXPECT_LT(frame->image.at(320, 256), 120) << "gone before the picture was taken";
}

TEST_F(InWorld, an_entry_that_can_never_happen_is_refused_with_its_place_and_the_nearest_word) {
  struct Never {
    const char *entry, *says;
  };
  for (const auto& [entry, says] : {
           Never{"{at: feature b2, do: camera_dead}", "feature 'b2'; did you mean"},
           Never{"{at: feature dot 3, do: camera_dead}", "no dot 3; the board has 2"},
           Never{"{at: feature bead 2, do: camera_dead}", "no bead 2; the board has 1"},
           Never{"{at: touch 1, do: camera_dead}", "no touch 1; the board has 0"},
           Never{"{at: mark X9Y, do: camera_dead}", "no mark 'X9Y'"},
           Never{"{do: remove_mark, name: M11}", "did you mean 'M1'?"},
           Never{"{do: remove_obstacle, name: brick}", "no obstacle 'brick'"},
       }) {
    const auto added = world.add_script(script(entry));
    ASSERT_FALSE(added) << entry;
    EXPECT_EQ(added.error().fault, Fault::UnknownReference) << entry;
    EXPECT_EQ(added.error().where, "test:1:1") << entry;
    EXPECT_NE(added.error().message.find(says), std::string::npos) << added.error().message;
    World later(machine, clock, 1, std::nullopt);
    EXPECT_TRUE(later.add_script(script(entry))) << "which board comes is not known yet";
    EXPECT_FALSE(later.load_board(board_plan(sample::recipe()))) << entry;
  }
  EXPECT_TRUE(world.add_script(
      script("- {do: add_obstacle, name: brick, centre: [10 mm, 20 mm, 300 mm], size: [1 mm, 2 mm, 3 mm]}\n"
             "- {at: job start, do: remove_obstacle, name: brick}\n"
             "- {do: stain, by: [1 mm, 1 mm], diameter: 1 mm}\n")));
}

TEST_F(InWorld, is_a_pure_function_of_seed_and_steps) {
  const auto run = [&] {
    World w(machine, clock, 42, std::nullopt);
    EXPECT_TRUE(w.load_board(board_plan(sample::recipe())));
    w.begin_job();
    Stepper s{w};
    const AxisVec a = needle_over({30, 60}, 0.3), b = needle_over({60, 60}, 0.3);
    s.outputs = bit(Output::Valve);
    s.move(a, b, 500);
    s.outputs = 0;
    s.move(b, a, 50);
    return std::pair(w.deposits()[0].board_mm, w.placement());
  };
  EXPECT_EQ(run(), run());
}

TEST(WorldMemory, board_deposits_and_motors_survive_the_world_even_in_the_middle_of_a_bead) {
  const auto dir = sample::temporary("gantry-world-memory-test");
  std::filesystem::remove_all(dir);
  VirtualClock clock;
  const config::Machine machine = sample::machine();
  std::string placement;
  std::vector<Vec3> dot, bead;
  {
    World w(machine, clock, 3, std::nullopt);
    auto log = WorldLog::open(dir);
    ASSERT_TRUE(log) << log.error().message;
    EXPECT_FALSE(WorldLog::open(dir)) << "one owner";
    w.remember(std::move(*log));
    ASSERT_TRUE(w.load_board(board_plan(sample::recipe())));
    placement = w.placement();
    ASSERT_TRUE(
        w.add_script(*parse_script("{do: stain, name: M1, by: [0 mm, 0 mm], diameter: 1 mm}", "test", machine)));
    Stepper s{w};
    s.outputs = bit(Output::Valve);
    const AxisVec q = tool_at(machine, "needle", {140, 110, 5});
    s.move(q, q, 30);
    s.outputs = 0;
    s.move(q, q, 30);
    dot = w.deposits()[0].board_mm;
    w.begin_job();
    s.outputs = bit(Output::Valve);
    s.move(q, tool_at(machine, "needle", {150, 110, 5}), 200);
    bead = w.deposits()[0].board_mm;
    const double motors[] = {1.5, 2.5};
    w.keep_motors(motors);
  }
  World w(machine, clock, 3, std::nullopt);
  auto log = WorldLog::open(dir);
  ASSERT_TRUE(log) << log.error().message;
  w.remember(std::move(*log));
  EXPECT_TRUE(w.holds_board(board_plan(sample::recipe())));
  EXPECT_EQ(w.placement(), placement);
  const auto d = w.deposits();
  ASSERT_EQ(d.size(), 1u) << "of the job that was interrupted";
  EXPECT_EQ(d[0].board_mm, bead);
  ASSERT_TRUE(w.remembered_motors());
  EXPECT_EQ(*w.remembered_motors(), (std::vector<double>{1.5, 2.5}));
  std::filesystem::remove_all(dir);
}

TEST(WorldMemory, a_board_that_was_let_go_is_another_one_in_the_next_life_one_that_was_held_is_not) {
  const auto dir = sample::temporary("gantry-world-clamp-test");
  std::filesystem::remove_all(dir);
  VirtualClock clock;
  const config::Machine machine = sample::machine();
  const AxisVec q = tool_at(machine, "needle", {140, 110, 5});
  const auto life = [&](bool lets_go) {
    World w(machine, clock, 3, std::nullopt);
    auto log = WorldLog::open(dir);
    EXPECT_TRUE(log);
    w.remember(std::move(*log));
    const BoardPlan plan = board_plan(sample::recipe());
    EXPECT_TRUE(w.holds_board(plan) || w.load_board(plan));
    Stepper s{w};
    s.outputs = bit(Output::Clamp);
    s.move(q, q, 10);
    const std::string placement = w.placement();
    if (lets_go) s.outputs = 0, s.move(q, q, 1);  // the program ends at once
    return placement;
  };
  const std::string first = life(false), again = life(true), second = life(true), third = life(false);
  EXPECT_EQ(first, again);
  EXPECT_NE(again, second);
  EXPECT_NE(second, third);
  EXPECT_EQ(life(false), third);
  std::filesystem::remove_all(dir);
}

}  // namespace
}  // namespace gantry::sim
