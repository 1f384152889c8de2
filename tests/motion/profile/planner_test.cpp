#include "motion/profile/planner.hpp"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <random>

#include "tests/motion/profile/judge.hpp"

namespace gantry::motion {
namespace {

constexpr unsigned kSeed = 20240611;

struct Case {
  State from, to;
  Bounds b;
};

struct OneSidedCase {
  State from, to;
  AxisBounds b;
};

std::string text(const OneSidedCase& c) {
  char line[500];
  std::snprintf(line, sizeof line,
                "{%.17g, %.17g, %.17g} -> {%.17g, %.17g, %.17g}, v %.17g %.17g a %.17g %.17g j %.17g %.17g", c.from.p,
                c.from.v, c.from.a, c.to.p, c.to.v, c.to.a, c.b.v_max, c.b.v_min, c.b.a_max, c.b.a_min, c.b.j_max,
                c.b.j_min);
  return line;
}

/// States and bounds as the field draws them (issue: p ~ N(0, 4), v, a ~ N(0, 0.8), each often 0, bounds U(0.08, 16)),
/// rejected until both ends are within what bounds allow.
class Cases {
 public:
  explicit Cases(unsigned seed) : random_(seed) {}
  Case next() {
    for (;;) {
      Case c;
      c.b = {bound_(random_), bound_(random_), bound_(random_)};
      c.from = {4 * normal_(random_), some(0.8), some(0.8)};
      c.to = {4 * normal_(random_), some(0.8), some(0.8)};
      if (judge::tenable(c.from, c.b, 1) && judge::tenable(c.to, c.b, -1)) return c;
    }
  }
  /// Each bound with a minimum of its own.
  OneSidedCase next_one_sided() {
    for (;;) {
      OneSidedCase c;
      c.b = AxisBounds(bound_(random_), -bound_(random_), bound_(random_), -bound_(random_), bound_(random_),
                       -bound_(random_));
      c.from = {4 * normal_(random_), some(0.8), some(0.8)};
      c.to = {4 * normal_(random_), some(0.8), some(0.8)};
      if (judge::tenable(c.from, c.b, 1) && judge::tenable(c.to, c.b, -1)) return c;
    }
  }
  double uniform(double lo, double hi) { return std::uniform_real_distribution<double>(lo, hi)(random_); }

