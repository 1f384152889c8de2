// What is left of a bead that was cut, against the whole bead: the same places at the same lengths, the same limits,
// and a run-up that comes down onto it.
#include "motion/path/rejoin.hpp"

#include <gtest/gtest.h>
#include <numbers>

#include "motion/path/sound.hpp"
#include "tests/motion/machine.hpp"
#include "tests/motion/path/a_bead.hpp"
#include "tests/motion/path/sampled.hpp"

namespace gantry::motion {
namespace {

using test::at;
using test::limit_use;
using test::machine;
using test::path_state;

constexpr std::size_t kZ = 2;
constexpr double kLift_mm = 0.6;

/// Of which a part may lie already.
BeadSpec cut_bead(std::vector<AxisVec> points, double speed, double tolerance) {
  BeadSpec s = test::spec_of(std::move(points), speed, tolerance);
  s.lift_mm = kLift_mm, s.lift_axis = kZ;
  return s;
}

/// Where the bead is, so far along it.
AxisVec place(const BeadMotion& bead, double s) {
  std::size_t k = bead.bead_begin;
  for (; k + 1 < bead.bead_end && s > bead.segments[k].geometry.length; ++k) s -= bead.segments[k].geometry.length;
  return point(bead.segments[k].geometry, s);
}

/// How far along the bead the tool is, so long after it began.
double length_at(const BeadMotion& bead, double t) {
  double s = 0;
  std::size_t k = bead.bead_begin;
  for (; t > test::duration_of(bead.segments[k]); ++k)
    t -= static_cast<double>(test::duration_of(bead.segments[k])), s += bead.segments[k].geometry.length;
  return s + static_cast<double>(path_state(bead.segments[k], t).s);
}

/// Of what X, Y and Z go.
double length(const AxisVec& q) { return std::hypot(q[0], q[1], q[2]); }

double seconds(const BeadMotion& bead, std::size_t from, std::size_t to) {
  long double t = 0;
  for (std::size_t k = from; k < to; ++k) t += test::duration_of(bead.segments[k]);
  return static_cast<double>(t);
}

void check(const Limits& m, const BeadMotion& whole, const BeadMotion& left, double begin_mm, const std::string& what,
           double lift_mm = kLift_mm) {
  // What is left is the bead's own.
  ASSERT_NEAR(left.bead_length_mm, whole.bead_length_mm - begin_mm, 1e-6) << what;
  for (int n = 0; n <= 50; ++n) {
    const double s = left.bead_length_mm * n / 50;
    const AxisVec a = place(whole, begin_mm + s), b = place(left, s);
    for (std::size_t i = 0; i < m.axes; ++i) ASSERT_NEAR(a[i], b[i], 2e-4) << "axis " << i << " at " << s << what;
  }
  // It goes on from piece to piece, and from the run-up into the bead.
  AxisVec end = left.start;
  test::PathState last;
  for (std::size_t k = 0; k < left.segments.size(); ++k) {
    const Segment& s = left.segments[k];
    const bool rested = k == 0 || left.segments[k - 1].rests;
    const double v0 = s.nominal.v0, v1 = static_cast<double>(last.v), a1 = static_cast<double>(last.a);
    // Where it is joined within a curve s is length but for 2e-4: there the axes' own motion goes on, and it
    // everywhere.
    if (k != left.bead_begin) {
      ASSERT_NEAR(v0, v1, 1e-6 * (1 + s.v_cap)) << k << what;
      ASSERT_NEAR(s.nominal.a0, a1, 1e-2) << k << what;
    }
    for (std::size_t i = 0; i < m.axes; ++i) {
      ASSERT_NEAR(point(s.geometry, 0)[i], end[i], 1e-9) << k << what;
      if (rested) continue;
      const Geometry& before = left.segments[k - 1].geometry;
      const AxisVec begins = derivative<1>(s.geometry, 0), ended = derivative<1>(before, before.length);
      const double d1 = begins[i], d2 = derivative<2>(s.geometry, 0)[i], e1 = ended[i],
                   e2 = derivative<2>(before, before.length)[i];
      ASSERT_NEAR(d1 / length(begins), e1 / length(ended), 1e-6) << k << what;
      ASSERT_LE(std::abs(d2 - e2) * v0 * v0, 2e-3 * m.axis[i].a_max) << k << what;
      ASSERT_NEAR(d1 * v0, e1 * v1, 1e-6 * (1 + s.v_cap)) << "axis " << i << " segment " << k << what;
      ASSERT_NEAR(d2 * v0 * v0 + d1 * s.nominal.a0, e2 * v1 * v1 + e1 * a1, 1e-5 * m.axis[i].a_max)
          << "axis " << i << " segment " << k << " of " << left.bead_begin << " before the bead" << what;
    }
    last = path_state(s, 1e9);
    ASSERT_NEAR(static_cast<double>(last.s), s.geometry.length, 1e-8) << k << what;
    if (s.rests) last = {};
    end = point(s.geometry, s.geometry.length);
    for (int n = 0; n <= 20; ++n)
      ASSERT_GE(static_cast<double>(path_state(s, test::duration_of(s) * n / 20).v), -1e-9) << k << what;
  }
  for (const double t : {seconds(left, 0, left.bead_begin), seconds(left, left.bead_begin, left.bead_end)})
    ASSERT_NEAR(t / m.tick_s, std::round(t / m.tick_s), 1e-6) << what;
  const test::Use use = limit_use(m, test::sampled(left.segments, 2.5e-4), 2.5e-4);
  ASSERT_LE(use.v, 1 + 1e-6) << what;
  ASSERT_LE(use.a, 1 + 1e-3) << what;
  ASSERT_LE(use.j, 1 + 1e-2) << what;
  const auto all = std::span(left.segments);
  ASSERT_EQ(unsound(m, all, all.subspan(left.bead_begin, left.bead_end - left.bead_begin)).value_or(""), "") << what;
  // Down onto it: never below the bead that lies there already, and at its height only where it ends.
  const AxisVec join = place(left, 0);
  double above = left.start[kZ] - join[kZ];
  ASSERT_NEAR(above, lift_mm, 1e-9) << what;
  for (std::size_t k = 0; k < left.bead_begin; ++k)
    for (int n = 0; n <= 10; ++n) {
      const Geometry& g = left.segments[k].geometry;
      above = std::min(above, point(g, g.length * n / 10)[kZ] - join[kZ]);
    }
  ASSERT_GE(above, -1e-9) << what;
}

void expect_any_bead_is_joined(unsigned seed, int cases) {
  const Limits m = machine();
  std::mt19937_64 random(seed);
  int planned = 0, refused = 0, beads = 0;
  for (int n = 0; n < cases; ++n) {
    const auto uniform = [&](double lo, double hi) { return std::uniform_real_distribution<double>(lo, hi)(random); };
    const double tolerance = uniform(0, 1) < 0.25 ? 0 : std::pow(10.0, uniform(-2.5, 0.3));
    BeadSpec spec = cut_bead(test::random_polyline(random), std::pow(10.0, uniform(0.5, 2.3)), tolerance);
    for (AxisVec& p : spec.points) p[kZ] = -50;
    const auto whole = plan_bead(m, spec);
    if (!whole) continue;
    ++beads;
    for (int c = 0; c < 4; ++c) {
      const double begin_mm = whole->bead_length_mm * uniform(0.01, 0.99);
      spec.begin_mm = begin_mm;
      const auto left = plan_bead(m, spec);
      const std::string what = " case " + std::to_string(n) + " cut at " + std::to_string(begin_mm) + " of " +
                               std::to_string(whole->bead_length_mm) + " speed " + std::to_string(spec.speed_mm_s) +
                               " tolerance " + std::to_string(tolerance) + " " + test::text(spec.points);
      if (!left) {
        ++refused;
        continue;
      }
      ++planned;
      check(m, *whole, *left, begin_mm, what);
      if (testing::Test::HasFatalFailure()) return;
    }
    spec.begin_mm = 0;
  }
  EXPECT_GT(beads, 40);
  EXPECT_LT(50 * refused, planned);  // in bends where the bead itself is at its limits
}

TEST(Rejoin, what_is_left_of_any_bead_is_that_bead) {
  expect_any_bead_is_joined(23, 60);
  if (!HasFatalFailure()) expect_any_bead_is_joined(101, 130);
}

TEST(Rejoin, a_straight_bead_is_come_to_over_itself) {
  const Limits m = machine();
  BeadSpec spec = cut_bead({at(100, 100), at(160, 100)}, 20, 0);
  spec.begin_mm = 25;
  const auto left = plan_bead(m, spec);
  ASSERT_TRUE(left) << left.error().message;
  EXPECT_NEAR(left->start[kZ], -50 + kLift_mm, 1e-9);
  EXPECT_EQ(left->start[1], 100);
  EXPECT_LT(left->start[0], 125 - 3);
  EXPECT_NEAR(place(*left, 0)[0], 125, 1e-9);
  EXPECT_NEAR(left->segments[left->bead_begin].nominal.v0, 20, 0.02 * 20);
  EXPECT_TRUE(left->segments[left->bead_begin].events[0].dispense);
}

// On slow axes the tool brakes over much of a leg, as hard as it may. A bead is cut at a cycle, so that what is left
// takes whole ones, and is joined at the speed that it had, which may be more by what makes the bead take whole ones.
TEST(Rejoin, a_leg_on_which_the_tool_brakes_to_a_rest_is_joined_anywhere) {
  std::mt19937_64 random(31);
  const auto uniform = [&](double lo, double hi) { return std::uniform_real_distribution<double>(lo, hi)(random); };
  for (int n = 0; n < 150; ++n) {
    Limits m = machine();
    const double a = uniform(20, 120);
    for (std::size_t i : {0u, 1u}) m.axis[i].a_max = a, m.axis[i].j_max = 5 * a;
    const double turn = uniform(0, 2 * std::numbers::pi);
    const AxisVec corner = at(250 + 25 * std::cos(turn), 200 + 25 * std::sin(turn));
    BeadSpec spec = cut_bead({at(250, 200), corner, at(corner[0] + 3, corner[1] + 20)}, 0.6 * std::sqrt(25 * a), 0);
    const auto whole = plan_bead(m, spec);
    ASSERT_TRUE(whole) << whole.error().message;
    for (double t = uniform(0.3, 0.5); length_at(*whole, t) < 24.5; t += 0.1) {
      const double begin_mm = length_at(*whole, std::round(t / m.tick_s) * m.tick_s);
      spec.begin_mm = begin_mm;
      const auto left = plan_bead(m, spec);
      ASSERT_TRUE(left) << a << " mm/s^2, cut at " << begin_mm << ": " << left.error().message;
      check(m, *whole, *left, begin_mm, " cut at " + std::to_string(begin_mm));
      if (HasFatalFailure()) return;
    }
  }
}

/// The textbook's length from rest to v along the direction in which it goes there.
double speed_up_mm(const Limits& m, const AxisVec& direction, double v) {
  double a = 1e9, j = 1e9;
  for (std::size_t i = 0; i < m.axes; ++i)
    if (const double d = std::abs(direction[i]); d > 0)
      a = std::min(a, 0.97 * m.axis[i].a_max / d), j = std::min(j, 0.98 * m.axis[i].j_max / d);
  return v < a * a / j ? v * std::sqrt(v / j) : v / 2 * (v / a + a / j);
}

TEST(Rejoin, any_bead_may_be_joined_more_slowly_after_a_run_up_that_is_so_much_shorter) {
  const Limits m = machine();
  std::mt19937_64 random(29);
  const auto uniform = [&](double lo, double hi) { return std::uniform_real_distribution<double>(lo, hi)(random); };
  int planned = 0, refused = 0, from_rest = 0;
  for (int n = 0; n < 40; ++n) {
    const double tolerance = uniform(0, 1) < 0.25 ? 0 : std::pow(10.0, uniform(-2.5, 0.3));
    BeadSpec spec = cut_bead(test::random_polyline(random), std::pow(10.0, uniform(0.5, 2.3)), tolerance);
    for (AxisVec& p : spec.points) p[kZ] = -50;
    const auto whole = plan_bead(m, spec);
    if (!whole) continue;
    spec.begin_mm = whole->bead_length_mm * uniform(0.01, 0.99);
    spec.entry_mm_s = uniform(0, 1) < 0.3 ? 0 : spec.speed_mm_s * uniform(0.05, 1);
    const std::string what = " case " + std::to_string(n) + " cut at " + std::to_string(spec.begin_mm) + " of " +
                             std::to_string(whole->bead_length_mm) + " speed " + std::to_string(spec.speed_mm_s) +
                             " entry " + std::to_string(spec.entry_mm_s) + " tolerance " + std::to_string(tolerance) +
                             " " + test::text(spec.points);
    const auto left = plan_bead(m, spec);
    if (!left) {
      ++refused;
      continue;
    }
    ++planned;
    const AxisVec direction = derivative<1>(left->segments[left->bead_begin].geometry, 0);
    const double length_mm = spec.entry_mm_s > 0 ? speed_up_mm(m, direction, spec.entry_mm_s) : 0;
    check(m, *whole, *left, spec.begin_mm, what, std::min(kLift_mm, length_mm / 10));
    if (HasFatalFailure()) return;
    const double entry = left->segments[left->bead_begin].nominal.v0;
    if (spec.entry_mm_s > 0) {
      ASSERT_LE(left->run_up_mm, 1.15 * length_mm) << what;  // bent over a radius, and along a slope of up to 0.3
      ASSERT_GE(left->run_up_mm, length_mm) << what;
    } else {
      ++from_rest;
      ASSERT_EQ(entry, 0) << what;
      ASSERT_EQ(left->bead_begin, 0u) << what;
    }
  }
  EXPECT_GT(planned, 25);
  EXPECT_GT(from_rest, 5);
  EXPECT_EQ(refused, 0);
}

TEST(Rejoin, a_straight_bead_is_joined_at_the_speed_that_a_shorter_run_up_comes_to) {
  const Limits m = machine();
  BeadSpec spec = cut_bead({at(100, 100), at(160, 100)}, 20, 0);
  spec.begin_mm = 25, spec.entry_mm_s = 8;
  const auto left = plan_bead(m, spec);
  ASSERT_TRUE(left) << left.error().message;
  EXPECT_GE(left->segments[left->bead_begin].nominal.v0, 8 * 0.98);
  EXPECT_LE(left->segments[left->bead_begin].nominal.v0, 8 * 1.66);  // of full jerk all along: the cube root of 9/2
  EXPECT_NEAR(125 - left->start[0], speed_up_mm(m, {1, 0, 0}, 8), 1e-6);
  double fastest = 0;
  for (std::size_t k = left->bead_begin; k < left->bead_end; ++k)
    for (int n = 0; n <= 20; ++n)
      fastest = std::max(
          fastest, static_cast<double>(path_state(left->segments[k], test::duration_of(left->segments[k]) * n / 20).v));
  EXPECT_NEAR(fastest, 20, 0.02 * 20);
}

/// A whole bead may be played faster than planned by 2e-4, which its plan leaves of the axes' speed; what is left of
/// one may not be once more. Lines with a rest between them, at the speed of X: the second is the one that was planned.
TEST(Rejoin, what_is_left_takes_no_axis_beyond_its_speed) {
  constexpr double kFastest_mm_s = 60;
  Limits m = machine();
  m.axis[0].v_max = kFastest_mm_s;
  double most = 0;
  int joined = 0;
  for (int n = 0; n < 400; ++n) {
    BeadSpec spec = cut_bead({at(100, 100), at(107, 100), at(100 + 0.0003 * n, 100)}, 400, 0);
    for (int c = 0; c < 10; ++c) {
      spec.begin_mm = 1 + 0.37 * c;
      const auto left = plan_bead(m, spec);
      ASSERT_TRUE(left) << left.error().message;
      ++joined;
      for (std::size_t k = left->bead_begin; k < left->bead_end; ++k) {
        const Segment& s = left->segments[k];
        double t = 0;
        for (const Phase& phase : s.nominal.phases)  // constant speed, or its ends are the extremes
          most = std::max(most, std::abs(static_cast<double>(path_state(s, t += phase.duration_s).v)));
      }
    }
  }
  EXPECT_EQ(joined, 4000);
  EXPECT_GT(most, kFastest_mm_s * (1 - 5e-5));
  EXPECT_LE(most, kFastest_mm_s * (1 + 1e-9));
}

TEST(Rejoin, nothing_is_left_behind_the_end) {
  BeadSpec spec = cut_bead({at(100, 100), at(160, 100)}, 20, 0);
  spec.begin_mm = 60;
  const auto left = plan_bead(machine(), spec);
  ASSERT_FALSE(left);
  EXPECT_EQ(left.error().message, "nothing of the bead is left");
}

}  // namespace
}  // namespace gantry::motion
