// A job that the door, the air, the stop button or clocks out of step have stopped: it waits, goes on behind reset and
// resume, and the board is whole. Judged by what lies on the world's board and by where the axes go meanwhile.
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <random>

#include "tests/machine/order.hpp"
#include "tests/machine/rig.hpp"

namespace gantry {
namespace {

using cycle::State;
using run::OrderKind;
using test::Rig;
using test::valve_open;

using test::kDemo;
constexpr const char* kPatterns = "recipes/patterns.yaml";
constexpr double kSpeed_mm_s = 20, kPlace_mm = 0.02, kStill_mm = 1e-6;

std::string first_error(const record::JobResult& r) { return r.errors.empty() ? "" : to_text(r.errors.front()); }

void set(run::Owner& owner, const std::string& input, bool on) {
  ASSERT_TRUE(owner.world()->add_script(fmt::format("[{{do: set_input, input: {}, on: {}}}]", input, on)));
}

/// Opens the door (or another interlock) now and then, closes it, resets and resumes; and looks at what the machine
/// does between.
struct Clumsy {
  explicit Clumsy(unsigned seed) : random(seed) {}
  std::mt19937 random;
  int most = 1000, stops = 0;
  CycleIndex runs_for = 500, stands_for = 300;
  bool at_open_valve = false;
  std::vector<bool> dots{};  ///< by feature: a dot that is cut is a defect, and its valve is left alone

  enum class Phase { Waiting, Stopping, Open, Reset, Clear } phase = Phase::Waiting;
  std::string input{};
  CycleIndex since = 0;
  AxisVec stood{};

  int some(int from, int to) { return std::uniform_int_distribution<int>(from, to)(random); }
  void turn(Phase to, CycleIndex now) { phase = to, since = now; }

  /// Also ahead of what may be one, by the valve's lead.
  [[nodiscard]] bool in_dot(const cycle::Snapshot& s) const {
    return !dots.empty() && valve_open(s) && (s.feature >= dots.size() || dots[s.feature]);
  }

