// Holds around the commands of a valve that takes long to open and to shut. Judged by what lies on the world's board.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "tests/machine/order.hpp"
#include "tests/machine/rig.hpp"

namespace gantry {
namespace {

using run::OrderKind;
using test::Rig;
using test::valve_open;

/// A dot and a bead of a valve whose lags are long, each as its lead has it.
recipes::Recipe slow_valve(int open_ms, int close_ms, int settle_ms = 0) {
  return *recipes::parse(
      fmt::format(
          "version: 1\nrecipe: valve\nplacement: fixture\nboard: {{size: [80 mm, 55 mm], thickness: 12 mm, frame: "
          "pallet}}\nmaterials:\n  glue: {{speed: 20 mm/s, gap: 0.3 mm, valve_open_lead: {} ms, valve_close_lead: {} "
          "ms, dot_time: {} ms, settle_time: {} ms, retract: 3 mm}}\nfeatures:\n  - dot: {{name: d, material: glue, "
          "at: [20 mm, 20 mm]}}\n"
          "  - dot: {{name: e, material: glue, at: [30 mm, 26 mm]}}\n"
          "  - line: {{name: bead, material: glue, from: [40 mm, 20 mm], to: [44 mm, 22 mm]}}\n",
          open_ms, close_ms, open_ms + close_ms, settle_ms),
      "valve.yaml");
}
test::RigOptions of_slow_valve(int open_ms, int close_ms) {
  return {.placement = "dx=0 mm, dy=0 mm, rot=0 deg, dz=0 mm, tilt_x=0 deg, tilt_y=0 deg",
          .change = [=](config::Machine& m) {
            m.sim.valve_open_lag_s = open_ms * 1e-3, m.sim.valve_close_lag_s = close_ms * 1e-3;
          }};
}
void expect_good(const record::JobResult& result) {
  EXPECT_EQ(result.exit_code, ExitCode::Done);
  EXPECT_TRUE(result.interrupted.empty());
  EXPECT_EQ(result.deposits.size(), 3u);
  for (const auto& d : result.defects) ADD_FAILURE() << d.feature << ": " << d.message;
}

struct Opening {
  CycleIndex opens = 0, shuts = 0;
};
std::vector<Opening> undisturbed(int open_ms, int close_ms, int settle_ms = 0) {
  std::vector<Opening> out;
  bool valve = false;
  Rig rig(of_slow_valve(open_ms, close_ms));
  rig.on_step = [&](run::Owner& owner) {
    const auto& s = owner.latest();
    if (valve_open(s) && !valve) out.push_back({s.cycle, 0});
    if (!valve_open(s) && valve) out.back().shuts = s.cycle;
    valve = valve_open(s);
  };
  expect_good(rig.run(slow_valve(open_ms, close_ms, settle_ms)));
  return out;
}
/// `stands`: resumed when it has stood a while, else while it still brakes.
record::JobResult held_in(CycleIndex cycle, bool now, int open_ms, int close_ms, int settle_ms = 0,
                          bool stands = true) {
  Rig rig(of_slow_valve(open_ms, close_ms));
  CycleIndex stood = 0;
  bool held = false, resumed = false;
  rig.on_step = [&](run::Owner& owner) {
    const auto& s = owner.latest();
    if (s.cycle == cycle) held = owner.order({.kind = OrderKind::Hold, .now = now}).has_value();
    if (held && stood == 0 && s.state == (stands ? cycle::State::Held : cycle::State::Holding)) stood = s.cycle;
    if (stood != 0 && !resumed && s.cycle > stood + (stands ? 300 : 0))
      resumed = owner.order({.kind = OrderKind::Resume}).has_value();
  };
  auto result = rig.run(slow_valve(open_ms, close_ms, settle_ms));
  EXPECT_TRUE(resumed);
  return result;
}

// The command to shut comes so early that a hold right behind it would stop the needle before the bead's end.
TEST(SlowValve, held_behind_a_bead_has_come_to_its_end) {
  for (const int close_ms : {6, 30, 60}) {
    const auto openings = undisturbed(8, close_ms);
    ASSERT_EQ(openings.size(), 3u);
    const CycleIndex shuts = openings[2].shuts;
    for (const auto& [cycle, now] : {std::pair{shuts - 100, false},
                                     {shuts - 1, false},
                                     {shuts + close_ms / 2, false},
                                     {shuts, true},
                                     {shuts + close_ms / 2, true},
                                     {shuts + close_ms - 1, true}}) {
      SCOPED_TRACE(fmt::format("{} ms, {} cycles behind, {}", close_ms, cycle - shuts, now));
      expect_good(held_in(cycle, now, 8, close_ms));
    }
  }
}

// Its valve is told to open ahead of it: on the way there as on the way back to it.
TEST(SlowValve, held_on_the_way_to_a_feature_opens_for_its_beginning) {
  for (const int open_ms : {8, 40}) {
    const auto openings = undisturbed(open_ms, 6);
    ASSERT_EQ(openings.size(), 3u);
    for (const std::size_t next : {1u, 2u})
      for (const int before : {60, 40, 24, 16, 12, 8, 4, 1}) {
        SCOPED_TRACE(fmt::format("{} ms, opening {}, {} cycles before", open_ms, next, before));
        expect_good(held_in(openings[next].opens - before, true, open_ms, 6));
        expect_good(held_in(openings[next].opens - before, true, open_ms, 6, 0, false));
      }
  }
}

// In the cycle of its arrival, too: the path has left one piece then, and has not begun the next.
TEST(SlowValve, held_as_the_needle_arrives_opens_for_all_the_same) {
  constexpr int kSettle_ms = 40;
  const auto openings = undisturbed(8, 6, kSettle_ms);
  ASSERT_EQ(openings.size(), 3u);
  for (int before = kSettle_ms - 20; before < kSettle_ms + 10; ++before) {
    SCOPED_TRACE(before);
    expect_good(held_in(openings[1].opens - before, true, 8, 6, kSettle_ms));
  }
}

// Cut while the valve's lead goes by, so that nothing has come out: it is dispensed as if it had not been begun.
TEST(SlowValve, a_dot_of_which_nothing_lies_is_dispensed_all_the_same) {
  const auto openings = undisturbed(60, 10);
  ASSERT_EQ(openings.size(), 3u);
  for (const int behind : {0, 1, 10, 30, 47}) {
    SCOPED_TRACE(behind);
    expect_good(held_in(openings[1].opens + behind, true, 60, 10));
  }
}

// Cut so late that what is missing is within the material's tolerance: it is done, and named nowhere.
TEST(SlowValve, a_dot_of_which_nearly_all_lies_is_done) {
  const auto openings = undisturbed(20, 60);
  ASSERT_EQ(openings.size(), 3u);
  for (const int before : {1, 2, 3, 4, 5}) {
    SCOPED_TRACE(before);
    expect_good(held_in(openings[1].shuts - before, true, 20, 60));
  }
}

// The needle stays where it is as long as something comes out.
TEST(SlowValve, cut_by_a_hold_is_not_lifted_before_it_has_shut) {
  for (const int close_ms : {6, 60, 200}) {
    const auto openings = undisturbed(8, close_ms);
    ASSERT_EQ(openings.size(), 3u);
    const auto result = held_in(openings[2].opens + 20, true, 8, close_ms);
    for (const auto& d : result.defects) EXPECT_NE(d.kind, record::Defect::Kind::Gap) << close_ms << ": " << d.message;
    for (const auto& d : result.deposits) EXPECT_NEAR(d.gap_mm, 0.3, 0.02) << close_ms << " " << d.id;
  }
}

}  // namespace
}  // namespace gantry
