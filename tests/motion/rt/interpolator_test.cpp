#include "motion/rt/interpolator.hpp"

#include <gtest/gtest.h>

#include "motion/profile/line_bounds.hpp"
#include "motion/rt/approach.hpp"
#include "tests/motion/rt/play.hpp"

namespace gantry::motion {
namespace {

using test::expect_within;
using test::kValve;
using test::machine;
using test::Player;
using test::pooled_block;

constexpr unsigned kSeed = 97;

AxisVec home() { return {200, 200, -5, 0, 12}; }

std::string label(int n) { return " case " + std::to_string(n) + " seed " + std::to_string(kSeed); }

/// One straight bead at 20 mm/s from (200, 200) along X, run-up included, as block 1.
struct StraightBead {
  Limits m = machine();
  BeadMotion bead;
  StraightBead(double length = 30, double speed = 20, double open_lead = 0.012) {
    BeadSpec spec;
    spec.points = {{200, 200, -40, 0, 12}, {200 + length, 200, -40, 0, 12}};
    spec.speed_mm_s = speed;
    spec.valve = kValve;
    spec.open_lead_s = open_lead, spec.close_lead_s = 0.007;
    spec.block = 1;
    bead = *plan_bead(m, spec);
    bead.segments.back().ends_block = true;
  }
};

TEST(Interpolator, nominal_play_is_the_plan_at_every_tick) {
  const Limits m = machine();
  for (int n = 0; n < 120; ++n) {
    AxisVec q = home();
    Player p(m, q);
    const std::vector<Segment> block = pooled_block(m, home(), n, q, 1);
    p.push(block);
    const std::vector<AxisVec> plan = test::sampled(block, m.tick_s);
    p.play.begin_block(1);
    for (std::size_t k = 1; k < plan.size(); ++k) {
      const Setpoint x = p.step();
      ASSERT_EQ(x.tick_in_block, k);
      for (std::size_t i = 0; i < m.axes; ++i) ASSERT_NEAR(x.q[i], plan[k][i], 1e-9) << "tick " << k << label(n);
      if (x.block_done) {
        ASSERT_GE(k + 2, plan.size()) << "done with the plan" << label(n);
        break;
      }
    }
    while (!p.play.idle()) p.step();
    ASSERT_LE(p.stream.size(), plan.size() + 5);
    for (std::size_t i = 0; i < m.axes; ++i) ASSERT_NEAR(p.last.q[i], q[i], 1e-9) << label(n);
    expect_within(p.use(), label(n));
  }
}

// The tick at which an event is due by the plan: the first n with s(n tick + lead + tick/2) >= at_s.
TEST(Interpolator, events_switch_on_exactly_the_planned_ticks) {
  const Limits m = machine();
  int edges = 0;
  for (int n = 0; n < 120; ++n) {
    AxisVec q = home();
    Player p(m, q);
    const std::vector<Segment> block = pooled_block(m, home(), n, q, 1);
    p.push(block);
    std::vector<std::pair<long, bool>> due;
    long double begin = 0;
    for (const Segment& s : block) {
      for (const OutputEvent& e : s.events) {
        long double lo = 0, hi = test::duration_of(s);
        for (int k = 0; k < 80; ++k) {
          const long double mid = (lo + hi) / 2;
          (test::path_state(s, mid).s < e.at_s - 2e-9 ? lo : hi) = mid;
        }
        const long double at = (begin + hi - e.lead_s) / m.tick_s - 0.5L;
        due.emplace_back(std::max(1L, static_cast<long>(std::ceil(at - 1e-6L))), e.value != 0);
      }
      begin += test::duration_of(s);
    }
    std::stable_sort(due.begin(), due.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
    p.play.begin_block(1);
    std::size_t next = 0;
    bool open = false;
    while (!p.play.idle()) {
      const Setpoint x = p.step();
      for (; next < due.size() && due[next].first == static_cast<long>(x.tick_in_block); ++next, ++edges)
        open = due[next].second;
      ASSERT_EQ((x.outputs & kValve) != 0, open) << "tick " << x.tick_in_block << label(n);
    }
    ASSERT_EQ(next, due.size()) << label(n);
  }
  EXPECT_GT(edges, 200);
}

TEST(Interpolator, the_same_segments_give_the_same_bits_whenever_they_were_pushed) {
  const Limits m = machine();
  for (int n = 0; n < 50; ++n) {
    AxisVec q = home();
    const std::vector<Segment> block = pooled_block(m, home(), n, q, 3);
    Player at_once(m, home()), late(m, home());
    at_once.push(block);
    at_once.play.begin_block(3);
    while (!at_once.play.idle()) at_once.step();
    late.play.begin_block(3);
    std::size_t pushed = 0;
    double ahead = 0;
    while (!late.play.idle()) {
      // One second of path ahead is in time: the longest stop here takes less.
      for (; pushed < block.size() && ahead < 1.0; ++pushed) {
        late.push(block[pushed]);
        ahead += static_cast<double>(test::duration_of(block[pushed]));
      }
      late.step();
      ahead -= m.tick_s;
    }
    ASSERT_EQ(at_once.stream, late.stream) << label(n);
  }
}

// Whatever happens, at any tick: the axes keep their limits and the tool its path; without an abort the end is reached.
TEST(Interpolator, holds_resumes_and_overrides_at_random_keep_path_and_limits) {
  const Limits m = machine();
  std::mt19937_64 random(kSeed + 3);
  const auto uniform = [&](double lo, double hi) { return std::uniform_real_distribution<double>(lo, hi)(random); };
  for (int n = 0; n < 500; ++n) {
    AxisVec q = home();
    Player p(m, q);
    p.push(pooled_block(m, home(), n, q, 1));
    p.play.begin_block(1);
    double factor = 1;
    const double restless = std::pow(10.0, uniform(-3, -1));  // actions a tick
    int ticks = 0;
    while (!p.play.idle() && ++ticks < 400000) {
      if (uniform(0, 1) < restless) {
        const double what = uniform(0, 1);
        if (what < 0.3)
          p.play.hold();
        else if (what < 0.6)
          p.play.resume();
        else if (what < 0.8)
          factor = uniform(0.1, 2);
        else
          factor = 1;
      } else if (p.play.held() && p.play.at_rest() && uniform(0, 1) < 0.05) {
        p.play.resume();
      }
      const Setpoint x = p.step(factor);
      if (p.play.held()) {
        ASSERT_EQ(x.outputs & kValve, 0u) << label(n);
      }
      if (x.block != 0) p.expect_on_path(label(n));
      ASSERT_FALSE(testing::Test::HasFatalFailure());
    }
    ASSERT_LT(ticks, 400000) << "never ended" << label(n);
    for (std::size_t i = 0; i < m.axes; ++i) ASSERT_NEAR(p.last.q[i], q[i], 1e-9) << label(n);
    expect_within(p.use(), label(n));
    ASSERT_FALSE(testing::Test::HasFatalFailure());
  }
}

TEST(Interpolator, starvation_at_random_brakes_on_the_path_and_goes_on) {
  const Limits m = machine();
  std::mt19937_64 random(kSeed + 4);
  const auto uniform = [&](double lo, double hi) { return std::uniform_real_distribution<double>(lo, hi)(random); };
  int starved = 0;
  for (int n = 0; n < 500; ++n) {
    AxisVec q = home();
    Player p(m, q);
    const std::vector<Segment> block = pooled_block(m, home(), n, q, 1);
    p.play.begin_block(1);
    const double rate = std::pow(10.0, uniform(-2.7, -0.5)), factor = uniform(0, 1) < 0.7 ? 1 : uniform(0.2, 2);
    std::size_t pushed = 0;
    int ticks = 0;
    bool starving = false;
    while (!p.play.idle() && ++ticks < 400000) {
      while (pushed < block.size() && uniform(0, 1) < rate) p.push(block[pushed++]);
      const Setpoint x = p.step(factor);
      starving = starving || p.play.starving();
      if (x.block != 0) p.expect_on_path(label(n));
      ASSERT_FALSE(testing::Test::HasFatalFailure());
    }
    ASSERT_LT(ticks, 400000) << "never ended" << label(n);
    starved += starving;
    for (std::size_t i = 0; i < m.axes; ++i) ASSERT_NEAR(p.last.q[i], q[i], 1e-9) << label(n);
    expect_within(p.use(), label(n));
    ASSERT_FALSE(testing::Test::HasFatalFailure());
  }
  EXPECT_GT(starved, 100);
}

TEST(Interpolator, abort_stops_on_the_path_and_forgets_the_rest) {
  const Limits m = machine();
  std::mt19937_64 random(kSeed + 5);
  for (int n = 0; n < 500; ++n) {
    AxisVec q = home();
    Player p(m, q);
    const std::vector<Segment> block = pooled_block(m, home(), n, q, 1);
    p.push(block);
    p.play.begin_block(1);
    const auto at = std::uniform_int_distribution<int>(1, static_cast<int>(duration(block) / m.tick_s))(random);
    for (int k = 0; k < at; ++k) p.step();
    p.play.abort();
    int ticks = 0;
    for (; !p.play.idle() && ticks < 5000; ++ticks) {
      const Setpoint x = p.step();
      ASSERT_EQ(x.outputs & kValve, 0u);
      ASSERT_FALSE(x.block_done && p.ring->size() > 0);
      if (x.block != 0) p.expect_on_path(label(n));
    }
    ASSERT_LT(ticks, 1000) << label(n);
    EXPECT_EQ(p.ring->size(), 0u);
    EXPECT_TRUE(p.play.at_rest());
    // The next block starts where the tool stands.
    AxisVec from = p.last.q, to = home();
    std::vector<Segment> next = line_move(m, from, to);
    for (Segment& s : next) s.block = 2, s.ends_block = true;
    p.push(next);
    p.play.begin_block(2);
    while (!p.play.idle()) p.step();
    for (std::size_t i = 0; i < m.axes; ++i) ASSERT_NEAR(p.last.q[i], to[i], 1e-9);
    expect_within(p.use(), label(n));
    ASSERT_FALSE(testing::Test::HasFatalFailure());
  }
}

TEST(Interpolator, axis_stop_brakes_every_axis_within_its_own_limits) {
  const Limits m = machine();
  std::mt19937_64 random(kSeed + 6);
  for (int n = 0; n < 500; ++n) {
    AxisVec q = home();
    Player p(m, q);
    const std::vector<Segment> block = pooled_block(m, home(), n, q, 1);
    p.push(block);
    p.play.begin_block(1);
    const auto at = std::uniform_int_distribution<int>(1, static_cast<int>(duration(block) / m.tick_s))(random);
    for (int k = 0; k < at && !p.play.idle(); ++k) p.step();
    p.play.axis_stop();
    int ticks = 0;
    for (; (ticks == 0 || !p.play.idle()) && ticks < 5000; ++ticks) ASSERT_EQ(p.step().outputs & kValve, 0u);
    ASSERT_LT(ticks, 1000);
    EXPECT_TRUE(p.play.at_rest());
    p.step();
    expect_within(p.use(), label(n));
    ASSERT_FALSE(testing::Test::HasFatalFailure());
  }
}

constexpr AxisId kDown{2};
constexpr double kSeenWithin_s = 0.025;  // as docs/monitoring.md has it

TEST(Interpolator, a_touch_ends_beyond_where_the_probe_latches_and_ends_its_block) {
  const Limits m = machine();
  std::mt19937_64 random(kSeed + 7);
  for (int n = 0; n < 500; ++n) {
    Player p(m, home());
    AxisVec down = home();
    down[2] = -25;
    std::vector<Segment> touch =
        probe_move(m, home(), down, std::pow(10.0, std::uniform_real_distribution<double>(0, 2)(random)));
    for (Segment& s : touch) s.block = 4;
    p.push(touch);
    p.play.begin_block(4);
    const int total = static_cast<int>(std::lround(duration(touch) / m.tick_s));
    const int at = std::uniform_int_distribution<int>(1, total)(random);
    Setpoint x;
    for (int k = 0; k < at; ++k) x = p.step();
    EXPECT_TRUE(x.probing);
    const double speed = x.s_dot, s = x.s;
    p.play.probe_latched(kDown, x.q[2]);
    int ticks = 0;
    while (!p.play.idle() && ++ticks < 1000) {
      x = p.step();
      p.expect_on_path(label(n));
    }
    ASSERT_LT(ticks, 1000);
    if (at < total) {
      EXPECT_TRUE(x.block_done) << label(n);
    }
    EXPECT_TRUE(x.probing || at == total);
    EXPECT_TRUE(p.play.at_rest());
    EXPECT_EQ(p.ring->size(), 0u);
    // The distance travelled at speed and what a stop needs, were it at its worst: still speeding up.
    const Bounds b = line_bounds(m, derivative<1>(touch[0].geometry, 0));
    EXPECT_LE(x.s, s + kSeenWithin_s * touch[0].v_cap + distance_to_speed({0, speed, b.a}, 0, b) + 1e-9) << label(n);
    p.step();
    expect_within(p.use(), label(n));
  }
}

/// A touch at `speed` that latches at `latched` below its start and is told `late` ticks after the setpoint passed
/// there.
std::vector<Setpoint> touch_told_late(double speed, double latched, int late) {
  const Limits m = machine();
  Player p(m, home());
  AxisVec down = home();
  down[2] = -25;
  std::vector<Segment> touch = probe_move(m, home(), down, speed);
  touch[0].block = 4;
  p.push(touch);
  p.play.begin_block(4);
  std::vector<Setpoint> stream;
  while (stream.empty() || stream.back().s < latched) stream.push_back(p.step());
  for (int k = 0; k < late; ++k) stream.push_back(p.step());
  p.play.probe_latched(kDown, home()[2] - latched);
  while (!p.play.idle()) stream.push_back(p.step());
  EXPECT_TRUE(stream.back().block_done);
  return stream;
}

TEST(Interpolator, a_touch_is_a_function_of_where_it_latched_not_of_when_that_was_seen) {
  for (const double speed : {0.5, 5.0, 40.0})
    for (const double latched : {7.0, 7.1234567}) {
      const std::vector<Setpoint> at_once = touch_told_late(speed, latched, 0);
      EXPECT_GT(at_once.back().s, latched);
      for (int late = 1; late <= 24; ++late) {
        const std::vector<Setpoint> seen = touch_told_late(speed, latched, late);
        ASSERT_EQ(seen.size(), at_once.size()) << late;
        for (std::size_t k = 0; k < seen.size(); ++k) ASSERT_NEAR(seen[k].q[2], at_once[k].q[2], 1e-9) << late;
      }
      const std::vector<Setpoint> too_late = touch_told_late(speed, latched, 60);
      EXPECT_GT(too_late.size(), at_once.size());
      EXPECT_LT(too_late.size(), at_once.size() + 60) << "brakes at once";
    }
}

TEST(Interpolator, a_latched_place_that_cannot_be_only_makes_a_touch_end_sooner) {
  for (const double latched : {-100.0, 100.0}) {
    const Limits m = machine();
    Player p(m, home());
    AxisVec down = home();
    down[2] = -25;
    std::vector<Segment> touch = probe_move(m, home(), down, 5);
    touch[0].block = 4;
    p.push(touch);
    p.play.begin_block(4);
    for (int k = 0; k < 1000; ++k) p.step();
    const double seen_at = p.last.s;
    p.play.probe_latched(kDown, home()[2] - latched);
    while (!p.play.idle()) p.step();
    const Bounds b = line_bounds(m, derivative<1>(touch[0].geometry, 0));
    EXPECT_LE(p.last.s, seen_at + kSeenWithin_s * 5 + distance_to_speed({0, 5, 0}, 0, b) + 1e-6) << latched;
  }
}

TEST(Interpolator, a_touch_that_meets_nothing_ends_its_block_too) {
  const Limits m = machine();
  Player p(m, home());
  AxisVec down = home();
  down[2] = -25;
  std::vector<Segment> touch = probe_move(m, home(), down, 5);
  for (Segment& s : touch) s.block = 4;
  p.push(touch);
  p.play.begin_block(4);
  Setpoint x;
  while (!p.play.idle()) x = p.step();
  EXPECT_TRUE(x.block_done);
  EXPECT_TRUE(x.probing);
  EXPECT_NEAR(x.q[2], -25, 1e-9);
}

TEST(Interpolator, a_held_bead_stays_dry_until_the_next_dispense_command) {
  StraightBead one;
  Player p(one.m, one.bead.start);
  p.push(one.bead.segments);
  std::vector<Segment> again = line_move(one.m, one.bead.end, one.bead.start);
  again.insert(again.end(), one.bead.segments.begin(), one.bead.segments.end());
  for (Segment& s : again) s.block = 2;
  p.push(again);
  p.play.begin_block(1);
  while (p.last.q[0] < 210) p.step();
  EXPECT_EQ(p.last.outputs & kValve, kValve);
  p.play.hold();
  EXPECT_EQ(p.step().outputs & kValve, 0u) << "closed in the same tick";
  for (int k = 0; k < 300; ++k) EXPECT_EQ(p.step().outputs & kValve, 0u);
  EXPECT_TRUE(p.play.at_rest());
  EXPECT_TRUE(p.play.held());
  const double stands = p.last.q[0];
  EXPECT_LE(stands, 210 + 20 * 0.001 + change_length(20, 0, 5000, 80000) + 1e-9);
  p.play.resume();
  while (!p.play.idle()) EXPECT_EQ(p.step().outputs & kValve, 0u) << "only a dispense command opens again";
  p.play.begin_block(2);
  bool opened = false;
  while (!p.play.idle()) opened = (p.step().outputs & kValve) != 0 || opened;
  EXPECT_TRUE(opened);
}

TEST(Interpolator, a_hold_before_the_bead_does_not_lose_the_bead) {
  StraightBead one(30, 20, 0.028);
  Player p(one.m, one.bead.start);
  p.push(one.bead.segments);
  p.play.begin_block(1);
  while ((p.last.outputs & kValve) == 0) p.step();
  ASSERT_LT(p.last.q[0], 200) << "opened ahead by its lead";
  p.play.hold();
  EXPECT_EQ(p.step().outputs & kValve, 0u);
  while (!p.play.at_rest()) p.step();
  ASSERT_LT(p.last.q[0], 200) << "stopped in the run-up";
  p.play.resume();
  while ((p.last.outputs & kValve) == 0 && !p.play.idle()) p.step();
  EXPECT_LE(p.last.q[0], 200 + 20 * 0.0005);
  EXPECT_FALSE(p.play.idle());
}

TEST(Interpolator, override_scales_a_line_up_to_the_axis_limits) {
  const Limits m = machine();
  AxisVec to = home();
  to[0] += 400;
  for (const double factor : {0.1, 0.5, 1.5, 2.0}) {
    Player p(m, home());
    std::vector<Segment> move = line_move(m, home(), to, 100);
    move[0].block = 1, move[0].ends_block = true;
    p.push(move);
    p.play.begin_block(1);
    while (p.last.q[0] < 220) p.step();
    for (int k = 0; k < 150; ++k) p.step(factor);
    EXPECT_NEAR(p.last.s_dot, 100 * factor, 0.2) << factor;
    while (!p.play.idle()) p.step(1);
    EXPECT_NEAR(p.last.q[0], to[0], 1e-9);
  }
}

TEST(Interpolator, override_scales_the_speed_of_a_bead_not_above_the_plan_and_comes_back_to_it) {
  StraightBead one(200, 100);
  for (const double factor : {0.1, 0.5, 1.5, 2.0}) {
    Player p(one.m, one.bead.start);
    p.push(one.bead.segments);
    p.play.begin_block(1);
    while (p.last.q[0] < 220) p.step();
    for (int k = 0; k < 150; ++k) p.step(factor);
    EXPECT_NEAR(p.last.s_dot, 100 * std::min(factor, 1.0), 0.2) << factor;
    for (int k = 0; k < 150; ++k) p.step(1);
    EXPECT_NEAR(p.last.s_dot, 100, 0.2) << factor;
    while (!p.play.idle()) p.step(1);
    EXPECT_NEAR(p.last.q[0], one.bead.end[0], 1e-9);
    expect_within(p.use(), " override " + std::to_string(factor));
  }
}

// Of one percent, too, where the axes would let the speed change by far more in a tick.
TEST(Interpolator, a_small_change_of_override_comes_to_its_speed_and_stays_there) {
  for (const double speed : {1.0, 2.0, 5.0, 50.0})
    for (const auto& [before, after] : {std::pair{0.5, 0.49}, {0.8, 0.79}, {0.8, 0.81}, {0.03, 0.033}, {1.0, 0.999}}) {
      StraightBead one(speed, speed);
      Player p(one.m, one.bead.start);
      p.push(one.bead.segments);
      p.play.begin_block(1);
      while (p.last.q[0] < 200 + 0.1 * speed) p.step(before);
      for (int n = 0; n < 60; ++n) {
        p.step(after);
        ASSERT_NEAR(p.last.s_dot, speed * after, speed * (n > 40 ? 1e-6 : 1)) << speed << " " << after << " " << n;
        ASSERT_LE(p.last.s_dot, speed * std::max(before, after) * (1 + 1e-9));
        ASSERT_GE(p.last.s_dot, speed * std::min(before, after) * (1 - 1e-9));
      }
    }
}

// Ordered in every tick of a bead that brakes before a corner and speeds up behind it.
TEST(Interpolator, a_change_of_override_does_not_swing_beyond_both_rates) {
  const Limits m = machine();
  BeadSpec spec;
  spec.points = {{200, 200, -40, 0, 12}, {240, 200, -40, 0, 12}, {240, 240, -40, 0, 12}};
  spec.speed_mm_s = 150, spec.block = 1;
  auto bead = plan_bead(m, spec);
  ASSERT_TRUE(bead) << to_text(bead.error());
  bead->segments.back().ends_block = true;
  const int ticks = static_cast<int>(duration(bead->segments) / m.tick_s);
  for (const auto& [before, after] : {std::pair{1.0, 0.99}, {1.0, 0.9}, {0.9, 0.91}, {0.5, 0.49}})
    for (int at = 3; at < ticks; ++at) {
      Player p(m, bead->start);
      p.push(bead->segments);
      p.play.begin_block(1);
      for (int n = 0; n < at; ++n) p.step(before), p.expect_on_path("");
      for (int n = 0; n < 300 && !p.play.idle(); ++n) {
        p.step(after);
        p.expect_on_path("");
        const SpeedProfile& plan = p.path[p.on].nominal;
        const double planned = along(plan, time_at(plan, p.last.s)).x.v;
        if (planned < 1) continue;
        ASSERT_GT(p.last.s_dot / planned, std::min(before, after) - 0.021)
            << before << " to " << after << ", tick " << at;
        ASSERT_LT(p.last.s_dot / planned, std::max(before, after) + 0.021)
            << before << " to " << after << ", tick " << at;
      }
    }
}

TEST(Interpolator, events_under_override_are_off_by_what_half_a_tick_travels_at_most) {
  StraightBead one(60, 50);
  for (const double factor : {0.3, 0.7, 1.3, 2.0}) {
    Player p(one.m, one.bead.start);
    p.push(one.bead.segments);
    p.play.begin_block(1);
    std::vector<double> x{p.last.q[0]};
    double opened = 0, closed = 0;  // tick numbers
    bool open = false;
    while (!p.play.idle()) {
      p.step(factor);
      x.push_back(p.last.q[0]);
      const bool now = (p.last.outputs & kValve) != 0;
      if (now != open) (now ? opened : closed) = static_cast<double>(x.size() - 1);
      open = now;
    }
    const auto place = [&](double tick) {
      const auto k = static_cast<std::size_t>(tick);
      return x[k] + (tick - static_cast<double>(k)) * (x[k + 1] - x[k]);
    };
    EXPECT_NEAR(place(opened + 12), 200, 50 * std::min(factor, 1.0) * 0.0005 + 1e-3) << factor;
    EXPECT_NEAR(place(closed + 7), 260, 50 * std::min(factor, 1.0) * 0.0005 + 1e-3) << factor;
  }
}

// Nothing is clamped: a plan that is wrong stops the axes and is told.
TEST(Interpolator, a_piece_that_s_leaves_is_told_and_every_axis_brakes_by_itself) {
  for (const bool short_piece : {true, false}) {
    StraightBead one(60, 50);
    Player p(one.m, one.bead.start);
    std::vector<Segment> wrong = one.bead.segments;
    if (short_piece)
      wrong[1].geometry.length -= 1e-3;
    else
      wrong[2].kind = SegmentKind::Path;  // nothing that the piece before could go on in
    p.push(wrong);
    p.play.begin_block(1);
    int told = 0;
    while (!p.play.idle()) {
      const bool off_path = p.step().off_path;
      told += off_path;
      if (told > 0) {
        EXPECT_EQ(p.last.outputs & kValve, 0u);
      }
    }
    EXPECT_EQ(told, 1) << short_piece;
    EXPECT_TRUE(p.play.at_rest());
    EXPECT_EQ(p.ring->size(), 0u);
    expect_within(p.use(), short_piece ? " short" : " alone");
  }
}

TEST(Interpolator, a_dwell_freezes_under_hold_and_ignores_override) {
  const Limits m = machine();
  Player p(m, home());
  Segment wait = dwell(m, home(), 0.1);
  wait.block = 1, wait.ends_block = true;
  p.push(wait);
  p.play.begin_block(1);
  for (int k = 0; k < 40; ++k) p.step(0.5);
  EXPECT_NEAR(p.last.s, 0.040, 1e-12);
  p.play.hold();
  for (int k = 0; k < 40; ++k) p.step();
  EXPECT_NEAR(p.last.s, 0.040, 1e-12);
  p.play.resume();
  int ticks = 0;
  while (!p.play.idle()) p.step(2), ++ticks;
  EXPECT_EQ(ticks, 60);
}

TEST(Interpolator, an_idle_machine_stands_whatever_is_asked_of_it) {
  Player p(machine(), home());
  p.play.hold();
  p.play.resume();
  p.play.abort();
  p.play.probe_latched(kDown, -10);
  const Setpoint x = p.step(NAN);
  EXPECT_EQ(x.q, home());
  EXPECT_EQ(x.block, 0u);
  EXPECT_FALSE(x.moving);
  EXPECT_TRUE(p.play.idle());
}

TEST(Interpolator, leftovers_of_an_earlier_block_are_dropped) {
  const Limits m = machine();
  Player p(m, home());
  Segment old = dwell(m, home(), 0.1), now = dwell(m, home(), 0.01);
  old.block = 1, now.block = 2, now.ends_block = true;
  p.push(old);
  p.push(now);
  p.play.begin_block(2);
  int ticks = 0;
  while (!p.play.idle()) p.step(), ++ticks;
  EXPECT_EQ(ticks, 10);
}

}  // namespace
}  // namespace gantry::motion