  void operator()(run::Owner& owner) {
    const auto& s = owner.latest();
    switch (phase) {
      case Phase::Waiting:
        if (s.state == State::Homing || s.state == State::Enabling || s.block == 0 || stops == most) return;
        if (since == 0 || (at_open_valve && !valve_open(s))) since = s.cycle;  // so long it runs, or is open
        if (s.cycle < since + runs_for || in_dot(s)) return;
        input = std::vector<std::string>{"door_closed", "stop", "air_ok"}[static_cast<std::size_t>(some(0, 2))];
        set(owner, input, false);
        ++stops;
        return turn(Phase::Stopping, s.cycle);
      case Phase::Stopping:
        EXPECT_FALSE(s.cycle > since + 4 && valve_open(s));
        EXPECT_LT(s.cycle, since + 2000) << "does not come to rest";
        if (s.state != State::Stopped) return;
        stood = s.target;
        EXPECT_TRUE(owner.stopped());
        EXPECT_FALSE(owner.order({.kind = OrderKind::Resume})) << "behind a reset only";
        return turn(Phase::Open, s.cycle);
      case Phase::Open:
        expect_still(s);
        if (s.cycle == since + 20) static_cast<void>(owner.order({.kind = OrderKind::Reset}));  // finds the cause there
        if (s.cycle < since + stands_for) return;
        EXPECT_EQ(s.state, State::Stopped);
        set(owner, input, true);
        return turn(Phase::Reset, s.cycle);
      case Phase::Reset:
        expect_still(s);
        static_cast<void>(owner.reset_answer());
        if (s.cycle < since + 10) return;
        if (!owner.order({.kind = OrderKind::Reset})) return;
        return turn(Phase::Clear, s.cycle);
      case Phase::Clear:
        expect_still(s);
        if (s.cycle < since + 200) return;
        static_cast<void>(owner.reset_answer());
        EXPECT_EQ(owner.state(), State::Held);
        EXPECT_TRUE(owner.order({.kind = OrderKind::Resume}));
        runs_for = at_open_valve ? some(12, 900) : some(1, 4000);
        return turn(Phase::Waiting, s.cycle);
    }
  }
  void expect_still(const cycle::Snapshot& s) const {
    EXPECT_FALSE(valve_open(s));
    for (std::size_t i = 0; i < s.axes; ++i) EXPECT_NEAR(s.target[i], stood[i], kStill_mm);
  }
};

TEST(OutlivedStops, whatever_they_cut_is_whole_at_the_end) {
  std::size_t joins = 0, stops = 0;
  double worst = 0;
  for (const bool at_open_valve : {true, false}) {
    Rig rig({.placement = "dx=0.5 mm, rot=0.4 deg", .seed = 5, .outlives_stops = true});
    Clumsy hand(7);
    hand.at_open_valve = at_open_valve;
    for (const recipes::Feature& f : test::load_recipe(kPatterns).features)
      hand.dots.push_back(std::holds_alternative<recipes::Dot>(f));
    hand.most = std::getenv("GANTRY_ROUNDS") != nullptr ? 1000 : 7;
    rig.on_step = [&](run::Owner& owner) { hand(owner); };
    const auto result = rig.run(kPatterns);
    EXPECT_EQ(result.exit_code, ExitCode::Done) << first_error(result);
    EXPECT_EQ(result.board, record::Board::Whole);
    for (const auto& d : result.defects) ADD_FAILURE() << d.feature << ": " << d.message;
    EXPECT_TRUE(result.collisions.empty());
    stops += static_cast<std::size_t>(hand.stops);
    for (const auto& d : result.deposits)
      for (const double missing_mm : d.joins_mm) {
        ++joins;
        worst = std::max(worst, std::abs(missing_mm));
        EXPECT_LE(std::abs(missing_mm), kSpeed_mm_s * 0.5e-3 + kPlace_mm) << d.id;
      }
  }
  std::printf("%zu stops, %zu joins, the worst %.4f mm\n", stops, joins, worst);
  EXPECT_GE(stops, 14u);
  EXPECT_GE(joins, 7u);
}

/// A job that is stopped once, so many cycles after its valve has opened, and is whole all the same.
record::JobResult stopped_after(const recipes::Recipe& recipe, CycleIndex open_for) {
  Rig rig({.placement = "dx=0 mm, dy=0 mm, rot=0 deg", .outlives_stops = true});
  Clumsy hand(static_cast<unsigned>(open_for));
  hand.at_open_valve = true, hand.runs_for = open_for, hand.most = 1;
  rig.on_step = [&](run::Owner& owner) { hand(owner); };
  auto result = rig.run(recipe);
  EXPECT_EQ(hand.stops, 1);
  EXPECT_EQ(result.exit_code, ExitCode::Done) << first_error(result);
  for (const auto& d : result.defects) ADD_FAILURE() << d.feature << ": " << d.message;
  return result;
}

// The axes stand already: the block ends in the very cycle that shuts the valve.
TEST(OutlivedStops, one_while_the_needle_stands_over_a_beads_start_leaves_it_whole) {
  const auto recipe = recipes::parse(
      "version: 1\nrecipe: stands\nplacement: fixture\nboard: {size: [80 mm, 55 mm], thickness: 12 mm, frame: "
      "pallet}\n"
      "materials:\n  pot: {speed: 20 mm/s, gap: 0.5 mm, valve_open_lead: 8 ms, valve_close_lead: 6 ms, dot_time: 30 "
      "ms, retract: 3 mm, gap_tolerance: 2 mm, start_dwell: 150 ms}\n"
      "features:\n  - line: {name: l, material: pot, from: [20 mm, 20 mm], to: [50 mm, 20 mm]}\n",
      "stands.yaml");
  ASSERT_TRUE(recipe);
  for (const CycleIndex open_for : {9, 20, 100, 150}) {
    SCOPED_TRACE(open_for);
    const auto result = stopped_after(*recipe, open_for);
    EXPECT_EQ(result.joined.size(), 1u);
    // 30 mm at 20 mm/s and 16 ms to speed up, and in all it stands for 150 ms.
    double open_s = 0;
    for (const auto& d : result.deposits) open_s += d.open_s;
    EXPECT_NEAR(open_s, 1.5 + 0.016 + 0.15, 0.006);
  }
}

// A tool that rests in a corner, or one so slow that it rests before the valve has shut, has its block ended before
// anybody has asked where it is.
TEST(OutlivedStops, one_where_the_tool_comes_to_rest_at_once_is_joined_where_it_stood) {
  struct Case {
    const char* name;
    double speed_mm_s;
    int close_lead_ms;
    double leg_mm;
    CycleIndex from, to;  ///< cycles of the open valve
  };
  // 8.7 mm at 80 mm/s: the corner is come to 8 + 128 cycles behind the valve's command.
  for (const Case& c : {Case{"corner", 80, 6, 8.7, 130, 145}, Case{"slow", 0.5, 25, 0.5, 300, 303}}) {
    const auto recipe = recipes::parse(
        fmt::format(
            "version: 1\nrecipe: corner\nplacement: fixture\nboard: {{size: [80 mm, 55 mm], thickness: 12 mm, "
            "frame: pallet}}\nmaterials:\n  pot: {{speed: {} mm/s, gap: 0.5 mm, valve_open_lead: 8 ms, "
            "valve_close_lead: {} ms, dot_time: 60 ms, retract: 3 mm, gap_tolerance: 2 mm, rejoin_within: 60 s}}\n"
            "features:\n  - polyline: {{name: l, material: pot, points: [[20 mm, 20 mm], [{} mm, 20 mm], [{} mm, "
            "30 mm]]}}\n",
            c.speed_mm_s, c.close_lead_ms, 20 + c.leg_mm, 20 + c.leg_mm),
        "corner.yaml");
    ASSERT_TRUE(recipe);
    for (CycleIndex open_for = c.from; open_for < c.to; ++open_for) {
      SCOPED_TRACE(fmt::format("{} {}", c.name, open_for));
      const auto result = stopped_after(*recipe, open_for);
      ASSERT_EQ(result.deposits.size(), 1u);
      for (const double missing_mm : result.deposits[0].joins_mm)
        EXPECT_LE(std::abs(missing_mm), c.speed_mm_s * 0.5e-3 + kPlace_mm);
    }
  }
}

// Around the cycle in which its valve is told to shut a bead is whole, joined or not, and nothing calls it cut.
TEST(OutlivedStops, one_as_the_valve_shuts_leaves_the_bead_whole) {
  for (const int close_ms : {6, 30}) {
    const auto recipe = recipes::parse(
        fmt::format(
            "version: 1\nrecipe: shuts\nplacement: fixture\nboard: {{size: [80 mm, 55 mm], thickness: 12 mm, "
            "frame: pallet}}\nmaterials:\n  pot: {{speed: 20 mm/s, gap: 0.5 mm, valve_open_lead: 8 ms, "
            "valve_close_lead: {} ms, dot_time: 60 ms, retract: 3 mm, gap_tolerance: 2 mm}}\nfeatures:\n  - line: "
            "{{name: l, material: pot, from: [20 mm, 20 mm], to: [24 mm, 20 mm]}}\n",
            close_ms),
        "shuts.yaml");
    ASSERT_TRUE(recipe);
    const int open = 8 + 200 - close_ms;  // cycles
    for (int open_for = open - 3; open_for <= open + close_ms + 2; open_for += open_for < open + 3 ? 1 : 5) {
      SCOPED_TRACE(fmt::format("{} ms, {}", close_ms, open_for - open));
      Rig rig({.placement = "dx=0 mm, dy=0 mm, rot=0 deg",
               .change = [=](config::Machine& m) { m.sim.valve_close_lag_s = close_ms * 1e-3; },
               .outlives_stops = true});
      Clumsy hand(static_cast<unsigned>(open_for));
      hand.at_open_valve = true, hand.runs_for = open_for, hand.most = 1;
      int since_open = 0;
      rig.on_step = [&](run::Owner& owner) {
        since_open += since_open > 0 || valve_open(owner.latest()) ? 1 : 0;
        if (since_open >= open_for && hand.stops == 0) hand.at_open_valve = false, hand.runs_for = 0;  // shut by then
        hand(owner);
      };
      const auto result = rig.run(*recipe);
      EXPECT_EQ(hand.stops, 1);
      EXPECT_EQ(result.exit_code, ExitCode::Done) << first_error(result);
      EXPECT_TRUE(result.interrupted.empty());
      for (const auto& d : result.defects) ADD_FAILURE() << d.feature << ": " << d.message;
      for (const auto& d : result.deposits)
        for (const double missing_mm : d.joins_mm) EXPECT_LE(std::abs(missing_mm), kSpeed_mm_s * 0.5e-3 + kPlace_mm);
    }
  }
}

// Marks, touches, travel, dots and beads: only a dot that was cut is no longer whole.
TEST(OutlivedStops, marks_and_touches_are_done_again) {
  for (const unsigned seed : {1u, 2u, 3u}) {
    SCOPED_TRACE(seed);
    Rig rig({.placement = "dx=0.5 mm, rot=-0.4 deg, dz=0.1 mm", .seed = seed, .outlives_stops = true});
    Clumsy hand(seed);
    rig.on_step = [&](run::Owner& owner) { hand(owner); };
    const auto result = rig.run(kDemo);
    EXPECT_TRUE(result.errors.empty()) << first_error(result);
    EXPECT_GT(hand.stops, 10);
    EXPECT_TRUE(result.collisions.empty());
    EXPECT_EQ(result.marks.size(), test::load_recipe(kDemo).marks.size());
    EXPECT_EQ(result.touches.size(), test::load_recipe(kDemo).touches.size());
    std::size_t dots = 0;
    for (const auto& d : result.defects) {
      EXPECT_EQ(d.kind, record::Defect::Kind::Cut) << d.feature << ": " << d.message;
      EXPECT_NE(d.message.find("not joined: "), std::string::npos) << d.feature << ": " << d.message;
      dots += d.message.find("a dot cannot be joined") != std::string::npos;
    }
    EXPECT_EQ(result.features_done + result.defects.size(), result.features_total);
    EXPECT_GE(dots + 1, result.defects.size()) << "but for a bead whose run-up a part stands in the way of";
  }
}

TEST(OutlivedStops, an_emergency_stop_in_one_ends_the_job) {
  Rig rig({.placement = "dx=0.5 mm",
           .script = "- {at: feature bead 1, after: 500 ms, do: set_input, input: door_closed, on: false}\n"
                     "- {at: feature bead 1, after: 1500 ms, do: emergency_stop}",
           .outlives_stops = true});
  const auto result = rig.run(kPatterns);
  ASSERT_FALSE(result.errors.empty());
  EXPECT_EQ(result.errors.front().fault, Fault::SafetyChainOpen) << first_error(result);
  EXPECT_EQ(result.board, record::Board::Begun);
}

TEST(OutlivedStops, an_abort_in_one_ends_the_job) {
  Rig rig({.placement = "dx=0.5 mm",
           .script = "- {at: feature bead 1, after: 500 ms, do: set_input, input: door_closed, on: false}",
           .outlives_stops = true});
  rig.on_step = [&](run::Owner& owner) {
    if (owner.state() != State::Stopped || !owner.stopped()) return;
    EXPECT_TRUE(owner.order({.kind = OrderKind::Abort}));
  };
  const auto result = rig.run(kPatterns);
  ASSERT_FALSE(result.errors.empty());
  EXPECT_EQ(result.errors.front().fault, Fault::Aborted) << first_error(result);
  EXPECT_EQ(result.interrupted, std::vector<std::string>{"seam"});
}

// The clamp lets the part go while the door is open.
TEST(OutlivedStops, a_part_that_is_let_go_in_one_ends_the_job) {
  Rig rig({.placement = "dx=0.5 mm",
           .script = "- {at: feature bead 1, after: 500 ms, do: set_input, input: door_closed, on: false}\n"
                     "- {at: feature bead 1, after: 1500 ms, do: set_input, input: clamp_closed, on: false}",
           .outlives_stops = true});
  const auto result = rig.run(kPatterns);
  ASSERT_FALSE(result.errors.empty());
  EXPECT_EQ(result.errors.front().fault, Fault::ClampOpen) << first_error(result);
}

// What is latched behind the stop is not lost: the reset names it, and the job ends with a fault that it does not
// outlive.
TEST(OutlivedStops, another_fault_behind_one_is_heard) {
  Rig rig({.placement = "dx=0.5 mm",
           .script = "- {at: feature bead 1, after: 500 ms, do: set_input, input: door_closed, on: false}\n"
                     "- {at: feature bead 1, after: 800 ms, do: set_input, input: air_ok, on: false}\n"
                     "- {at: feature bead 1, after: 1500 ms, do: set_input, input: door_closed, on: true}\n"
                     "- {at: feature bead 1, after: 2500 ms, do: press, input: reset}",
           .outlives_stops = true});
  bool told = false;
  rig.on_step = [&](run::Owner& owner) {
    static_cast<void>(owner.reset_answer());
    const auto stop = owner.stopped();
    if (!stop || stop->fault != Fault::AirMissing) return;
    told = true;
    EXPECT_TRUE(owner.order({.kind = OrderKind::Abort}));
  };
  const auto result = rig.run(kPatterns);
  EXPECT_TRUE(told);
  EXPECT_TRUE(std::any_of(result.alarms.begin(), result.alarms.end(), [](const auto& a) { return a.code == "G705"; }));
}

// A clock that strays stops on the path, as a door does: alone, or while a stop holds the job already.
TEST(OutlivedStops, clocks_that_strayed_and_keep_step_again_have_lost_nothing) {
  for (const bool pressed : {false, true}) {
    std::string script =
        "- {at: feature bead 1, after: 800 ms, do: jitter, station: y1, by: 300 us}\n"
        "- {at: feature bead 1, after: 4800 ms, do: jitter, station: y1, by: 0 us}\n"
        "- {at: feature bead 1, after: 9 s, do: press, input: reset}\n"
        "- {at: feature bead 1, after: 10 s, do: press, input: start}\n";
    if (pressed)
      script +=
          "- {at: feature bead 1, after: 500 ms, do: set_input, input: stop, on: false}\n"
          "- {at: feature bead 1, after: 900 ms, do: set_input, input: stop, on: true}\n";
    Rig rig({.placement = "dx=0.5 mm", .script = script, .outlives_stops = true});
    const auto result = rig.run(kPatterns);
    EXPECT_EQ(result.exit_code, ExitCode::Done) << first_error(result);
    EXPECT_EQ(result.board, record::Board::Whole);
    EXPECT_EQ(std::any_of(result.alarms.begin(), result.alarms.end(), [](const auto& x) { return x.code == "G118"; }),
              !pressed);
  }
}

TEST(OutlivedStops, a_clock_that_strays_for_good_is_not_reset_away) {
  Rig rig({.placement = "dx=0.5 mm",
           .script = "- {at: feature bead 1, after: 800 ms, do: jitter, station: y1, by: 300 us}\n"
                     "- {at: feature bead 1, after: 3 s, do: press, input: reset}\n"
                     "- {at: feature bead 1, after: 4 s, do: press, input: start}",
           .outlives_stops = true});
  CycleIndex stopped_at = 0;
  rig.on_step = [&](run::Owner& owner) {
    const CycleIndex now = owner.latest().cycle;
    if (owner.stopped() && stopped_at == 0) stopped_at = now;
    if (stopped_at != 0 && now == stopped_at + 6000) {  // behind reset and start
      EXPECT_EQ(owner.latest().latched, Fault::DcLost);
      EXPECT_EQ(owner.state(), State::Stopped);
      EXPECT_TRUE(owner.order({.kind = OrderKind::Abort}));
    }
  };
  const auto result = rig.run(kPatterns);
  EXPECT_NE(stopped_at, 0U);
  EXPECT_NE(result.board, record::Board::Whole);
  EXPECT_GE(std::count_if(result.alarms.begin(), result.alarms.end(), [](const auto& x) { return x.code == "G118"; }),
            2);
}

// In homing nothing is under way that could go on.
TEST(OutlivedStops, one_in_homing_ends_the_job_and_does_not_say_that_it_waits) {
  Rig rig({.script = "- {at: cycle 2500, do: set_input, input: door_closed, on: false}", .outlives_stops = true});
  const auto result = rig.run(kPatterns);
  ASSERT_FALSE(result.errors.empty());
  EXPECT_EQ(result.errors.front().fault, Fault::DoorOpen) << first_error(result);
  for (const std::string& event : result.events) EXPECT_EQ(event.find("the job waits"), std::string::npos) << event;
}

// The second stop comes on the way to the join: the time since the valve shut goes on.
TEST(OutlivedStops, a_second_one_on_the_way_to_a_join_keeps_the_time_since_the_cut) {
  Rig rig({.placement = "dx=0.5 mm", .outlives_stops = true});
  recipes::Recipe recipe = test::load_recipe(kPatterns);
  for (auto& m : recipe.materials) m.rejoin_within_s = 10;
  Clumsy hand(3);
  hand.at_open_valve = true, hand.runs_for = 200, hand.most = 1;
  bool again = false;
  rig.on_step = [&](run::Owner& owner) {
    const auto& s = owner.latest();
    hand(owner);
    if (again || hand.stops != 1 || hand.phase != Clumsy::Phase::Waiting || s.block == 0 || valve_open(s)) return;
    if (s.cycle < hand.since + 400) return;  // it has risen, and is on its way
    again = true;
    hand.most = 2, hand.at_open_valve = false, hand.runs_for = 0, hand.stands_for = 12'000;
  };
  const auto result = rig.run(recipe);
  EXPECT_TRUE(again);
  EXPECT_TRUE(result.joined.empty());
  ASSERT_EQ(result.defects.size(), 1u);
  EXPECT_NE(result.defects[0].message.find("not joined: its valve has been shut for 1"), std::string::npos)
      << result.defects[0].message;
}

// Nobody plays while the answer to an image is waited for: the job itself looks at its clamp.
TEST(OutlivedStops, a_part_that_is_let_go_on_hold_between_two_blocks_ends_the_job) {
  Rig rig({.placement = "dx=0.5 mm",
           .script = "- {at: mark front_left, after: 20 ms, do: press, input: hold, hold: 100 ms}\n"
                     "- {at: mark front_left, after: 2 s, do: set_input, input: clamp_closed, on: false}\n"
                     "- {at: mark front_left, after: 3 s, do: set_input, input: clamp_closed, on: true}\n"
                     "- {at: mark front_left, after: 4 s, do: press, input: start}"});
  const auto result = rig.run(kDemo);
  ASSERT_FALSE(result.errors.empty());
  EXPECT_EQ(result.errors.front().fault, Fault::ClampOpen) << first_error(result);
}

// By the machine's own buttons, as in a dry run.
TEST(OutlivedStops, the_buttons_are_enough) {
  Rig rig({.placement = "dx=0.5 mm",
           .script = "- {at: feature bead 1, after: 500 ms, do: set_input, input: door_closed, on: false}\n"
                     "- {at: feature bead 1, after: 1500 ms, do: set_input, input: door_closed, on: true}\n"
                     "- {at: feature bead 1, after: 2500 ms, do: press, input: reset}\n"
                     "- {at: feature bead 1, after: 3500 ms, do: press, input: start}",
           .outlives_stops = true});
  const auto result = rig.run(kPatterns);
  EXPECT_EQ(result.exit_code, ExitCode::Done) << first_error(result);
  EXPECT_EQ(result.joined.size(), 1u);
  EXPECT_EQ(result.board, record::Board::Whole);
}

}  // namespace
}  // namespace gantry
