#include "motion/path/arch.hpp"

#include <gtest/gtest.h>

#include "motion/path/chords.hpp"
#include "motion/path/moves.hpp"
#include "tests/motion/machine.hpp"
#include "tests/motion/path/sampled.hpp"

namespace gantry::motion {
namespace {

using test::limit_use;
using test::machine;
using test::sampled;

constexpr std::size_t kZ = 2;
constexpr unsigned kArches = 611;

/// Duration of the textbook's S-curve from rest to rest over `length`.
double s_curve_s(double length, double v, double a, double j) {
  const auto to_speed = [&](double speed) { return speed * j > a * a ? speed / a + a / j : 2 * std::sqrt(speed / j); };
  if (v * to_speed(v) <= length) return 2 * to_speed(v) + (length - v * to_speed(v)) / v;
  double low = 0, high = v;
  for (int n = 0; n < 200; ++n) {
    const double middle = (low + high) / 2;
    (middle * to_speed(middle) < length ? low : high) = middle;
  }
  return 2 * to_speed(low);
}

struct Random {
  std::mt19937_64 engine{kArches};
  double uniform(double low, double high) { return std::uniform_real_distribution<double>(low, high)(engine); }
  /// Up, across, down on the test machine: from hundredths of a mm to the whole travel; C turns along at times.
  ArchSpec spec() {
    ArchSpec s;
    const double across = std::pow(10.0, uniform(-2, 2.4)), heading = uniform(0, 6.3);
    s.from = {uniform(250, 350), uniform(230, 270), uniform(-110, -40), uniform(-1, 1), 12};
    s.to = s.from;
    s.to[0] += across * std::cos(heading), s.to[1] += across * std::sin(heading);
    if (uniform(0, 1) < 0.3) s.to[3] += uniform(-0.5, 0.5);
    s.to[kZ] += uniform(0, 1) < 0.3 ? 0 : uniform(-5, 5);
    s.up = kZ;
    s.top = std::max(s.from[kZ], s.to[kZ]) + (uniform(0, 1) < 0.1 ? 0 : std::pow(10.0, uniform(-1.5, 1.5)));
    s.leave_mm = uniform(0, 1.2) * (s.top - s.from[kZ]);
    s.arrive_mm = uniform(0, 1.2) * (s.top - s.to[kZ]);
    return s;
  }
};

AxisVec at_height(AxisVec q, double z) {
  q[kZ] = z;
  return q;
}

double legs_s(const Limits& m, const ArchSpec& s) {
  double sum = 0;
  const AxisVec a = at_height(s.from, s.top), b = at_height(s.to, s.top);
  for (const auto& [from, to] : {std::pair(s.from, a), std::pair(a, b), std::pair(b, s.to)})
    sum += duration(line_move(m, from, to));
  return sum;
}

TEST(Arch, keeps_every_axis_within_its_limits_and_goes_from_rest_to_rest_in_whole_ticks) {
  const Limits m = machine();
  Random random;
  double jerk = 0;
  for (int n = 0; n < 4000; ++n) {
    const ArchSpec s = random.spec();
    const Arch a = arch(m, s);
    ASSERT_FALSE(a.segments.empty());
    const double ticks = duration(a.segments) / m.tick_s;
    ASSERT_NEAR(ticks, std::round(ticks), 1e-7) << n;
    ASSERT_LE(duration(a.segments), legs_s(m, s) + 1e-9) << n;
    std::vector<AxisVec> q = sampled(a.segments, 2.5e-4);
    const Geometry& last = a.segments.back().geometry;
    for (std::size_t i = 0; i < m.axes; ++i) {
      ASSERT_NEAR(q.front()[i], s.from[i], 1e-12) << n;
      ASSERT_NEAR(point(last, last.length)[i], s.to[i], 1e-9) << n;
    }
    q.insert(q.begin(), 4, s.from);
    q.insert(q.end(), 4, s.to);
    const test::Use use = limit_use(m, q, 2.5e-4);
    ASSERT_LE(std::max({use.v, use.a, use.j}), 1 + 1e-5) << "arch " << n << " seed " << kArches;
    jerk = std::max(jerk, use.j);
  }
  EXPECT_GT(jerk, 0.99);
}

TEST(Arch, goes_straight_across_at_its_top_and_moves_nothing_else_near_its_ends) {
  const Limits m = machine();
  Random random;
  for (int n = 0; n < 2000; ++n) {
    const ArchSpec s = random.spec();
    const std::vector<AxisVec> q = sampled(arch(m, s).segments, m.tick_s / 2);
    double highest = -1e9, last = 0;
    bool falls = false;
    for (std::size_t k = 0; k < q.size(); ++k) {
      double ab = 0, on = 0;
      for (const std::size_t i : {0u, 1u, 3u})
        ab += std::pow(s.to[i] - s.from[i], 2), on += (q[k][i] - s.from[i]) * (s.to[i] - s.from[i]);
      const double share = on / ab;
      for (const std::size_t i : {0u, 1u, 3u})
        ASSERT_NEAR(q[k][i], s.from[i] + share * (s.to[i] - s.from[i]), 1e-9) << n;
      ASSERT_EQ(q[k][4], s.from[4]);
      ASSERT_GE(share, last - 1e-10) << "never back, arch " << n;
      last = share;
      ASSERT_LE(q[k][kZ], s.top + 1e-9);
      if (k > 0 && q[k][kZ] < q[k - 1][kZ] - 1e-10) falls = true;
      if (falls) {
        ASSERT_LE(q[k][kZ], q[k - 1][kZ] + 1e-10) << "up again, arch " << n;
      }
      highest = std::max(highest, q[k][kZ]);
      const double moved = std::sqrt(ab);
      if (q[k][kZ] < std::min(s.from[kZ] + s.leave_mm, s.top) - 1e-9 && !falls) {
        ASSERT_NEAR(share * moved, 0, 1e-9) << n;
      }
      if (q[k][kZ] < std::min(s.to[kZ] + s.arrive_mm, s.top) - 1e-9 && falls) {
        ASSERT_NEAR((1 - share) * moved, 0, 1e-9) << n;
      }
    }
    ASSERT_NEAR(highest, s.top, 0.05 * (s.top - std::min(s.from[kZ], s.to[kZ])) + 1e-9);
  }
}

TEST(Arch, takes_what_the_textbook_says_for_the_overlap_that_is_allowed) {
  Limits m = machine();
  for (const double up : {1.0, 3.0, 12.0})
    for (const double across : {4.0, 20.0, 150.0})
      for (const double alone : {0.5, 0.8, 1.0}) {
        ArchSpec s{.from = {100, 100, -90, 0, 12}, .up = kZ, .leave_mm = alone * up, .arrive_mm = alone * up};
        s.to = s.from, s.to[0] += across, s.top = -90 + up;
        const AxisLimits &x = m.axis[0], &z = m.axis[kZ];
        const double across_s = s_curve_s(across, x.v_max, x.a_max, x.j_max),
                     up_s = s_curve_s(up, z.v_max, z.a_max, z.j_max);
        const double is_s = duration(arch(m, s).segments);
        if (alone == 1.0) {
          EXPECT_NEAR(is_s, 2 * up_s + across_s, 3.5 * m.tick_s);
        } else if (alone == 0.5) {  // half of the distance takes half of the time
          EXPECT_NEAR(is_s, std::max(2 * up_s, up_s + across_s), 5 * m.tick_s) << up << " mm, " << across << " mm";
        }
      }
}

TEST(Arch, pieces_join_and_their_chords_are_as_near_as_they_say) {
  const Limits m = machine();
  Random random;
  for (int n = 0; n < 300; ++n) {
    const ArchSpec s = random.spec();
    const Arch a = arch(m, s);
    for (std::size_t k = 0; k < a.segments.size(); ++k) {
      const Segment& piece = a.segments[k];
      ASSERT_EQ(piece.kind, SegmentKind::Piece);
      ASSERT_EQ(piece.rests, k + 1 == a.segments.size());
      ASSERT_NEAR(static_cast<double>(test::path_state(piece, test::duration_of(piece)).s), piece.geometry.length,
                  1e-9);
      if (k == 0) continue;
      const AxisVec end = point(a.segments[k - 1].geometry, a.segments[k - 1].geometry.length);
      for (std::size_t i = 0; i < m.axes; ++i) ASSERT_NEAR(point(piece.geometry, 0)[i], end[i], 1e-9) << n;
    }
    for (std::size_t k = 0; k < a.up; ++k) ASSERT_EQ(a.segments[k].geometry.moving, 1u << kZ);
    for (std::size_t k = 0; k < a.down; ++k) ASSERT_EQ(a.segments[a.segments.size() - 1 - k].geometry.moving, 1u << kZ);
    const std::vector<AxisVec> line = chords(a.segments);
    for (const AxisVec& q : sampled(a.segments, 3e-4))
      ASSERT_LE(test::distance_to_polyline(q, line), kChord_mm + 1e-9) << n;
  }
}

TEST(ArchOver, is_found_in_what_goes_up_across_and_down_and_in_nothing_else) {
  const AxisVec a{0, 0, -50}, b{0, 0, -47}, c{4, 0, -46.9}, d{4, 0, -50}, high{0, 0, -40}, over{4, 0, -40};
  const auto found = [](std::vector<AxisVec> points) { return arch_over(points, kZ); };
  ASSERT_TRUE(found({a, b, c, d}));
  EXPECT_EQ(found({a, b, c, d})->top, -46.9) << "level at the higher end";
  EXPECT_EQ(found({a, b, b, high, over, c, c, d})->top, -40) << "up in two steps, down in two";
  EXPECT_TRUE(found({a, b, c})) << "up and across";
  EXPECT_TRUE(found({b, c, d})) << "across and down";
  EXPECT_FALSE(found({a, b})) << "nothing across";
  EXPECT_FALSE(found({b, AxisVec{4, 0, -47}})) << "nothing up or down";
  EXPECT_FALSE(found({a, b, c, over, AxisVec{8, 0, -40}})) << "across twice";
  EXPECT_FALSE(found({b, a, d})) << "down first";
  EXPECT_FALSE(found({a, b, c, over})) << "up at the end";
}

}  // namespace
}  // namespace gantry::motion
