// Whole paths judged from outside: setpoints every tick, differentiated by differences, their distance to the polyline
// by the distance to all its segments.
#include "motion/path/path_planner.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <random>

#include "tests/motion/path/path_cursor.hpp"

namespace gantry::motion {
namespace {

using Polyline = std::vector<std::array<double, 2>>;
constexpr double kV = 200, kA = 3000, kJ = 50000, kTick = 0.001;

struct Played {
  std::string error;
  Polyline setpoints;
  double seconds = 0, off_mm = 0, v = 0, a = 0, j = 0;  ///< v, a, j: shares of the limits
  std::size_t most_waiting = 0, forced_rests = 0, corner_rests = 0, curves = 0;
};

double distance(const std::array<double, 2>& q, const std::array<double, 2>& a, const std::array<double, 2>& b) {
  const double x = b[0] - a[0], y = b[1] - a[1], square = x * x + y * y;
  const double on = square > 0 ? std::clamp(((q[0] - a[0]) * x + (q[1] - a[1]) * y) / square, 0.0, 1.0) : 0;
  return std::hypot(q[0] - a[0] - on * x, q[1] - a[1] - on * y);
}

struct Axes {
  double v = kV, a = kA, j = kJ;
};

double share(const Polyline& p, std::size_t axis, int order, double limit) {
  std::vector<double> x(4, p.front()[axis]);
  for (const auto& q : p) x.push_back(q[axis]);
  x.insert(x.end(), 4, p.back()[axis]);
  for (int n = 0; n < order; ++n) {
    for (std::size_t k = 0; k + 1 < x.size(); ++k) x[k] = (x[k + 1] - x[k]) / kTick;
    x.pop_back();
  }
  double most = 0;
  for (const double y : x) most = std::max(most, std::abs(y));
  return most / limit;
}

Played play(const Polyline& polyline, double tolerance, double speed = 400, const Axes& axes = {}) {
  Limits limits;
  limits.axes = 2;
  limits.tick_s = kTick;
  for (std::size_t i = 0; i < 2; ++i) limits.axis[i] = {-1e9, 1e9, axes.v, axes.a, axes.j}, limits.linear[i] = true;
  PathPlanner planner(limits, {.tolerance_mm = tolerance, .speed_mm_s = speed});
  Played out;
  double begin = 0;
  std::size_t tick = 0;
  const auto drain = [&] {
    Stretch s;
    while (planner.take(s)) {
      test::PathCursor cursor;
      for (;; ++tick) {
        const double t = static_cast<double>(tick) * kTick - begin;
        if (t >= s.duration_s - 1e-9) break;
        const test::CurveSetpoint x = cursor.at(s, t, 2);
        EXPECT_GE(x.s_dot, 0);
        out.setpoints.push_back({x.q[0], x.q[1]});
      }
      begin += s.duration_s;
    }
  };
  for (const auto& p : polyline) {
    if (const auto ok = planner.add({p[0], p[1]}); !ok) return out.error = ok.error().message, out;
    drain();
  }
  if (const auto ok = planner.finish(); !ok) return out.error = ok.error().message, out;
  drain();
  out.setpoints.push_back(polyline.back());
  out.seconds = begin;
  out.most_waiting = planner.counts().most_waiting, out.forced_rests = planner.counts().forced_rests;
  out.corner_rests = planner.counts().corner_rests, out.curves = planner.counts().curves;
  for (std::size_t i = 0; i < 2; ++i) {
    out.v = std::max(out.v, share(out.setpoints, i, 1, axes.v));
    out.a = std::max(out.a, share(out.setpoints, i, 2, axes.a));
    out.j = std::max(out.j, share(out.setpoints, i, 3, axes.j));
  }
  if (polyline.size() < 2000)
    for (const auto& q : out.setpoints) {
      double best = 1e9;
      for (std::size_t k = 1; k < polyline.size(); ++k)
        best = std::min(best, distance(q, polyline[k - 1], polyline[k]));
      out.off_mm = std::max(out.off_mm, best);
    }
  return out;
}

void expect_sound(const Played& p, double tolerance) {
  EXPECT_EQ(p.error, "");
  EXPECT_LE(p.v, 1.01);
  EXPECT_LE(p.a, 1.01);
  EXPECT_LE(p.j, 1.01);
  EXPECT_LE(p.off_mm, tolerance + 1e-7);
  EXPECT_EQ(p.forced_rests, 0U);
  EXPECT_NEAR(p.seconds / kTick, std::round(p.seconds / kTick), 1e-5);
}

Polyline circle(double radius, int chords, double turns = 1) {
  Polyline out;
  for (int k = 0; k <= chords; ++k) {
    const double angle = 2 * M_PI * turns * k / chords;
    out.push_back({radius * std::cos(angle), radius * std::sin(angle)});
  }
  return out;
}

Polyline zigzag() {
  Polyline out{{0, 0}};
  for (double direction = 1; out.size() < 498; direction = -direction) {
    for (int k = 0; k < 40; ++k) out.push_back({out.back()[0] + 0.5 * direction, out.back()[1]});
    for (int k = 0; k < 2; ++k) out.push_back({out.back()[0], out.back()[1] + 0.5});
  }
  out.resize(498);
  return out;
}

TEST(PathPlanner, a_circle_of_chords_is_driven_as_the_circle) {
  const Played p = play(circle(40, 503), 0.05);
  expect_sound(p, 0.05);
  EXPECT_LE(p.seconds, 1.42);
}

TEST(PathPlanner, corners_of_a_zigzag_overlap) {
  const Played p = play(zigzag(), 0.05);
  expect_sound(p, 0.05);
  EXPECT_LE(p.seconds, 3.05);
}

TEST(PathPlanner, circle_and_zigzag_make_one_path) {
  Polyline both = circle(40, 503);
  const auto end = both.back();
  for (const auto& q : zigzag()) both.push_back({q[0] + end[0], q[1] + end[1]});
  const Played p = play(both, 0.05);
  expect_sound(p, 0.05);
  EXPECT_LE(p.seconds, 4.5);
}

// Coordinates of three decimals, as files have them.
TEST(PathPlanner, rounded_coordinates_cost_no_time) {
  Polyline rounded = circle(30, 377);
  for (auto& q : rounded)
    for (double& x : q) x = std::round(x * 1000) / 1000;
  const Played p = play(rounded, 0.05), exact = play(circle(30, 377), 0.05);
  expect_sound(p, 0.05);
  EXPECT_LE(p.seconds, 1.03 * exact.seconds);
}

/// Least time along y = height sin(2 pi x/period) with limits of speed and acceleration alone, by a forward and a
/// backward pass over its derivatives; no jerk-limited motion is faster.
double bound_of_sine(double height, double period, double length) {
  struct Place {
    std::array<double, 2> d1{}, d2{};
  };
  constexpr double kStep = 0.02;
  const double w = 2 * M_PI / period;
  std::vector<Place> places;
  for (double x = 0; x < length;) {
    const double slope = height * w * std::cos(w * x), bend = -height * w * w * std::sin(w * x);
    const double n = std::hypot(1, slope), curvature = bend / (n * n * n);
    places.push_back({{1 / n, slope / n}, {-slope / n * curvature, 1 / n * curvature}});
    x += kStep / n;
  }
  std::vector<double> most(places.size() + 1, 1e9), v(places.size() + 1, 0);
  for (std::size_t k = 0; k < places.size(); ++k)
    for (std::size_t i = 0; i < 2; ++i) {
      const double q1 = std::abs(places[k].d1[i]), q2 = std::abs(places[k].d2[i]);
      most[k] = std::min({most[k], kV / q1, q2 > 0 ? std::sqrt(kA / q2) : 1e9});
    }
  const auto gain = [&](std::size_t k, double speed, double sign) {
    double best = 1e9;
    for (std::size_t i = 0; i < 2; ++i) {
      const double q1 = places[k].d1[i], q2 = places[k].d2[i] * speed * speed;
      best = std::min(best, (kA - sign * (q1 > 0 ? q2 : -q2)) / std::abs(q1));
    }
    return std::max(0.0, best);
  };
  for (std::size_t k = 0; k < places.size(); ++k)
    v[k + 1] = std::min(most[k + 1], std::sqrt(v[k] * v[k] + 2 * gain(k, v[k], 1) * kStep));
  double seconds = 0, after = 0;
  for (std::size_t k = places.size(); k-- > 0;) {
    const double here = std::min(v[k], std::sqrt(after * after + 2 * gain(k, after, -1) * kStep));
    seconds += 2 * kStep / (here + std::min(v[k + 1], after));
    after = here;
  }
  return seconds;
}

Polyline sine(double height, double period, double length, double chord) {
  Polyline out;
  for (int k = 0; k * chord <= length; ++k)
    out.push_back({k * chord, height * std::sin(2 * M_PI * k * chord / period)});
  return out;
}

// Acceleration needs a/j = 0.06 s to come and go, which the bound leaves out.
TEST(PathPlanner, a_sine_is_near_its_bound_whatever_its_chords) {
  for (const double height : {3.0, 5.0}) {
    const double bound = bound_of_sine(height, 60, 240);
    for (const double chord : {0.1, 0.3, 0.5, 1.0, 2.0}) {
      SCOPED_TRACE(std::to_string(height) + " in chords of " + std::to_string(chord));
      const Played p = play(sine(height, 60, 240, chord), 0.05);
      expect_sound(p, 0.05);
      EXPECT_GE(p.seconds, 0.99 * bound);
      EXPECT_LE(p.seconds, 1.1 * bound);
    }
  }
}

/// Four lines of 25 mm, a quarter of a circle after each, from points 0.05 mm apart.
Polyline rounded_square(double radius, std::size_t every) {
  constexpr double kStep = 0.05;
  const double quarter = radius * M_PI / 2, part = 25 + quarter;
  Polyline dense{{0, 0}}, out;
  double angle = 0.3;
  for (double s = kStep / 2; s < 4 * part; s += kStep) {
    const double bend = std::fmod(s, part) < 25 ? 0 : kStep / radius;
    angle += bend / 2;
    const auto& last = dense.back();
    dense.push_back({last[0] + kStep * std::cos(angle), last[1] + kStep * std::sin(angle)});
    angle += bend / 2;
  }
  for (std::size_t k = 0; k < dense.size(); k += every) out.push_back(dense[k]);
  out.push_back(dense.back());
  return out;
}

// The jerk where a line becomes an arc is what holds these up. The bound, with the jerk of start and stop, is that of
// bench/path_smooth/judge_smooth.py, which shares no code with the planner.
TEST(PathPlanner, lines_and_arcs_are_near_their_bound_whatever_their_chords) {
  constexpr double kBound_s = 0.964;
  for (const std::size_t every : {2, 6, 20, 40}) {
    const Played p = play(rounded_square(1.0001 * kA * kA * kA / (kJ * kJ), every), 0.05);
    expect_sound(p, 0.05);
    EXPECT_LE(p.seconds, 1.1 * kBound_s) << every;
  }
}

TEST(PathPlanner, chords_as_coarse_as_the_tolerance_cost_no_time) {
  const Played fine = play(circle(40, 503), 0.05);
  for (const int chords : {251, 84, 63}) {
    const Played p = play(circle(40, chords), 0.05);
    expect_sound(p, 0.05);
    EXPECT_LE(p.seconds, 1.02 * fine.seconds) << chords;
  }
}

// As a digitiser leaves them: each point jumps by up to a fifth of the tolerance, stands in a cluster, or goes back.
TEST(PathPlanner, points_that_jump_within_the_tolerance_cost_no_time) {
  constexpr double kTolerance = 0.05;
  std::mt19937 random(3);
  const auto jump = [&](double by) { return std::uniform_real_distribution<double>(-by, by)(random); };
  const auto noisy = [&](Polyline p, double by) {
    for (std::size_t k = 1; k + 1 < p.size(); ++k) p[k][0] += jump(by), p[k][1] += jump(by);
    return p;
  };
  const auto line = [](int chords) {
    Polyline out;
    for (int k = 0; k <= chords; ++k) out.push_back({20.0 * k / chords, 0});
    return out;
  };
  const auto expect_as_quick = [&](const Polyline& clean, const Polyline& with, const std::string& what) {
    const Played a = play(clean, kTolerance), b = play(with, kTolerance);
    expect_sound(b, kTolerance);
    EXPECT_LE(b.seconds, 1.08 * a.seconds) << what;
  };
  for (const int chords : {60, 200, 800})
    for (const double by : {0.002, 0.005, 0.01}) {
      const std::string what = std::to_string(chords) + " chords, " + std::to_string(by) + " mm";
      expect_as_quick(line(chords), noisy(line(chords), by), "line, " + what);
      expect_as_quick(circle(10, chords), noisy(circle(10, chords), by), "circle, " + what);
    }
  Polyline cluster = line(10), back;
  for (int n = 0; n < 200; ++n) cluster.insert(cluster.begin() + 5, {8 + jump(0.003), jump(0.003)});
  for (const auto& p : line(10)) back.insert(back.end(), {p, {p[0] - (p[0] > 3 && p[0] < 17 ? 0.02 : 0), 0}});
  expect_as_quick(line(10), cluster, "cluster");
  expect_as_quick(line(10), back, "steps back");
}

// A bend of tens of mm at 10 mm/s is one curve of several seconds: windows have to end within it.
TEST(PathPlanner, long_bends_at_a_low_speed_ask_for_no_rest) {
  const Polyline p{{0, 0},
                   {0.413, -12.829},
                   {0, 0},
                   {-0.413, 12.829},
                   {-0.826, 25.658},
                   {-1.606, 30.353},
                   {-3.154, 37.546},
                   {-6.526, 49.931},
                   {-6.526, 49.931},
                   {-10.038, 62.276},
                   {-13.55, 74.622},
                   {-17.063, 86.967},
                   {-20.715, 99.272},
                   {-20.936, 99.776},
                   {-26.093, 111.53},
                   {-27.809, 115.442},
                   {-28.35, 116.347},
                   {-28.506, 116.547},
                   {-36.29, 126.752},
                   {-44.075, 136.958},
                   {-51.86, 147.163},
                   {-52.257, 147.697},
                   {-59.805, 158.078},
                   {-67.232, 168.546},
                   {-74.66, 179.014},
                   {-81.221, 190.047}};
  const Played slow = play(p, 0.431251, 9.87523);
  expect_sound(slow, 0.431251);
  EXPECT_EQ(slow.forced_rests, 0u);
}

// High acceleration and jerk beside the speed: it is reached within three cells of the plan.
TEST(PathPlanner, axes_that_are_soon_at_their_speed_ask_for_no_rest) {
  const Axes axes{5, 1475, 85000};
  for (const auto& [height, period, length] : {std::array<double, 3>{5, 40, 60}, {2, 9, 120}}) {
    SCOPED_TRACE(height);
    expect_sound(play(sine(height, period, length, 0.5), 0.05, 10, axes), 0.05);
  }
}

// Little jerk beside speed and acceleration: plans that follow each other differ for long.
TEST(PathPlanner, axes_of_little_jerk_ask_for_no_rest) {
  expect_sound(play(sine(9, 60, 220, 1), 0.01, 800, {400, 600, 2450}), 0.01);
  expect_sound(play(sine(9, 60, 220, 1), 0.27, 480, {240, 3130, 3600}), 0.27);
}

/// 60 mm, a quarter of a circle, 60 mm.
Polyline line_arc_line(double radius, int chords) {
  Polyline out{{0, 0}};
  for (int k = 0; k <= chords; ++k) {
    const double angle = M_PI / 2 * k / chords;
    out.push_back({60 + radius * std::sin(angle), radius * (1 - std::cos(angle))});
  }
  out.push_back({60 + radius, radius + 60});
  return out;
}

TEST(PathPlanner, keeps_the_speed_that_the_jerk_allows_where_a_line_becomes_an_arc) {
  for (const double radius : {3.0, 5.0, 10.0, 20.0}) {
    SCOPED_TRACE(radius);
    const double speed = 0.98 * std::min({std::cbrt(kJ * radius * std::sqrt(24 * radius * 0.05)),
                                          std::sqrt(kA * radius), std::cbrt(kJ * radius * radius)});
    const Played p = play(line_arc_line(radius, 60), 0.05, speed);
    expect_sound(p, 0.05);
    double all = 0, kept = 0;
    for (std::size_t k = 120; k + 121 < p.setpoints.size(); ++k) {
      const double step =
          std::hypot(p.setpoints[k + 1][0] - p.setpoints[k][0], p.setpoints[k + 1][1] - p.setpoints[k][1]);
      all += step;
      if (std::abs(step / kTick - speed) <= 0.05 * speed) kept += step;
    }
    EXPECT_GE(kept, 0.98 * all);
  }
}

TEST(PathPlanner, keeps_the_tolerance_however_small) {
  for (const double tolerance : {3.1e-4, 1e-3, 0.01, 0.3})
    for (const int chords : {40, 200}) {
      const Played p = play(circle(2, chords), tolerance, 54);
      SCOPED_TRACE(tolerance);
      EXPECT_EQ(p.error, "");
      EXPECT_LE(p.off_mm, tolerance + 1e-9);
    }
}

// Archimedes' spiral in chords whose corners are left by many times the tolerance: many places hold the spline at once.
TEST(PathPlanner, a_bend_that_is_held_in_many_places_takes_few_curves) {
  Polyline p;
  for (double angle = 0.3; p.size() < 150; angle += 0.075 / (0.1035 * std::hypot(1, angle)))
    p.push_back({0.1035 * angle * std::cos(angle), 0.1035 * angle * std::sin(angle)});
  const Played spiral = play(p, 3.8e-4);
  expect_sound(spiral, 3.8e-4);
  EXPECT_EQ(spiral.corner_rests, 0U);
  EXPECT_LE(spiral.curves, 10 * p.size());
}

TEST(PathPlanner, a_ring_within_the_tolerance_is_driven_out_and_back) {
  const Played p = play(circle(0.1, 40), 1);
  EXPECT_EQ(p.error, "");
  EXPECT_GT(p.seconds, 0);
  EXPECT_LE(p.off_mm, 1);
}

TEST(PathPlanner, a_line_in_chords_takes_as_long_as_the_line) {
  Polyline chords;
  for (int k = 0; k <= 4000; ++k) chords.push_back({0.01 * k, 0.004 * k});
  const Played line = play({{0, 0}, {40, 16}}, 0.05), p = play(chords, 0.05);
  EXPECT_EQ(p.error, "");
  EXPECT_LE(p.j, 1.01);
  EXPECT_NEAR(p.seconds, line.seconds, 1.01 * kTick);
}

// From the limits alone: 50 mm at 200 mm/s and the time of speeding up and braking, v/a + a/j.
TEST(PathPlanner, a_line_takes_the_least_time) {
  const Played p = play({{0, 0}, {50, 0}}, 0.05);
  EXPECT_NEAR(p.seconds, 50 / kV + kV / kA + kA / kJ, 1.5 * kTick);
}

TEST(PathPlanner, without_tolerance_it_rests_in_corners_and_stays_on_the_polyline) {
  const Played p = play({{0, 0}, {20, 0}, {20, 10}}, 0);
  expect_sound(p, 0);
}

// A tolerance larger than the radius leaves room for a path that folds to nothing.
TEST(PathPlanner, a_tolerance_beyond_the_radius_makes_no_more_work) {
  for (const double share : {0.5, 1.0, 2.0, 3.0}) {
    const Played p = play(circle(0.2, 100), share * 0.2, 20);
    expect_sound(p, share * 0.2);
    EXPECT_LT(p.curves, 100U) << share;
  }
}

/// The lowest speed over three ticks, but for the first and the last 20 ticks.
double slowest(const Played& p) {
  double least = 1e9;
  for (std::size_t k = 20; k + 23 < p.setpoints.size(); ++k)
    least = std::min(least,
                     std::hypot(p.setpoints[k + 3][0] - p.setpoints[k][0], p.setpoints[k + 3][1] - p.setpoints[k][1]));
  return least / (3 * kTick);
}

TEST(PathPlanner, a_reversal_is_driven_without_a_standstill) {
  const Played p = play({{0, 0}, {20, 0}, {5, 0}}, 0.05);
  expect_sound(p, 0.05);
  EXPECT_GT(slowest(p), 0.1);
}

// Corners of 165 to 167 degrees, one next to the other, are on either side of what counts as a reversal. Going round
// one of them makes its neighbours sharper.
TEST(PathPlanner, a_narrow_zigzag_is_driven_without_a_standstill) {
  for (double step = 0.068; step < 0.0735; step += 0.001) {
    SCOPED_TRACE(step);
    Polyline p;
    for (int row = 0; row < 9; ++row) p.push_back({row % 2 == 0 ? 0 : 0.571, step * row + (row % 3 == 0 ? 0.001 : 0)});
    const Played narrow = play(p, 0.2);
    expect_sound(narrow, 0.2);
    EXPECT_GT(slowest(narrow), 0.1);
  }
}

TEST(PathPlanner, a_higher_set_speed_is_not_slower) {
  double last = 1e9;
  for (const double speed : {20.0, 40.0, 80.0, 160.0, 320.0}) {
    const Played p = play(circle(15, 200), 0.05, speed);
    expect_sound(p, 0.05);
    EXPECT_LE(p.seconds, 1.001 * last + kTick) << speed;
    last = p.seconds;
  }
}

TEST(PathPlanner, what_waits_does_not_grow_with_the_path) {
  const Played one = play(circle(20, 1000, 4), 0.05), four = play(circle(20, 4000, 16), 0.05);
  EXPECT_EQ(four.error, "");
  EXPECT_LE(four.j, 1.01);
  EXPECT_EQ(four.forced_rests, 0U);
  EXPECT_LE(four.most_waiting, one.most_waiting + one.most_waiting / 2);
}

// 400 s at the lowest of the axes' speeds, in one line.
TEST(PathPlanner, what_waits_does_not_grow_with_a_line) {
  const Played p = play({{0, 0}, {4000, 1}}, 0.05, 10);
  expect_sound(p, 0.05);
  EXPECT_LE(p.most_waiting, 100U);
}

TEST(PathPlanner, random_polylines_keep_limits_and_tolerance) {
  for (unsigned seed = 1; seed <= 12; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    std::normal_distribution<double> normal;
    Polyline p{{0, 0}};
    double angle = 0;
    for (int k = 0; k < 12; ++k) {
      angle += normal(random);
      const double chord = std::pow(10.0, 0.6 * normal(random));
      p.push_back({p.back()[0] + chord * std::cos(angle), p.back()[1] + chord * std::sin(angle)});
    }
    const double tolerance = seed % 2 == 0 ? 0.05 : 0.2;
    expect_sound(play(p, tolerance), tolerance);
  }
}

TEST(PathPlanner, refuses_what_is_no_number) {
  EXPECT_NE(play({{0, 0}, {std::nan(""), 0}}, 0.05).error, "");
  EXPECT_NE(play({{0, 0}, {1, 0}}, -1).error, "");
  EXPECT_NE(play({{0, 0}, {1, 0}}, 0.05, 0).error, "");
}

}  // namespace
}  // namespace gantry::motion
