// Jogs on the whole machine in virtual time: where they end, how fast, what they refuse, and what a stop leaves.
#include "app/job/jog.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <random>

#include "app/job/limits.hpp"
#include "core/units.hpp"
#include "motion/path/moves.hpp"
#include "motion/profile/together.hpp"
#include "tests/machine/rig.hpp"

namespace gantry {
namespace {

using job::JogWords;
using run::OrderKind;
using test::Rig;

constexpr std::size_t kX = 0, kY = 1, kZ = 2, kC = 3, kU = 4;
using test::kShort;

JogWords words(std::map<std::string, std::string> by, std::string speed = "") {
  return {std::move(by), std::move(speed)};
}
std::string mm(double value) { return fmt::format("{:.6f} mm", value); }

/// A machine that is up, and all that its loop has told of every cycle.
struct Bench {
  explicit Bench(bool homed = true) {
    const auto up = rig.owner().bring_up();
    EXPECT_TRUE(up) << to_text(up.error());
    if (homed) home();
    rig.owner().on_step([this] { step(); });
  }
  ~Bench() { rig.owner().on_step({}); }
  Bench(const Bench&) = delete;
  Bench& operator=(const Bench&) = delete;
  void home() {
    const auto done = rig.owner().home();
    EXPECT_TRUE(done) << to_text(done.error());
  }
  void step() {
    cycles.push_back(now());
    valve_opened = valve_opened || (now().outputs & config::bit(config::Output::Valve)) != 0;
    if (on_cycle) on_cycle();
  }
  [[nodiscard]] run::Owner& owner() { return rig.owner(); }
  [[nodiscard]] const cycle::Snapshot& now() { return rig.owner().latest(); }
  [[nodiscard]] AxisVec at() { return now().target; }
  Result<run::Jogged> jog(const JogWords& asked) {
    cycles.clear();
    return owner().jog(asked);
  }
  /// By how much no axis is mistaken, for a jog that has to work.
  void to(double x, double y, double z) {
    const AxisVec from = at();
    std::map<std::string, std::string> by;
    for (const auto& [name, by_mm] : {std::pair{"X", x - from[kX]}, {"Y", y - from[kY]}, {"Z", z - from[kZ]}})
      if (std::abs(by_mm) > 1e-3) by[name] = mm(by_mm);
    if (by.empty()) return;
    const auto done = jog(words(by, "400 mm/s"));
    ASSERT_TRUE(done) << to_text(done.error());
  }
  /// Refused with this fault, and not a count was sent.
  Error expect_refused(const JogWords& asked, Fault fault) {
    for (int i = 0; i < 20; ++i) owner().idle();
    const auto counts = now().counts;
    const auto done = jog(asked);
    for (int i = 0; i < 50; ++i) owner().idle();
    EXPECT_FALSE(done);
    if (done) return {};
    EXPECT_EQ(done.error().fault, fault) << to_text(done.error());
    EXPECT_FALSE(cycles.empty());
    for (const auto& c : cycles) EXPECT_EQ(c.counts, counts) << c.cycle;
    return done.error();
  }