 private:
  double some(double sigma) { return unit_(random_) < 0.25 ? 0.0 : sigma * normal_(random_); }
  std::mt19937_64 random_;
  std::normal_distribution<double> normal_;
  std::uniform_real_distribution<double> unit_{0, 1}, bound_{0.08, 16};
};

std::string text(const Case& c) {
  char line[400];
  std::snprintf(line, sizeof line, "{%.17g, %.17g, %.17g} -> {%.17g, %.17g, %.17g}, bounds {%.17g, %.17g, %.17g}",
                c.from.p, c.from.v, c.from.a, c.to.p, c.to.v, c.to.a, c.b.v, c.b.a, c.b.j);
  return line;
}

TEST(Planner, every_profile_reaches_its_target_within_the_bounds) {
  Cases cases(kSeed);
  for (int i = 0; i < 300000; ++i) {
    const Case c = cases.next();
    const Plan plan = move(c.from, c.to, c.b);
    ASSERT_TRUE(plan) << name(plan.reason) << " case " << i << " seed " << kSeed << " " << text(c);
    ASSERT_EQ(judge::verdict(plan.profile, c.from, c.to, c.b), "")
        << "case " << i << " seed " << kSeed << " " << text(c);
  }
}

TEST(Planner, no_search_on_switching_times_finds_a_shorter_profile) {
  Cases cases(kSeed + 1);
  int judged = 0;
  for (int i = 0; i < 250; ++i) {
    Case c = cases.next();
    if (i % 2) {  // close ends, where no bound is reached and several profiles compete
      c.to.p = c.from.p + cases.uniform(-0.5, 0.5);
      c.b.v = 16;
    }
    const Plan plan = move(c.from, c.to, c.b);
    ASSERT_TRUE(plan) << text(c);
    const double found = static_cast<double>(judge::Search(c.from, c.to, c.b, 160).shortest());
    if (!std::isfinite(found)) continue;
    ++judged;
    ASSERT_LE(duration(plan.profile), found * (1 + 1e-9) + 1e-9)
        << "case " << i << " seed " << kSeed + 1 << " " << text(c);
  }
  EXPECT_GT(judged, 200);
}

// A motion drawn at random within the bounds is a witness: whatever its end state is, it was reached in its time.
TEST(Planner, no_random_motion_within_the_bounds_is_faster) {
  Cases cases(kSeed + 2);
  int tight = 0;
  for (int i = 0; i < 300000; ++i) {
    Case c = cases.next();
    Profile witness{c.from, {}};
    double sign = cases.uniform(0, 1) < 0.5 ? 1 : -1;
    const int ramps = 1 + static_cast<int>(cases.uniform(0, 3.99));
    const double pace = std::pow(10.0, cases.uniform(-2, 0.5));
    for (int k = 0; k < ramps; ++k, sign = -sign) {
      State x = end_state(witness);
      const double free = std::max((c.b.a - sign * x.a) / c.b.j, 0.0);
      const double t = cases.uniform(0, pace);
      witness.phases.push_back({std::min(t, free), sign * c.b.j});
      if (t > free) witness.phases.push_back({t - free, 0});
    }
    const judge::Integrated x = judge::integrate(witness);
    c.to = end_state(witness);
    if (x.v_top > c.b.v || x.a_top > c.b.a * (1 + 1e-12) || !judge::tenable(c.to, c.b, -1)) continue;
    const Plan plan = move(c.from, c.to, c.b);
    ASSERT_TRUE(plan) << text(c);
    ASSERT_EQ(judge::verdict(plan.profile, c.from, c.to, c.b), "") << text(c);
    const double allowed = static_cast<double>(x.duration);
    // Where speeds vanish at the end, a position error e costs (e / j)^(1/3): compare what the end tolerance is worth.
    ASSERT_LE(duration(plan.profile), allowed * (1 + 1e-7) + 1e-7)
        << "case " << i << " seed " << kSeed + 2 << " " << text(c);
    tight += duration(plan.profile) > allowed * (1 - 1e-7);
  }
  EXPECT_GT(tight, 10000) << "the witnesses should often be optimal themselves";
}

TEST(OneSided, every_profile_reaches_its_target_within_the_bounds) {
  Cases cases(kSeed + 8);
  for (int i = 0; i < 300000; ++i) {
    const OneSidedCase c = cases.next_one_sided();
    const Plan plan = move(c.from, c.to, c.b);
    ASSERT_TRUE(plan) << name(plan.reason) << " case " << i << " " << text(c);
    ASSERT_EQ(judge::verdict(plan.profile, c.from, c.to, c.b), "") << "case " << i << " " << text(c);
  }
}

TEST(OneSided, no_search_on_switching_times_finds_a_shorter_profile) {
  Cases cases(kSeed + 9);
  int judged = 0;
  for (int i = 0; i < 250; ++i) {
    OneSidedCase c = cases.next_one_sided();
    if (i % 2) c.to.p = c.from.p + cases.uniform(-0.5, 0.5);
    const Plan plan = move(c.from, c.to, c.b);
    ASSERT_TRUE(plan) << text(c);
    const double found = static_cast<double>(judge::Search(c.from, c.to, c.b, 160).shortest());
    if (!std::isfinite(found)) continue;
    ++judged;
    ASSERT_LE(duration(plan.profile), found * (1 + 1e-9) + 1e-9) << "case " << i << " " << text(c);
  }
  EXPECT_GT(judged, 200);
}

TEST(OneSided, no_random_motion_within_the_bounds_is_faster) {
  Cases cases(kSeed + 10);
  int tight = 0;
  for (int i = 0; i < 300000; ++i) {
    OneSidedCase c = cases.next_one_sided();
    Profile witness{c.from, {}};
    double sign = cases.uniform(0, 1) < 0.5 ? 1 : -1;
    const int ramps = 1 + static_cast<int>(cases.uniform(0, 3.99));
    const double pace = std::pow(10.0, cases.uniform(-2, 0.5));
    for (int k = 0; k < ramps; ++k, sign = -sign) {
      const State x = end_state(witness);
      const double jerk = sign > 0 ? c.b.j_max : c.b.j_min, bound = sign > 0 ? c.b.a_max : c.b.a_min;
      const double free = std::max((bound - x.a) / jerk, 0.0), t = cases.uniform(0, pace);
      witness.phases.push_back({std::min(t, free), jerk});
      if (t > free) witness.phases.push_back({t - free, 0});
    }
    c.to = end_state(witness);
    const judge::Integrated x = judge::integrate(witness);
    if (x.v_high > c.b.v_max || x.v_low < c.b.v_min || !judge::tenable(c.to, c.b, -1)) continue;
    const Plan plan = move(c.from, c.to, c.b);
    ASSERT_TRUE(plan) << text(c);
    ASSERT_EQ(judge::verdict(plan.profile, c.from, c.to, c.b), "") << text(c);
    const double allowed = static_cast<double>(x.duration);
    ASSERT_LE(duration(plan.profile), allowed * (1 + 1e-7) + 1e-7) << "case " << i << " " << text(c);
    tight += duration(plan.profile) > allowed * (1 - 1e-7);
  }
  EXPECT_GT(tight, 10000);
}

TEST(Planner, durations_do_not_depend_on_the_unit_of_length) {
  Cases cases(kSeed + 3);
  for (int i = 0; i < 100000; ++i) {
    const Case c = cases.next();
    const double reference = duration(move(c.from, c.to, c.b).profile);
    for (const double unit : {1e3, 1e6, 1e-6}) {
      const auto scaled = [unit](const State& x) { return State{x.p * unit, x.v * unit, x.a * unit}; };
      const Plan plan = move(scaled(c.from), scaled(c.to), {c.b.v * unit, c.b.a * unit, c.b.j * unit});
      ASSERT_TRUE(plan) << name(plan.reason) << text(c);
      ASSERT_NEAR(duration(plan.profile), reference, 1e-9 * reference) << "unit " << unit << " " << text(c);
    }
  }
}

TEST(Planner, a_target_within_rounding_of_the_state_takes_no_time) {
  Cases cases(kSeed + 4);
  for (int i = 0; i < 100000; ++i) {
    Case c = cases.next();
    c.to = c.from;
    if (!judge::tenable(c.to, c.b, -1)) continue;
    c.to.p += cases.uniform(-4, 4) * 2.2e-16 * std::abs(c.to.p);
    c.to.v += cases.uniform(-4, 4) * 2.2e-16 * std::abs(c.to.v);
    const Plan plan = move(c.from, c.to, c.b);
    ASSERT_TRUE(plan) << text(c);
    ASSERT_LE(duration(plan.profile), 1e-9) << text(c);
  }
}

TEST(Planner, tiny_jerk_is_solved_like_any_other) {
  Cases cases(kSeed + 5);
  for (int i = 0; i < 100000; ++i) {
    Case c = cases.next();
    c.b.j = std::pow(10.0, cases.uniform(-3, -1.1));
    if (!judge::tenable(c.from, c.b, 1)) c.from.a = 0;
    if (!judge::tenable(c.to, c.b, -1)) c.to.a = 0;
    const Plan plan = move(c.from, c.to, c.b);
    ASSERT_TRUE(plan) << name(plan.reason) << " " << text(c);
    ASSERT_EQ(judge::verdict(plan.profile, c.from, c.to, c.b), "") << text(c);
    if (i % 1000) continue;
    const double found = static_cast<double>(judge::Search(c.from, c.to, c.b, 160).shortest());
    ASSERT_LE(duration(plan.profile), found * (1 + 1e-9) + 1e-9) << text(c);
  }
}

TEST(Planner, rest_to_rest_takes_the_textbook_time) {
  // s = 100, v 50, a 200, j 2000: all bounds are reached; T = s/v + v/a + a/j.
  EXPECT_NEAR(duration(move({0, 0, 0}, {100, 0, 0}, {50, 200, 2000}).profile), 100.0 / 50 + 50.0 / 200 + 200.0 / 2000,
              1e-12);
  // Nothing but jerk: T = 4 (s / (2 j))^(1/3).
  EXPECT_NEAR(duration(move({0, 0, 0}, {1, 0, 0}, {1e3, 1e3, 32}).profile), 4 * std::cbrt(1.0 / 64), 1e-12);
}

TEST(Planner, a_lowered_speed_bound_is_eased_to_without_undershoot) {
  // v_max 0.2 -> 0.1 m/s on the fly, a 3, j 50: the velocity interface needs 89.4 ms.
  const Bounds b{0.1, 3, 50};
  const Plan plan = move({0, 0.2, 0}, {1, 0.1, 0}, b);
  ASSERT_TRUE(plan);
  const judge::Integrated x = judge::integrate(plan.profile);
  EXPECT_GE(static_cast<double>(x.v_low), 0.1 * (1 - 1e-9));
  EXPECT_LE(std::abs(evaluate(plan.profile, 0.0895).v - 0.1), 1e-9);
  EXPECT_NEAR(static_cast<double>(x.p), 1, 1e-12);
}

// With several times the bound of acceleration and little jerk a start is carried 1e3 to 1e10 times as far as its ends
// lie apart: its end is as exact as any, or it is said that doubles do not carry it. As the field draws starts and
// bounds, all are solved.
TEST(Planner, a_start_far_outside_comes_to_its_target_exactly_or_is_refused) {
  std::mt19937_64 random(kSeed + 11);
  const auto uniform = [&](double lo, double hi) { return std::uniform_real_distribution<double>(lo, hi)(random); };
  const auto normal = [&](double s) { return std::normal_distribution<double>(0, s)(random); };
  int refused = 0;
  for (int n = 0; n < 40000; ++n) {
    const bool drawn = n < 20000;
    const Bounds b{uniform(0.08, 16), uniform(0.08, 16), drawn ? uniform(0.08, 16) : std::pow(10, uniform(-3, 1.2))};
    const State far{normal(4), b.v * uniform(-3, 3), b.a * uniform(-3, 3)};
    const State from = drawn ? State{normal(4), normal(0.8), normal(0.8)} : far;
    const State to{normal(4), b.v * uniform(-0.5, 0.5), 0};
    const Plan plan = move(from, to, b, n % 2 == 0 ? Outside::Ease : Outside::Soonest);
    const std::string what = text(OneSidedCase{from, to, b});
    const double scale = std::max({std::abs(from.p), std::abs(to.p), b.v * b.v / b.a});
    if (!plan) {
      ++refused;
      EXPECT_FALSE(drawn) << what;
      EXPECT_EQ(plan.reason, Reason::NoSolution) << what;
      // The speed that it comes to, and the time to come back from where that ends, spoil the digits of the end.
      const double peak = std::abs(from.v) + from.a * from.a / (2 * b.j);
      const double back_s = peak * (peak / b.a + std::sqrt(peak / b.j)) / b.v;
      EXPECT_GT(10 * std::numeric_limits<double>::epsilon() * peak * back_s, 1e-9 * scale) << what;
      continue;
    }
    const judge::Integrated end = judge::integrate(plan.profile);
    ASSERT_LE(std::abs(static_cast<double>(end.p - to.p)), 1e-9 * scale) << what;
    ASSERT_LE(std::abs(static_cast<double>(end.v - to.v)), 1e-9 * b.v) << what;
    ASSERT_LE(std::abs(static_cast<double>(end.a - to.a)), 1e-9 * b.a) << what;
  }
  EXPECT_LT(refused, 9000);
}

// Bounds up to 1e6 times apart: what is left of an acceleration that has ended may then matter more, over the long time
// at the lower speed bound, than where the motion was to end. Where all bounds lie within a factor of 100 it never
// does.
TEST(Planner, what_is_solved_is_right_however_far_the_bounds_lie_apart) {
  std::mt19937_64 random(kSeed + 12);
  const auto uniform = [&](double lo, double hi) { return std::uniform_real_distribution<double>(lo, hi)(random); };
  int refused = 0, cases = 0;
  for (int n = 0; n < 60000; ++n) {
    const double decades = n % 2 == 0 ? 3 : 1;
    const auto bound = [&] { return std::pow(10, uniform(-decades, decades)); };
    const OneSidedCase c{{uniform(-8, 8), 0, 0},
                         {uniform(-8, 8), 0, 0},
                         AxisBounds(bound(), -bound(), bound(), -bound(), bound(), -bound())};
    State from = c.from, to = c.to;
    if (n % 3 > 0) from.v = uniform(c.b.v_min, c.b.v_max), from.a = uniform(c.b.a_min, c.b.a_max);
    if (n % 5 > 1) to.v = uniform(c.b.v_min, c.b.v_max), to.a = n % 7 > 2 ? uniform(c.b.a_min, c.b.a_max) : 0;
    if (!judge::tenable(from, c.b, 1) || !judge::tenable(to, c.b, -1)) continue;
    ++cases;
    const std::string what = text({from, to, c.b});
    const Plan plan = move(from, to, c.b);
    if (plan) {
      ASSERT_EQ(judge::verdict(plan.profile, from, to, c.b), "") << what;
    } else {
      ++refused;
      ASSERT_EQ(plan.reason, Reason::NoSolution) << what;
      ASSERT_EQ(decades, 3) << what;
    }
  }
  EXPECT_GT(cases, 20000);
  EXPECT_LT(refused, cases / 10);
  RecordProperty("cases", cases);
  RecordProperty("refused", refused);
}

TEST(Planner, says_why_it_has_no_profile) {
  EXPECT_EQ(move({0, 0, 0}, {1, 0, 0}, {0, 1, 1}).reason, Reason::BadBounds);
  EXPECT_EQ(move({0, 0, 0}, {1, 0, 0}, {1, 1, -1}).reason, Reason::BadBounds);
  EXPECT_EQ(move({0, 0, 0}, {1, 2, 0}, {1, 1, 1}).reason, Reason::TargetOutsideBounds);
  EXPECT_EQ(move({0, 0, 0}, {1, 0, 2}, {1, 1, 1}).reason, Reason::TargetOutsideBounds);
  EXPECT_EQ(move({0, 0, 0}, {1, 0.9, -0.9}, {1, 1, 1}).reason, Reason::TargetOutsideBounds) << "was faster before";
  EXPECT_EQ(move({NAN, 0, 0}, {1, 0, 0}, {1, 1, 1}).reason, Reason::NotFinite);
  EXPECT_EQ(change_speed({0, 0, 0}, INFINITY, {1, 1, 1}).reason, Reason::NotFinite);
}

TEST(ChangeSpeed, ends_at_the_speed_without_acceleration_and_never_later_than_a_search) {
  Cases cases(kSeed + 6);
  for (int i = 0; i < 100000; ++i) {
    const Case c = cases.next();
    const double v_to = cases.uniform(-c.b.v, c.b.v);
    const Plan plan = change_speed(c.from, v_to, c.b);
    ASSERT_TRUE(plan);
    const judge::Integrated x = judge::integrate(plan.profile);
    ASSERT_NEAR(static_cast<double>(x.v), v_to, 1e-12 * c.b.v) << text(c);
    ASSERT_NEAR(static_cast<double>(x.a), 0, 1e-12 * c.b.a) << text(c);
    ASSERT_LE(x.a_top, c.b.a * (1 + 1e-12));
    // The change of speed is what move() does where its target happens to be where that ends.
    const Plan same = move(c.from, {static_cast<double>(x.p), v_to, 0}, c.b);
    ASSERT_TRUE(same);
    ASSERT_LE(duration(same.profile), static_cast<double>(x.duration) * (1 + 1e-9) + 1e-9) << text(c);
    ASSERT_GE(duration(same.profile), static_cast<double>(x.duration) * (1 - 1e-5) - 1e-5) << text(c);
  }
}

TEST(ChangeSpeed, comes_back_from_beyond_the_acceleration_bound) {
  const Plan plan = stop({0, 3, 5}, {10, 2, 10});
  ASSERT_TRUE(plan);
  const judge::Integrated x = judge::integrate(plan.profile);
  EXPECT_NEAR(static_cast<double>(x.v), 0, 1e-12);
  EXPECT_NEAR(static_cast<double>(x.a), 0, 1e-12);
  EXPECT_EQ(x.j_top, 10);
}

TEST(SpeedOverLength, is_the_inverse_of_the_length_of_a_change) {
  Cases cases(kSeed + 7);
  for (int i = 0; i < 100000; ++i) {
    const double v = cases.uniform(0, 1) < 0.2 ? 0 : std::pow(10.0, cases.uniform(-4, 3));
    const Bounds b{1e9, std::pow(10.0, cases.uniform(0, 4)), std::pow(10.0, cases.uniform(1, 6))};
    const double length = std::pow(10.0, cases.uniform(-5, 3));
    const double top = speed_over_length(v, length, b);
    ASSERT_GE(top, v);
    if (top - v < 1e-6 * v) continue;  // the sum has lost the change
    ASSERT_NEAR(change_length(v, top, b.a, b.j), length, 1e-8 * length);
    // ... and the length is that of the profile.
    const Plan plan = change_speed({0, v, 0}, top, b);
    ASSERT_NEAR(static_cast<double>(judge::integrate(plan.profile).p), length, 1e-6 * length + 1e-9);
  }
}

TEST(Profile, stretched_takes_longer_on_the_same_path) {
  const Plan plan = move({0, 0, 0}, {37, 0, 0}, {50, 300, 5000});
  const Profile slow = stretched(plan.profile, 1.25);
  EXPECT_NEAR(duration(slow), 1.25 * duration(plan.profile), 1e-12);
  for (int i = 0; i <= 100; ++i) {
    const double t = duration(plan.profile) * i / 100;
    EXPECT_NEAR(evaluate(slow, 1.25 * t).p, evaluate(plan.profile, t).p, 1e-11);
  }
}

}  // namespace
}  // namespace gantry::motion
