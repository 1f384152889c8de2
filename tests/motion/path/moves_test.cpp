#include "motion/path/moves.hpp"

#include <gtest/gtest.h>

#include "tests/motion/machine.hpp"
#include "tests/motion/path/sampled.hpp"

namespace gantry::motion {
namespace {

using test::limit_use;
using test::machine;
using test::path_state;
using test::sampled;

bool is_whole(double seconds, double tick_s) {
  const double n = seconds / tick_s;
  return std::abs(n - std::round(n)) < 1e-9;
}

AxisVec somewhere(std::mt19937_64& random, const Limits& m) {
  AxisVec q{};
  for (std::size_t i = 0; i < m.axes; ++i)
    q[i] = std::uniform_real_distribution<double>(m.axis[i].p_min, m.axis[i].p_max)(random);
  return q;
}

TEST(LineMove, takes_every_axis_straight_there_within_its_limits_in_whole_ticks) {
  const Limits m = machine();
  constexpr unsigned seed = 5;
  std::mt19937_64 random(seed);
  double use = 0;
  for (int n = 0; n < 2000; ++n) {
    const AxisVec from = somewhere(random, m);
    AxisVec to = somewhere(random, m);
    const double share = std::pow(10.0, std::uniform_real_distribution<double>(-5, 0)(random));
    for (std::size_t i = 0; i < m.axes; ++i) {
      to[i] = from[i] + share * (to[i] - from[i]);
      if (std::uniform_int_distribution<int>(0, 2)(random) == 0) to[i] = from[i];
    }
    const std::vector<Segment> move = line_move(m, from, to);
    if (move.empty()) {
      EXPECT_EQ(from, to);
      continue;
    }
    ASSERT_EQ(move.size(), 1u);
    EXPECT_TRUE(is_whole(duration(move), m.tick_s)) << n << " seed " << seed;
    const std::vector<AxisVec> q = sampled(move, 2.5e-4);
    for (std::size_t i = 0; i < m.axes; ++i) {
      EXPECT_NEAR(q.front()[i], from[i], 1e-12);
      EXPECT_NEAR(point(move[0].geometry, static_cast<double>(path_state(move[0], 1e9).s))[i], to[i], 1e-9);
    }
    const test::Use u = limit_use(m, q, 2.5e-4);
    ASSERT_LE(std::max({u.v, u.a, u.j}), 1 + 1e-9) << n << " seed " << seed;
    if (duration(move) > 0.1) use = std::max(use, 1 / std::max({u.v, u.a, u.j}));
    const auto end = test::path_state(move[0], 1e9);
    ASSERT_NEAR(static_cast<double>(end.s), move[0].geometry.length, 1e-9 * std::max(1.0, move[0].geometry.length));
    ASSERT_NEAR(static_cast<double>(end.v), 0, 1e-9);
  }
  EXPECT_LE(use, 1.1) << "some limit is used, as far as whole ticks let it";
}

TEST(LineMove, keeps_the_speed_cap_along_the_linear_path) {
  const Limits m = machine();
  AxisVec from{}, to{};
  from[2] = to[2] = -50, to[0] = 30, to[1] = 40;
  const auto move = line_move(m, from, to, 100);
  EXPECT_DOUBLE_EQ(move[0].geometry.length, 50);
  double top = 0;
  for (double t = 0; t < duration(move); t += 1e-3) top = std::max(top, static_cast<double>(path_state(move[0], t).v));
  EXPECT_LE(top, 100);
  EXPECT_GE(top, 99);
  EXPECT_EQ(move[0].v_cap, 100);
}

TEST(LineMove, of_rotary_axes_alone_counts_radians) {
  AxisVec from{}, to{};
  to[3] = 1.5;
  const auto move = line_move(machine(), from, to);
  EXPECT_DOUBLE_EQ(move[0].geometry.length, 1.5);
}

/// Of a linear axis that comes back by other sums than it went away by.
TEST(LineMove, of_a_rotary_axis_is_one_whatever_rounding_has_left_of_the_others) {
  for (const double left : {0.0, 3.6e-15, 1e-13, 1e-9, 9e-4}) {
    AxisVec from{}, to{};
    from[0] = 20 + left, to[0] = 20, from[3] = 0.035;
    const auto move = line_move(machine(), from, to);
    ASSERT_EQ(move.size(), 1u) << left;
    EXPECT_NEAR(move[0].geometry.length, 0.035, 1e-12) << left;
    const AxisVec begin = point(move[0].geometry, 0), end = point(move[0].geometry, move[0].geometry.length);
    for (std::size_t i = 0; i < machine().axes; ++i) {
      EXPECT_NEAR(begin[i], from[i], 1e-12) << left;
      EXPECT_NEAR(end[i], to[i], 1e-12) << left;
    }
  }
}

TEST(LineMove, to_where_it_stands_is_nothing) {
  AxisVec q{};
  q[1] = 7;
  EXPECT_TRUE(line_move(machine(), q, q).empty());
}

TEST(ProbeMove, is_a_line_that_ends_its_block) {
  AxisVec from{}, to{};
  to[2] = -5;
  const auto move = probe_move(machine(), from, to, 4);
  ASSERT_EQ(move.size(), 1u);
  EXPECT_EQ(move[0].kind, SegmentKind::UntilProbe);
  EXPECT_TRUE(move[0].ends_block);
}

TEST(Dwell, stands_for_whole_ticks_and_carries_its_events) {
  const Limits m = machine();
  const OutputEvent events[] = {{0, 0.002, 1, 1, true}, {0.0203, 0.001, 1, 0, false}};
  const Segment s = dwell(m, AxisVec{3, 4}, 0.0203, events);
  EXPECT_DOUBLE_EQ(s.geometry.length, 0.021);
  EXPECT_EQ(s.events.size(), 2u);
  EXPECT_EQ(point(s.geometry, 0.01)[1], 4);
  EXPECT_TRUE(is_whole(static_cast<double>(test::duration_of(s)), m.tick_s));
}

}  // namespace
}  // namespace gantry::motion
