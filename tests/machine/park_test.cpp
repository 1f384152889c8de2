// Parking on the whole machine in virtual time: where it ends and by which path, what it refuses, and what a stop
// leaves.
#include "app/job/park.hpp"

#include <array>
#include <cmath>
#include <fmt/format.h>

#include "app/job/limits.hpp"
#include "tests/machine/idle.hpp"

namespace gantry {
namespace {

using run::OrderKind;
using test::Idle;
using test::Rig;

constexpr std::size_t kX = 0, kY = 1, kZ = 2;
using test::kShort;
constexpr std::array<double, 5> kParked{20, 20, -2, 0, 0};  // as config/machines/dispenser.yaml says: X, Y, Z, C, U
constexpr double kSafeZ = -5;                               // likewise

bool on(const cycle::Snapshot& s, config::Output output) { return (s.outputs & config::bit(output)) != 0; }

/// A machine that is up, and all that its loop has told of every cycle.
struct Bench {
  explicit Bench(const test::RigOptions& options = {}, bool homed = true) : rig(options) {
    const auto up = owner().bring_up();
    EXPECT_TRUE(up) << to_text(up.error());
    if (homed) {
      const auto done = owner().home();
      EXPECT_TRUE(done) << to_text(done.error());
    }
    listen();
  }
  ~Bench() { owner().on_step({}); }
  Bench(const Bench&) = delete;
  Bench& operator=(const Bench&) = delete;
  void listen() {
    owner().on_step([this] {
      cycles.push_back(now());
      valve_opened = valve_opened || on(now(), config::Output::Valve);
      if (on_cycle) on_cycle();
    });
  }
  [[nodiscard]] run::Owner& owner() { return rig.owner(); }
  [[nodiscard]] const cycle::Snapshot& now() { return rig.owner().latest(); }
  Result<void> park() {
    cycles.clear();
    return owner().park();
  }
  /// Y and X first, then Z and the others: at the safe height nothing stands in the way of the head.
  void go(double x, double y, double z, double c_deg = 0, double u = 0) {
    const AxisVec from = now().target;
    const std::array<std::map<std::string, double>, 2> legs{
        {{{"X", x - from[kX]}, {"Y", y - from[kY]}},
         {{"Z", z - from[kZ]}, {"C", c_deg - from[3] * 180 / M_PI}, {"U", u - from[4]}}}};
    for (const auto& leg : legs) {
      job::JogWords words{.by = {}, .speed = "400 mm/s"};
      for (const auto& [axis, by] : leg)
        if (std::abs(by) > 1e-3) words.by[axis] = fmt::format("{:.9f} {}", by, axis == "C" ? "deg" : "mm");
      if (words.by.empty()) continue;
      const auto done = owner().jog(words);
      ASSERT_TRUE(done) << to_text(done.error());
    }
  }
  void expect_parked() {
    for (std::size_t i = 0; i < kParked.size(); ++i) EXPECT_NEAR(now().target[i], kParked[i], 1e-6) << i;
    EXPECT_EQ(now().state, cycle::State::Ready);
    for (int i = 0; i < 200; ++i) ASSERT_TRUE(owner().idle());
    for (std::size_t i = 0; i < kParked.size(); ++i) EXPECT_NEAR(now().actual[i], kParked[i], 0.002) << i;
    EXPECT_FALSE(valve_opened);
    EXPECT_TRUE(owner().world()->collisions()->empty());
  }
  /// Below the safe height the head has gone nowhere but up.
  void expect_straight_up_first() {
    ASSERT_FALSE(cycles.empty());
    const AxisVec from = cycles.front().target;
    double z = from[kZ];
    for (const auto& s : cycles) {
      if (s.target[kZ] >= kSafeZ - 1e-3) break;
      ASSERT_GE(s.target[kZ], z - 1e-9) << s.cycle;
      z = s.target[kZ];
      for (const std::size_t i : {0u, 1u, 3u, 4u}) ASSERT_NEAR(s.target[i], from[i], 1e-9) << i << " " << s.cycle;
    }
  }
  /// Refused with this fault, and not a count was sent.
  Error expect_refused(Fault fault) {
    for (int i = 0; i < 20; ++i) EXPECT_TRUE(owner().idle());
    const auto counts = now().counts;
    const auto done = park();
    for (int i = 0; i < 50; ++i) EXPECT_TRUE(owner().idle());
    EXPECT_FALSE(done);
    if (done) return {};
    EXPECT_EQ(done.error().fault, fault) << to_text(done.error());
    EXPECT_FALSE(cycles.empty());
    for (const auto& c : cycles) EXPECT_EQ(c.counts, counts) << c.cycle;
    return done.error();
  }

