#include "app/record/trace.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <random>

#include "tests/app/record/snapshots.hpp"

namespace gantry::record {
namespace {

double distance_to_segment(const Vec3& p, const Vec3& a, const Vec3& b) {
  const Vec3 ab = b - a;
  const double l = dot(ab, ab);
  const double t = l > 0 ? std::clamp(dot(p - a, ab) / l, 0.0, 1.0) : 0;
  return norm(p - (a + ab * t));
}

cycle::Snapshot at(std::uint32_t tick, Vec3 head) {
  auto s = tick_of(1, tick);
  s.time_ns = std::int64_t{tick} * 1'000'000;
  s.actual = {head.x, head.y, head.z};
  s.enabled = 7;
  return s;
}

JobResult filled(Trace& trace) {
  JobResult r;
  trace.fill(r);
  return r;
}

TEST(Trace, the_thinned_path_stays_close_to_the_real_one_and_is_much_shorter) {
  const auto seed = std::random_device{}();
  SCOPED_TRACE(::testing::Message() << "seed " << seed);
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> place(0, 200);
  Trace trace(three_axes());
  std::vector<Vec3> real;
  Vec3 p{0, 0, 0};
  std::uint32_t tick = 0;
  const auto step = [&](Vec3 q) { real.push_back(q), trace.add(at(++tick, q)); };
  for (int leg = 0; leg < 40; ++leg) {
    const Vec3 to{place(random), place(random), place(random)};
    const double length = norm(to - p);
    const int steps = static_cast<int>(length / 0.3) + 1;  // 300 mm/s
    for (int i = 1; i <= steps; ++i) step(p + (to - p) * (double(i) / steps));
    for (int i = 0; i < 100; ++i) step(to);  // stands
    p = to;
  }
  const auto r = filled(trace);
  EXPECT_LT(r.actual.size(), real.size() / 8);
  EXPECT_DOUBLE_EQ(r.actual_s, double(tick) * 1e-3);
  std::size_t leg = 0;
  double worst = 0;
  for (std::size_t i = 0; i < real.size(); ++i) {
    while (leg + 2 < r.actual.size() && r.actual[leg + 1].t_s < double(i) * 1e-3) ++leg;
    worst = std::max(worst, distance_to_segment(real[i], r.actual[leg].head, r.actual[leg + 1].head));
  }
  EXPECT_LT(worst, 0.05);
}

// The window is that of the speed in the cycle with the largest error, not of the full one.
TEST(Trace, the_largest_following_error_stands_beside_what_was_allowed_then) {
  config::Machine machine = three_axes();
  machine.axes[0].following_base = 0.05, machine.axes[0].following_per_speed_s = 0.002;
  Trace trace(machine);
  const auto cycle = [&](std::uint32_t n, double x, double following) {
    auto s = at(n, {x, 0, 0});
    s.cycle = n;
    s.target[0] = x;
    s.following[0] = following;
    trace.add(s);
  };
  cycle(1, 0, 0.001);
  cycle(2, 0.1, 0.020);  // 100 mm/s
  cycle(3, 0.4, 0.015);  // 300 mm/s
  const auto r = filled(trace);
  EXPECT_DOUBLE_EQ(r.axes[0].max_following, 0.020);
  EXPECT_NEAR(r.axes[0].allowed_there, 0.05 + 0.002 * 100, 1e-12);
}

TEST(Trace, following_error_counts_only_where_a_drive_is_enabled_in_a_block_and_measures) {
  Trace trace(three_axes());
  auto s = at(1, {});
  s.following = {0.010, -0.020, std::numeric_limits<double>::quiet_NaN()};
  trace.add(s);
  s.tick = 2, s.enabled = 0, s.following[0] = 5;  // not enabled
  trace.add(s);
  s.block = 0, s.enabled = 7;  // idle
  trace.add(s);
  const auto r = filled(trace);
  ASSERT_EQ(r.axes.size(), 3u);
  EXPECT_TRUE(r.axes[0].measured);
  EXPECT_DOUBLE_EQ(r.axes[0].max_following, 0.010);
  EXPECT_DOUBLE_EQ(r.axes[1].max_following, 0.020);
  EXPECT_FALSE(r.axes[2].measured);
}

TEST(Trace, adds_up_how_often_and_how_long_the_valve_was_open) {
  const auto valve = config::bit(config::Output::Valve);
  Trace trace(three_axes());
  unsigned tick = 0;
  for (const std::uint32_t outputs : {valve, 0u, valve, valve, 0u, 0u}) {
    auto s = at(++tick, {});
    s.outputs = outputs;
    trace.add(s);
  }
  const auto r = filled(trace);
  EXPECT_EQ(r.valve_openings, 2u);
  EXPECT_DOUBLE_EQ(r.valve_open_s, 0.003);
}

TEST(Trace, counts_cycles_misses_and_lost_frames) {
  Trace trace(three_axes());
  auto s = at(1, {});
  s.wake_ns = 20'000, s.compute_ns = 30'000, s.bus_ns = 100'000;
  for (int i = 0; i < 97; ++i) trace.add(s);
  s.wake_ns = 990'000;  // with its work this cycle ends after the next is due
  trace.add(s);
  s.sent = false;  // skipped by a stall
  trace.add(s);
  s.sent = true, s.wake_ns = 20'000, s.answered = s.inputs_fresh = s.complete = false, s.working_counter = 0;
  trace.add(s);
  s.answered = true;  // nobody took part, and the frame is back: it is not lost
  trace.add(s);
  s.inputs_fresh = true, s.working_counter = 5;
  trace.add(s);
  const auto c = filled(trace).cycles;
  EXPECT_EQ(c.cycles, 102u);
  EXPECT_EQ(c.sent, 101u);
  EXPECT_EQ(c.skipped, 1u);
  EXPECT_EQ(c.deadline_misses, 2u);
  EXPECT_EQ(c.frames_lost, 1u);
  EXPECT_EQ(c.working_counter_errors, 2u);
  EXPECT_EQ(c.stalls, 1u);
  EXPECT_EQ(c.wake.max, 1'020'000);  // the loop had asked for the beat before
  EXPECT_NEAR(static_cast<double>(c.wake.p50), 20'000, 20'000.0 / 16);
  std::uint64_t sum = 0;
  for (const auto& b : c.wake_histogram) sum += b.count;
  EXPECT_EQ(sum, c.sent);
}

}  // namespace
}  // namespace gantry::record