  Rig rig{{}};
  std::vector<cycle::Snapshot> cycles;
  std::function<void()> on_cycle;
  bool valve_opened = false;
};

// ---- where it ends ----

TEST(Jog, arrives_where_it_was_sent_and_nothing_else_moves) {
  Bench bench;
  AxisVec expected = bench.at();
  struct Case {
    const char *axis, *by;
    std::size_t index;
    double displacement;
  };
  for (const Case& c : {Case{"X", "10 mm", kX, 10},
                        {"Y", "12.345mm", kY, 12.345},
                        {"Z", "-2 mm", kZ, -2},
                        {"C", "15 deg", kC, units::rad(15)},
                        {"U", "3500 um", kU, 3.5},
                        {"X", "-0.25 mm", kX, -0.25}}) {
    SCOPED_TRACE(c.axis);
    const auto done = bench.jog(words({{c.axis, c.by}}));
    ASSERT_TRUE(done) << to_text(done.error());
    EXPECT_EQ(done->axes, 1u << c.index);
    EXPECT_EQ(done->start, expected);
    expected[c.index] += c.displacement;
    for (std::size_t i = 0; i < 6; ++i) {
      EXPECT_NEAR(done->end[i], expected[i], 1e-9) << i;
      EXPECT_NEAR(bench.at()[i], expected[i], 1e-9) << i;
    }
    expected = bench.at();
    for (int i = 0; i < 100; ++i) bench.owner().idle();
    EXPECT_NEAR(bench.now().actual[c.index], expected[c.index], 0.002);
  }
  EXPECT_FALSE(bench.valve_opened);
  EXPECT_EQ(bench.now().state, cycle::State::Ready);
}

// ---- how fast ----

struct Speeds {
  double v = 0, a = 0, j = 0;
};
/// Largest differences of what was sent, tick by tick: averages of what they stand for, so never above a bound that
/// holds.
Speeds sent_speeds(const std::vector<cycle::Snapshot>& cycles, std::size_t axis) {
  Speeds most;
  constexpr double h = 0.001;
  for (std::size_t n = 3; n < cycles.size(); ++n) {
    const auto q = [&](std::size_t back) { return cycles[n - back].target[axis]; };
    most.v = std::max(most.v, std::abs(q(0) - q(1)) / h);
    most.a = std::max(most.a, std::abs(q(0) - 2 * q(1) + q(2)) / (h * h));
    most.j = std::max(most.j, std::abs(q(0) - 3 * q(1) + 3 * q(2) - q(3)) / (h * h * h));
  }
  return most;
}

TEST(Jog, is_as_short_as_the_planner_of_states_finds_and_keeps_every_bound) {
  Bench bench;
  bench.to(100, 100, -10);
  struct Case {
    std::map<std::string, std::string> by;
    std::string speed;
    double v_path;  // of the mm axes together
  };
  const std::array cases{
      Case{{{"X", "10 mm"}}, "", 20},
      Case{{{"X", "40 mm"}, {"Y", "-30 mm"}}, "100 mm/s", 100},
      Case{{{"X", "300 mm"}}, "10 m/s", 1e4},
      Case{{{"X", "1 mm"}, {"U", "30 mm"}}, "40 mm/s", 40},
      Case{{{"X", "-7 mm"}, {"Y", "11 mm"}, {"Z", "-3 mm"}, {"C", "120 deg"}, {"U", "2 mm"}}, "60 mm/s", 60},
      Case{{{"X", "0.0005 mm"}}, "", 20},
      Case{{{"Z", "5 mm"}}, "0.5 mm/s", 0.5}};
  for (const Case& c : cases) {
    SCOPED_TRACE(fmt::format("{} axes from {}, {}", c.by.size(), c.by.begin()->first, c.speed));
    const AxisVec from = bench.at();
    const auto jog = job::read_jog(bench.rig.machine(), words(c.by, c.speed));
    ASSERT_TRUE(jog) << to_text(jog.error());
    const auto done = bench.jog(words(c.by, c.speed));
    ASSERT_TRUE(done) << to_text(done.error());

    // The judge: the axes' own bounds, and the path's speed shared out among them.
    double length = 0;
    for (const std::size_t i : {kX, kY, kZ, kU}) length = std::hypot(length, jog->displacement[i]);
    std::vector<motion::AxisMove> moves;
    for (std::size_t i = 0; i < 5; ++i) {
      if (jog->displacement[i] == 0) continue;
      const config::Axis& axis = bench.rig.machine().axes[i];
      const double v = std::min(axis.v_max, c.v_path * std::abs(jog->displacement[i]) / length);
      moves.push_back(
          {{from[i], 0, 0}, {from[i] + jog->displacement[i], 0, 0}, motion::Bounds{v, axis.a_max, axis.j_max}});
      const Speeds sent = sent_speeds(bench.cycles, i);
      EXPECT_LE(sent.v, v * (1 + 1e-6)) << axis.name;
      EXPECT_LE(sent.a, axis.a_max * (1 + 1e-3)) << axis.name;
      EXPECT_LE(sent.j, axis.j_max * (1 + 0.02) + 1) << axis.name;
    }
    const motion::Joint shortest = motion::move_together(moves, {.sync = motion::Sync::Phase});
    ASSERT_TRUE(shortest) << motion::name(shortest.reason);
    EXPECT_TRUE(shortest.straight);
    const job::Surroundings around(bench.rig.machine());
    const auto planned = job::plan_jog(bench.rig.machine(), around, from, *jog);
    ASSERT_TRUE(planned) << to_text(planned.error());
    EXPECT_GE(planned->duration_s(), shortest.duration_s - 1e-9);
    EXPECT_LT(planned->duration_s(), shortest.duration_s + 0.001 + 1e-9) << "rounded up to the cycle";
    std::uint32_t ticks = 0;
    for (const auto& s : bench.cycles) ticks = std::max(ticks, s.tick);
    EXPECT_NEAR(ticks * 0.001, planned->duration_s(), 0.0055) << "played as planned, and the slowest axis's delay";
    EXPECT_NEAR(done->duration_s, planned->duration_s(), 0.010);
  }
}

// ---- what it refuses ----

/// Without a speed that is named (and in setup none is faster) what turns is as slow as where it turns alone.
TEST(Jog, that_names_no_speed_turns_slowly_also_where_other_axes_go_along) {
  Bench bench;
  for (const auto& by : {std::map<std::string, std::string>{{"C", "90 deg"}},
                         {{"X", "0.1 mm"}, {"C", "90 deg"}},
                         {{"X", "90 mm"}, {"C", "-1 deg"}}}) {
    const auto done = bench.jog(words(by));
    ASSERT_TRUE(done) << to_text(done.error());
    EXPECT_GE(done->duration_s, 4.5);
    EXPECT_LE(done->duration_s, 4.7);
  }
}

TEST(Jog, into_a_body_is_refused_with_both_names_and_the_point_and_nothing_moves) {
  Bench bench;
  bench.to(165, 262, -1);  // over the post, whose top is at -62
  const Error down = bench.expect_refused(words({{"Z", "-40 mm"}}), Fault::Collision);
  EXPECT_EQ(info(down.fault).exit_code, ExitCode::NotFeasible);
  EXPECT_NE(down.message.find("needle comes within 2 mm of post at (165.00, 262.00, -62.00) mm"), std::string::npos)
      << down.message;
  bench.to(100, 262, -1);
  bench.to(100, 262, -30);
  const Error across = bench.expect_refused(words({{"X", "130 mm"}}), Fault::Collision);
  EXPECT_NE(across.message.find("post"), std::string::npos)
      << "both ends are free, the path between is not: " << across.message;
  EXPECT_TRUE(bench.jog(words({{"X", "-30 mm"}})));
  EXPECT_TRUE(bench.owner().world()->collisions()->empty());
}

TEST(Jog, past_a_limit_is_refused_with_the_limit_and_what_is_left) {
  Bench bench;
  ASSERT_LT(bench.at()[kX], -1) << "homing leaves X outside of its limits";
  const Error out = bench.expect_refused(words({{"X", "-0.5 mm"}}), Fault::OutOfReach);
  EXPECT_NE(out.message.find("past its lower limit 0.000 mm; it stands at -1."), std::string::npos) << out.message;
  EXPECT_NE(out.message.find(" mm already"), std::string::npos) << out.message;
  EXPECT_TRUE(bench.jog(words({{"X", "0.5 mm"}}))) << "it may come back";
  EXPECT_TRUE(bench.jog(words({{"Y", "5 mm"}}))) << "and does not hold other axes";
  bench.to(490, 10, -5);
  const Error far = bench.expect_refused(words({{"X", "10.001 mm"}}), Fault::OutOfReach);
  EXPECT_EQ(far.where, "axis X");
  EXPECT_NE(far.message.find("500.001 mm, past its upper limit 500.000 mm"), std::string::npos) << far.message;
  EXPECT_NE(far.message.find("490.000 mm, 10.000 mm from there"), std::string::npos) << far.message;
  EXPECT_EQ(info(far.fault).exit_code, ExitCode::NotFeasible);
  EXPECT_TRUE(bench.jog(words({{"X", "10 mm"}})));
  EXPECT_NEAR(bench.at()[kX], 500, 1e-9);
  const Error turned = bench.expect_refused(words({{"C", "-15 deg"}}), Fault::OutOfReach);
  EXPECT_NE(turned.message.find("lower limit -180.000 deg"), std::string::npos) << turned.message;
}

TEST(Jog, needs_axes_that_are_referenced) {
  Bench bench(false);
  const Error error = bench.expect_refused(words({{"X", "1 mm"}}), Fault::NotReferenced);
  EXPECT_EQ(info(error.fault).exit_code, ExitCode::Refused);
  EXPECT_NE(error.message.find("gantry home"), std::string::npos);
  EXPECT_EQ(bench.now().enabled, 0u);
}

/// No machine file is such (check refuses it); what has no homing must not count as referenced all the same.
TEST(Unreferenced, an_axis_without_a_homing_lets_nothing_move) {
  for (const std::size_t i : {kX, kZ, kU}) {
    Rig rig({.change = [&](config::Machine& m) { m.axes[i].homing.reset(); }});
    ASSERT_TRUE(rig.owner().bring_up());
    const auto counts = rig.owner().latest().counts;
    const std::string name = "axis " + rig.machine().axes[i].name;
    const auto result = rig.run(kShort);
    EXPECT_EQ(result.exit_code, ExitCode::Refused);
    ASSERT_EQ(result.errors.size(), 1u);
    EXPECT_EQ(result.errors[0].fault, Fault::NotReferenced) << to_text(result.errors[0]);
    EXPECT_EQ(result.errors[0].where, name);
    for (const auto& refused : {rig.owner().home(), rig.owner().park()}) {
      ASSERT_FALSE(refused);
      EXPECT_EQ(refused.error().fault, Fault::NotReferenced) << to_text(refused.error());
    }
    const auto jogged = rig.owner().jog(words({{"Y", "1 mm"}}));
    ASSERT_FALSE(jogged);
    EXPECT_EQ(jogged.error().fault, Fault::NotReferenced) << to_text(jogged.error());
    for (int n = 0; n < 50; ++n) rig.owner().idle();
    EXPECT_EQ(rig.owner().latest().counts, counts) << "nothing has moved";
  }
}

TEST(Jog, is_refused_while_a_fault_is_latched_and_goes_after_the_reset) {
  Bench bench;
  ASSERT_TRUE(bench.owner().world()->add_script("- {at: cycle 1, do: press, input: stop, hold: 20 ms}"));
  for (int i = 0; i < 200; ++i) bench.owner().idle();
  ASSERT_EQ(bench.now().latched, Fault::StopPressed);
  const Error error = bench.expect_refused(words({{"X", "5 mm"}}), Fault::Latched);
  EXPECT_EQ(info(error.fault).exit_code, ExitCode::Refused);
  ASSERT_TRUE(bench.owner().order({.kind = OrderKind::Reset}));
  for (int i = 0; i < 500; ++i) bench.owner().idle();
  const auto done = bench.jog(words({{"X", "5 mm"}}));
  EXPECT_TRUE(done) << to_text(done.error());
}

TEST(Jog, is_refused_in_the_middle_of_a_job_and_the_job_goes_on) {
  Rig rig({});
  bool asked = false;
  rig.on_step = [&](run::Owner& owner) {
    if (asked || owner.latest().path_speed < 10) return;
    asked = true;
    const auto refused = owner.jog(words({{"X", "1 mm"}}));
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().fault, Fault::Refused);
  };
  EXPECT_EQ(rig.run(kShort).exit_code, ExitCode::Done);
  EXPECT_TRUE(asked);
}

TEST(Jog, says_what_is_cut_of_a_speed_that_was_asked_for) {
  const auto machine = config::load_machine("config/machines/dispenser.yaml");
  ASSERT_TRUE(machine);
  struct Case {
    JogWords asked;
    const char* says;
  };
  for (const Case& c :
       {Case{words({{"X", "1 mm"}}, "1e9 mm/s"), "no faster than 500 mm/s, because axis X can do 500.000 mm/s"},
        // 3, 4: of the path's 5 mm Z does 4.
        Case{words({{"X", "3 mm"}, {"Z", "-4 mm"}}, "188 mm/s"),
             "no faster than 187.5 mm/s, because axis Z can do 150.000 mm/s"},
        // C turns by 36 deg in the time of 1 mm.
        Case{words({{"X", "1 mm"}, {"C", "36 deg"}}, "11 mm/s"),
             "no faster than 10 mm/s, because axis C can do 360.000 deg/s"},
        Case{words({{"C", "90 deg"}}, "361 deg/s"), "no faster than 360 deg/s, because axis C can do 360.000 deg/s"},
        Case{words({{"X", "1 mm"}}, "500 mm/s"), ""}, Case{words({{"X", "3 mm"}, {"Z", "-4 mm"}}, "187.5 mm/s"), ""},
        Case{words({{"C", "90 deg"}}, "360 deg/s"), ""}, Case{words({{"X", "1 mm"}, {"C", "36 deg"}}, "10 mm/s"), ""},
        Case{words({{"X", "1 mm"}, {"C", "90 deg"}}), ""}}) {  // nobody has asked for 20 mm/s
    const auto jog = job::read_jog(*machine, c.asked);
    ASSERT_TRUE(jog) << to_text(jog.error());
    EXPECT_EQ(jog->slowed, c.says);
  }
  Bench bench;
  const auto done = bench.jog(words({{"Z", "-10 mm"}}, "1e6 mm/s"));
  ASSERT_TRUE(done) << to_text(done.error());
  EXPECT_EQ(done->slowed, "no faster than 150 mm/s, because axis Z can do 150.000 mm/s");
}

TEST(Jog, words_that_are_no_jog_are_refused_with_what_would_be_one) {
  const auto machine = config::load_machine("config/machines/dispenser.yaml");
  ASSERT_TRUE(machine);
  struct Case {
    JogWords asked;
    Fault fault;
    const char* says;
  };
  const std::array cases{Case{words({}), Fault::Usage, "X 10mm"},
                         Case{words({{"XX", "1 mm"}}), Fault::Usage, "there is no axis 'XX'; known: X, Y, Z, C, U, F"},
                         Case{words({{"Q", "1 mm"}}), Fault::Usage, "known: X, Y, Z, C, U, F"},
                         Case{words({{"F", "1 mm"}}), Fault::PositionedAxisInMove, "positions by itself"},
                         Case{words({{"X", "10"}}), Fault::Usage, "lacks a unit"},
                         Case{words({{"X", "10 deg"}}), Fault::Usage, "mm"},
                         Case{words({{"C", "10 mm"}}), Fault::Usage, "deg"},
                         Case{words({{"X", "nan mm"}}), Fault::Usage, "not a number"},
                         Case{words({{"X", "0 mm"}}), Fault::Usage, "at least 0.0001 mm"},
                         Case{words({{"C", "0 deg"}}), Fault::Usage, "at least 0.0001 deg"},
                         Case{words({{"X", "1 mm"}}, "20"), Fault::Usage, "lacks a unit"},
                         Case{words({{"X", "1 mm"}}, "20 deg/s"), Fault::Usage, "mm/s"},
                         Case{words({{"C", "1 deg"}}, "20 mm/s"), Fault::Usage, "deg/s"},
                         Case{words({{"X", "1 mm"}}, "0 mm/s"), Fault::Usage, "no slower than"},
                         Case{words({{"X", "1 mm"}}, "-5 mm/s"), Fault::Usage, "no slower than"}};
  for (const Case& c : cases) {
    const auto jog = job::read_jog(*machine, c.asked);
    ASSERT_FALSE(jog) << c.says;
    EXPECT_EQ(jog.error().fault, c.fault) << to_text(jog.error());
    EXPECT_NE(to_text(jog.error()).find(c.says), std::string::npos) << to_text(jog.error());
  }
}

// ---- stops on the way ----

/// Path of the shortest stop, integrated in small steps: jerk down while the acceleration can still be let go in time.
double stopping_distance(double v, double a, double a_max, double j) {
  constexpr double h = 1e-7;
  double s = 0;
  for (int n = 0; n < 20'000'000 && v > 1e-9; ++n) {
    const bool release = a < 0 && a * a / (2 * j) >= v;
    const double next = release ? std::min(a + j * h, 0.0) : std::max(a - j * h, -a_max);
    s += v * h + (2 * a + next) * h * h / 6;
    v += (a + next) * h / 2;
    a = next;
  }
  return s;
}

/// Place, speed and acceleration along the path `ticks` after the start of a block of one segment.
motion::State planned_state(const motion::Segment& segment, double t) {
  motion::State x{0, segment.nominal.v0, segment.nominal.a0};
  for (const motion::Phase& phase : segment.nominal.phases) {
    const double h = std::min(t, phase.duration_s);
    x.p += h * (x.v + h * (x.a / 2 + h * phase.jerk / 6));
    x.v += h * (x.a + h * phase.jerk / 2);
    x.a += h * phase.jerk;
    t -= h;
  }
  return x;
}

/// How far q is off the straight line from `from` along `displacement` (X and Y).
double off_line(Vec2 q, Vec2 from, Vec2 displacement) {
  const Vec2 d = q - from;
  return std::abs(d.x * displacement.y - d.y * displacement.x) / std::hypot(displacement.x, displacement.y);
}

TEST(Jog, an_abort_at_any_time_ends_on_the_way_within_the_planners_stopping_distance) {
  Bench bench;
  bench.to(200, 20, -10);
  const auto& limits = bench.rig.machine().axes[kX];
  for (const std::uint32_t after : {1u, 7u, 23u, 40u, 55u, 90u, 170u, 214u, 240u}) {
    SCOPED_TRACE(after);
    bench.to(200, 20, -10);
    const AxisVec from = bench.at();
    const JogWords asked = words({{"X", "80 mm"}, {"Y", "60 mm"}}, "400 mm/s");
    const auto jog = job::read_jog(bench.rig.machine(), asked);
    const auto planned = job::plan_jog(bench.rig.machine(), job::Surroundings(bench.rig.machine()), from, *jog);
    ASSERT_TRUE(planned);
    ASSERT_EQ(planned->segments().size(), 1u);
    bool sent = false;
    bench.on_cycle = [&] {
      if (!sent && bench.now().block == 1 && bench.now().tick == after)
        sent = bench.owner().order({.kind = OrderKind::Abort}).has_value();
    };
    const auto ended = bench.jog(asked);
    bench.on_cycle = {};
    ASSERT_TRUE(sent);
    ASSERT_FALSE(ended);
    EXPECT_EQ(ended.error().fault, Fault::Aborted);
    EXPECT_EQ(bench.now().state, cycle::State::Ready) << "it stands, and nothing is latched";

    const motion::State x = planned_state(planned->segments()[0], after * 0.001);
    const double factor = 100 / 80.0;  // the path's bounds are those of X, which goes farther
    const double expected =
        std::min(100.0, x.p + stopping_distance(x.v, x.a, limits.a_max * factor, limits.j_max * factor));
    const Vec2 rest{bench.at()[kX] - from[kX], bench.at()[kY] - from[kY]};
    EXPECT_NEAR(std::hypot(rest.x, rest.y), expected, 1e-3);
    EXPECT_LE(off_line(rest, {0, 0}, {80, 60}), 1e-9);
    // X is sent one cycle after Y, which answers one later: side by side they are on the line in every cycle.
    for (std::size_t n = 0; n + 1 < bench.cycles.size(); ++n)
      ASSERT_LE(off_line({bench.cycles[n + 1].target[kX], bench.cycles[n].target[kY]}, {from[kX], from[kY]}, {80, 60}),
                1e-9)
          << n;
    const AxisVec stands = bench.at();
    for (int i = 0; i < 50; ++i) bench.owner().idle();
    EXPECT_EQ(bench.at(), stands);
  }
  EXPECT_FALSE(bench.valve_opened);
}

TEST(Jog, hold_brakes_on_the_way_resume_goes_on_and_an_abort_ends_what_is_held) {
  Bench bench;
  bench.to(100, 100, -10);
  for (const bool abort : {false, true}) {
    const AxisVec from = bench.at();
    CycleIndex held = 0, went_on = 0;
    bench.on_cycle = [&] {
      const auto& s = bench.now();
      if (held == 0 && s.path_speed > 90) {
        held = s.cycle;
        EXPECT_TRUE(bench.owner().order({.kind = OrderKind::Hold}));
      }
      if (held != 0 && went_on == 0 && s.cycle == held + 300) {
        EXPECT_EQ(s.state, cycle::State::Held);
        EXPECT_EQ(s.path_speed, 0);
        went_on = s.cycle;
        EXPECT_TRUE(bench.owner().order({.kind = abort ? OrderKind::Abort : OrderKind::Resume}));
      }
    };
    const auto ended = bench.jog(words({{"X", "80 mm"}, {"Y", "60 mm"}}, "100 mm/s"));
    bench.on_cycle = {};
    ASSERT_GT(went_on, 0);
    EXPECT_EQ(ended.has_value(), !abort);
    if (!abort) {
      EXPECT_NEAR(bench.at()[kX], from[kX] + 80, 1e-9);
    }
    for (std::size_t n = 0; n + 1 < bench.cycles.size(); ++n)
      ASSERT_LE(off_line({bench.cycles[n + 1].target[kX], bench.cycles[n].target[kY]}, {from[kX], from[kY]}, {80, 60}),
                1e-9);
  }
  EXPECT_EQ(bench.now().state, cycle::State::Ready);
  EXPECT_TRUE(bench.jog(words({{"X", "1 mm"}}))) << "the machine is free for what comes next";
}

TEST(Jog, an_interrupt_says_so_and_nothing_is_undertaken_after_it) {
  Bench bench;
  bool sent = false;
  bench.on_cycle = [&] {
    if (sent || bench.now().path_speed < 10) return;
    sent = true;
    bench.owner().interrupt(Error{Fault::Interrupted, "interrupted", ""});
  };
  const auto ended = bench.jog(words({{"X", "50 mm"}}));
  bench.on_cycle = {};
  ASSERT_FALSE(ended);
  EXPECT_EQ(info(ended.error().fault).exit_code, ExitCode::Interrupted);
  const double x = bench.at()[kX];
  EXPECT_LT(x, 30);
  const auto again = bench.jog(words({{"X", "50 mm"}}));
  ASSERT_FALSE(again) << "the program is to end";
  EXPECT_EQ(again.error().fault, Fault::Interrupted);
  EXPECT_EQ(bench.at()[kX], x);
}

// ---- with a board ----

TEST(Jog, keeps_clear_of_the_board_that_the_last_job_has_found) {
  Rig rig({.placement = "dx=0.5 mm"});
  ASSERT_EQ(rig.run(kShort).exit_code, ExitCode::Done);
  run::Owner& owner = rig.owner();
  const AxisVec from = owner.latest().target;
  ASSERT_TRUE(owner.jog(words({{"X", mm(210 - from[kX])}, {"Y", mm(170 - from[kY])}}, "400 mm/s")));
  // The board's face is at -110 and the probe's tip hangs 46 mm under Z.
  const auto touching = owner.jog(words({{"X", "40 mm"}, {"Z", "-63 mm"}}));
  ASSERT_FALSE(touching);
  EXPECT_EQ(touching.error().fault, Fault::Collision);
  EXPECT_NE(touching.error().message.find("of board at"), std::string::npos) << touching.error().message;
  const auto near = owner.jog(words({{"Z", "-55 mm"}}));
  EXPECT_TRUE(near) << to_text(near.error());
}

TEST(Jog, after_an_abort_in_a_bead_leads_the_needle_up_but_not_farther_down) {
  Rig rig({.placement = "dx=0.5 mm"});
  bool sent = false;
  rig.on_step = [&](run::Owner& owner) {
    if (sent || (owner.latest().outputs & config::bit(config::Output::Valve)) == 0 || owner.latest().path_speed < 10)
      return;
    sent = true;
    EXPECT_TRUE(owner.order({.kind = OrderKind::Abort}));
  };
  ASSERT_NE(rig.run(kShort).exit_code, ExitCode::Done);
  ASSERT_TRUE(sent);
  rig.on_step = {};
  run::Owner& owner = rig.owner();
  const auto down = owner.jog(words({{"Z", "-0.1 mm"}}));
  ASSERT_FALSE(down);
  EXPECT_EQ(down.error().fault, Fault::Collision) << to_text(down.error());
  EXPECT_NE(down.error().message.find("needle"), std::string::npos) << down.error().message;
  EXPECT_NE(down.error().message.find("board"), std::string::npos) << down.error().message;
  const auto up = owner.jog(words({{"Z", "3 mm"}}));
  ASSERT_TRUE(up) << to_text(up.error());
  EXPECT_FALSE(owner.jog(words({{"Z", "-2.9 mm"}}))) << "what has gone up keeps its clearance";
  EXPECT_TRUE(owner.world()->collisions()->empty());
}

TEST(Jog, at_random_ends_where_it_was_sent_or_is_refused_and_the_world_sees_no_collision) {
  Rig rig({.placement = "dx=0.4 mm, dy=-0.7 mm, rot=0.6 deg"});
  ASSERT_EQ(rig.run(kShort).exit_code, ExitCode::Done);
  run::Owner& owner = rig.owner();
  const motion::Limits limits = job::limits_of(rig.machine());
  constexpr std::uint64_t kSeed = 20;
  constexpr int kJogs = 80;
  SCOPED_TRACE(fmt::format("seed {}", kSeed));
  std::mt19937_64 random(kSeed);
  const auto between = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  int done = 0, collisions = 0, limited = 0, stopped = 0;
  for (int n = 0; n < kJogs; ++n) {
    SCOPED_TRACE(n);
    const AxisVec from = owner.latest().target;
    AxisVec to = from;
    std::map<std::string, std::string> by;
    // Places around the board, where there is something to meet.
    const std::array<std::array<double, 2>, 5> range{{{100, 330}, {90, 310}, {-79, 5}, {-3.1, 3.2}, {-1, 41}}};
    for (std::size_t i = 0; i < range.size(); ++i) {
      if (between(0, 1) < 0.4) continue;
      const double displacement = between(range[i][0], range[i][1]) - from[i];
      by[rig.machine().axes[i].name] =
          i == kC ? fmt::format("{:.9f} rad", displacement) : fmt::format("{:.9f} mm", displacement);
      to[i] = from[i] + displacement;
    }
    if (by.empty()) continue;
    const bool abort = between(0, 1) < 0.2;
    const auto at = static_cast<std::uint32_t>(between(1, 300));
    bool sent = false;
    rig.on_step = [&](run::Owner& o) {
      if (abort && !sent && o.latest().block == 1 && o.latest().tick == at)
        sent = o.order({.kind = OrderKind::Abort}).has_value();
    };
    const bool turns_only = by.size() == 1 && by.contains("C");
    const auto ended = owner.jog(words(by, fmt::format("{:.3f} {}", between(20, 300), turns_only ? "deg/s" : "mm/s")));
    rig.on_step = {};
    const AxisVec& rest = owner.latest().target;
    if (ended) {
      ++done;
      for (std::size_t i = 0; i < 6; ++i) EXPECT_NEAR(rest[i], to[i], 1e-8) << i;
      EXPECT_TRUE(motion::within(limits, rest));
      continue;
    }
    if (ended.error().fault == Fault::Aborted) {
      ++stopped;
      continue;
    }
    EXPECT_EQ(rest, from) << to_text(ended.error());
    if (ended.error().fault == Fault::OutOfReach) {
      ++limited;
      EXPECT_FALSE(motion::within(limits, to)) << to_text(ended.error());
    } else {
      ++collisions;
      EXPECT_EQ(ended.error().fault, Fault::Collision) << to_text(ended.error());
    }
  }
  const auto met = owner.world()->collisions();
  ASSERT_TRUE(met);
  EXPECT_TRUE(met->empty()) << met->size() << ": " << met->front().moving << " and " << met->front().standing;
  EXPECT_EQ(owner.latest().latched, Fault::None);
  EXPECT_FALSE((owner.latest().outputs & config::bit(config::Output::Valve)) != 0);
  std::printf("%d done, %d stopped, %d refused for a body, %d for a limit\n", done, stopped, collisions, limited);
  EXPECT_GE(done, kJogs / 4);
  EXPECT_GE(collisions, kJogs / 8);
  EXPECT_GE(stopped, 3);
}

}  // namespace
}  // namespace gantry