  Rig rig;
  std::vector<cycle::Snapshot> cycles;
  std::function<void()> on_cycle;
  bool valve_opened = false;
};

// ---- where it ends ----

TEST(Park, from_anywhere_ends_at_the_park_position_straight_up_first) {
  Bench bench;
  struct From {
    double x, y, z, c_deg, u;
  };
  for (const From& f : {From{300, 200, -40, 90, 10}, From{100, 262, -30, -120, 0}, From{490, 20, -1, 0, 40},
                        From{20, 20, -2, 0, 0}, From{165, 290, -20, 0, 0}, From{250, 200, -50, 10, 5}}) {
    SCOPED_TRACE(fmt::format("{} {} {}", f.x, f.y, f.z));
    bench.go(f.x, f.y, f.z, f.c_deg, f.u);
    const auto parked = bench.park();
    ASSERT_TRUE(parked) << to_text(parked.error());
    bench.expect_straight_up_first();
    bench.expect_parked();
  }
}

TEST(Park, right_after_homing_enables_where_there_is_no_torque_and_asks_for_no_closed_clamp) {
  Bench bench;
  ASSERT_TRUE(bench.owner().disable());
  ASSERT_EQ(bench.now().enabled, 0u);
  ASSERT_LT(bench.now().target[kX], -1) << "homing leaves X outside of its limits";
  ASSERT_EQ(bench.now().inputs & config::bit(config::Input::ClampClosed), 0u);
  const auto parked = bench.park();
  ASSERT_TRUE(parked) << to_text(parked.error());
  bench.expect_parked();
}

TEST(Park, after_an_abort_in_a_bead_raises_the_needle_and_ends_at_the_park_position) {
  Bench bench({.placement = "dx=0.5 mm"}, false);
  bool sent = false;
  bench.rig.on_step = [&](run::Owner& owner) {
    if (sent || !on(owner.latest(), config::Output::Valve) || owner.latest().path_speed < 10) return;
    sent = true;
    EXPECT_TRUE(owner.order({.kind = OrderKind::Abort}));
  };
  ASSERT_NE(bench.rig.run(kShort).exit_code, ExitCode::Done);
  ASSERT_TRUE(sent);
  bench.rig.on_step = {};
  bench.listen();
  bench.valve_opened = false;
  ASSERT_LT(bench.now().target[kZ], kSafeZ - 5);
  ASSERT_TRUE(on(bench.now(), config::Output::Clamp)) << "the part is still held";
  const auto parked = bench.park();
  ASSERT_TRUE(parked) << to_text(parked.error());
  bench.expect_straight_up_first();
  bench.expect_parked();
  EXPECT_TRUE(on(bench.now(), config::Output::Clamp)) << "and is not let go by parking";
}

// ---- what it refuses ----

TEST(Park, a_brick_in_the_way_refuses_it_with_both_bodies_and_nothing_moves) {
  Bench bench({.change = [](config::Machine& machine) {
    for (auto& [axis, position] : machine.park)
      if (axis == machine.x) position = 480;
    // Higher than the head can rise, and between the reference and the park position.
    machine.scene.push_back({"brick", {config::Shape::Kind::Box, {10, 900, 600}}, {300, 200, 0}, 0, false});
  }});
  const Error error = bench.expect_refused(Fault::Collision);
  EXPECT_NE(error.message.find("of brick at"), std::string::npos) << error.message;
  bool named = false;
  for (const config::Body& body : bench.rig.machine().head)
    named = named || error.message.find(body.name + " comes within") != std::string::npos;
  EXPECT_TRUE(named) << error.message;
  EXPECT_EQ(info(error.fault).exit_code, ExitCode::NotFeasible);
}

TEST(Park, under_a_roof_is_refused_with_both_bodies_and_the_way_out) {
  Bench bench;
  bench.go(250, 200, -40);
  config::Machine machine = bench.rig.machine();
  // The carriage reaches from 65 to 115 mm over Z: here up to 75, and at the safe height up to 110.
  machine.scene.push_back({"roof", {config::Shape::Kind::Box, {400, 400, 4}}, {250, 200, 90}, 0, false});
  const auto planned = job::plan_park(machine, job::Surroundings(machine), bench.now().target);
  ASSERT_FALSE(planned);
  EXPECT_EQ(planned.error().fault, Fault::Collision);
  for (const char* word : {"carriage", "roof", "rise", "jog"})
    EXPECT_NE(planned.error().message.find(word), std::string::npos) << planned.error().message;
}

TEST(Park, needs_axes_that_are_referenced) {
  Bench bench({}, false);
  const Error error = bench.expect_refused(Fault::NotReferenced);
  EXPECT_EQ(info(error.fault).exit_code, ExitCode::Refused);
  EXPECT_NE(error.message.find("gantry home"), std::string::npos);
  EXPECT_EQ(bench.now().enabled, 0u);
}

TEST(Park, is_refused_while_a_fault_is_latched) {
  Bench bench;
  ASSERT_TRUE(bench.owner().world()->add_script("- {at: cycle 1, do: press, input: stop, hold: 20 ms}"));
  for (int i = 0; i < 200; ++i) ASSERT_TRUE(bench.owner().idle());
  ASSERT_EQ(bench.now().latched, Fault::StopPressed);
  bench.expect_refused(Fault::Latched);
}

TEST(Park, is_refused_in_setup) {
  Idle idle("[{at: cycle 20000, do: set_input, input: mode, on: false}]");
  idle.pass_to(20'100);
  ASSERT_TRUE(idle.owner().in_setup());
  const AxisVec at = idle.now().target;
  ASSERT_TRUE(idle.owner().disable());
  const auto parked = idle.owner().park();
  ASSERT_FALSE(parked);
  EXPECT_EQ(parked.error().fault, Fault::SetupMode) << to_text(parked.error());
  EXPECT_EQ(idle.now().enabled, 0u) << "it does not even give torque";
  idle.pass_to(idle.now().cycle + 200);
  EXPECT_EQ(idle.now().target, at);
}

TEST(Park, stops_when_the_mode_is_turned_to_setup_on_the_way) {
  Idle idle("[{at: cycle 20000, do: set_input, input: mode, on: false}]");
  idle.pass_to(19'900);
  const auto parked = idle.owner().park();
  ASSERT_FALSE(parked) << "at its speed the door may not be open";
  EXPECT_EQ(parked.error().fault, Fault::ModeChanged) << to_text(parked.error());
  EXPECT_EQ(idle.now().state, cycle::State::Stopped);
  EXPECT_LT(idle.now().target[kX], kParked[kX] - 1);
}

TEST(Park, is_refused_in_the_middle_of_a_job_and_the_job_goes_on) {
  Rig rig({});
  bool asked = false;
  rig.on_step = [&](run::Owner& owner) {
    if (asked || owner.latest().path_speed < 10) return;
    asked = true;
    const auto refused = owner.park();
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().fault, Fault::Refused);
    EXPECT_NE(refused.error().message.find(
                  "'park' is refused: the machine is busy with 'run' (running); wait for its end, or `abort` it"),
              std::string::npos)
        << refused.error().message;
  };
  EXPECT_EQ(rig.run(kShort).exit_code, ExitCode::Done);
  EXPECT_TRUE(asked);
}

// ---- stops on the way ----

TEST(Park, an_abort_on_the_way_stops_and_the_next_one_gets_there) {
  Bench bench;
  for (const std::uint32_t after : {1u, 60u, 250u, 400u, 700u}) {
    SCOPED_TRACE(after);
    bench.go(400, 250, -40, 90, 10);
    std::uint32_t waited = 0;
    bench.on_cycle = [&] {
      if (bench.now().state != cycle::State::Running || waited++ != after) return;
      EXPECT_TRUE(bench.owner().order({.kind = OrderKind::Abort}));
    };
    const auto ended = bench.park();
    bench.on_cycle = {};
    ASSERT_GE(waited, after) << "it was still under way";
    ASSERT_FALSE(ended);
    EXPECT_EQ(ended.error().fault, Fault::Aborted);
    EXPECT_EQ(bench.now().state, cycle::State::Ready) << "it stands, and nothing is latched";
    const AxisVec stands = bench.now().target;
    EXPECT_GT(std::hypot(stands[kX] - kParked[kX], stands[kY] - kParked[kY]), 1);
    for (int i = 0; i < 100; ++i) ASSERT_TRUE(bench.owner().idle());
    EXPECT_EQ(bench.now().target, stands);
    const auto again = bench.park();
    ASSERT_TRUE(again) << to_text(again.error());
    bench.expect_parked();
  }
}

TEST(Park, a_hold_stands_on_the_way_and_a_resume_goes_on_to_the_end) {
  Bench bench;
  bench.go(400, 250, -40);
  CycleIndex held = 0;
  bench.on_cycle = [&] {
    const auto& s = bench.now();
    if (held == 0 && s.path_speed > 100) {
      held = s.cycle;
      EXPECT_TRUE(bench.owner().order({.kind = OrderKind::Hold}));
    }
    if (held == 0 || s.cycle != held + 1000) return;
    EXPECT_EQ(s.state, cycle::State::Held);
    EXPECT_EQ(s.path_speed, 0);
    EXPECT_GT(s.target[kX], kParked[kX] + 1);
    EXPECT_FALSE(bench.owner().order({.kind = OrderKind::Reset})) << "a reset waits for its end";
    EXPECT_TRUE(bench.owner().order({.kind = OrderKind::Resume}));
  };
  const auto parked = bench.park();
  bench.on_cycle = {};
  ASSERT_TRUE(parked) << to_text(parked.error());
  EXPECT_GT(bench.now().cycle, held + 1000);
  bench.expect_parked();
}

}  // namespace
}  // namespace gantry
