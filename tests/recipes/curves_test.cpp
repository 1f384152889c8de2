#include "recipes/curves.hpp"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <numbers>
#include <random>

namespace gantry::recipes {
namespace {

using std::numbers::pi;

constexpr std::size_t kMany = 100000;

double along(const std::vector<Vec3>& points) {
  double mm = 0;
  for (std::size_t i = 1; i < points.size(); ++i) mm += norm(points[i] - points[i - 1]);
  return mm;
}

/// No leg is less than a third of the one before or after it: planners crawl over crumbs.
void expect_no_crumbs(const std::vector<Vec3>& points, const std::string& what) {
  for (std::size_t i = 2; i < points.size(); ++i) {
    const double a = norm(points[i - 1] - points[i - 2]), b = norm(points[i] - points[i - 1]);
    ASSERT_LT(std::max(a, b), 3 * std::min(a, b)) << what << " at point " << i;
  }
}

TEST(Arc, through_three_points_lies_on_their_circle_and_ends_where_they_say) {
  const unsigned seed = 3;
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> any(-50, 50), sags(1e-4, 0.01);
  int taken = 0;
  for (int n = 0; n < 500; ++n) {
    const Vec3 a{any(random), any(random), any(random)}, b{any(random), any(random), any(random)},
        c{any(random), any(random), any(random)};
    const double sag = sags(random);
    const auto arc = arc_through(a, b, c);
    ASSERT_TRUE(arc) << "seed " << seed << " case " << n << ": " << arc.error().message;
    const auto curve = sample(*arc, sag, kMany);
    if (!curve) continue;  // a circle of kilometres
    ++taken;
    const std::string what = "seed 3, case " + std::to_string(n);
    EXPECT_EQ(curve->points.front(), a) << what;
    EXPECT_EQ(curve->points.back(), c) << what;
    // The circumcentre by the sides' squares (barycentric), another formula than the code's.
    const double aa = dot(b - c, b - c), bb = dot(c - a, c - a), cc = dot(a - b, a - b);
    const double wa = aa * (bb + cc - aa), wb = bb * (cc + aa - bb), wc = cc * (aa + bb - cc), w = wa + wb + wc;
    const Vec3 centre = a * (wa / w) + b * (wb / w) + c * (wc / w);
    const double r = norm(a - centre);
    double nearest = 1e9;
    for (std::size_t i = 1; i < curve->points.size(); ++i)
      for (int k = 0; k <= 20; ++k) {
        const Vec3 p = curve->points[i - 1] + (curve->points[i] - curve->points[i - 1]) * (k / 20.0);
        EXPECT_LE(std::abs(norm(p - centre) - r), sag + 1e-6 * r) << what;
        nearest = std::min(nearest, norm(p - b));
      }
    // Points of the test are up to a fortieth of a chord apart.
    EXPECT_LE(nearest, sag + norm(curve->points[1] - curve->points[0]) / 30)
        << what << ": it does not come by 'through'";
    EXPECT_LE(along(curve->points), curve->length_mm * (1 + 1e-9)) << what;
    EXPECT_GE(along(curve->points), curve->length_mm * (1 - 0.003)) << what;
    expect_no_crumbs(curve->points, what);
  }
  EXPECT_GT(taken, 490);
}

TEST(Arc, about_a_centre_turns_by_its_angle_either_way) {
  for (const double angle : {0.3, -0.3, 1.5, -4.0, 2 * pi, -2 * pi}) {
    const auto arc = arc_about({10, 20}, {13, 24, 1.5}, angle);
    ASSERT_TRUE(arc);
    const auto curve = sample(*arc, 0.002, kMany);
    ASSERT_TRUE(curve);
    EXPECT_NEAR(curve->length_mm, 5 * std::abs(angle), 1e-9);
    double turned = 0;
    for (std::size_t i = 1; i < curve->points.size(); ++i) {
      const Vec3 p = curve->points[i - 1] - Vec3{10, 20, 1.5}, q = curve->points[i] - Vec3{10, 20, 1.5};
      turned += std::atan2(p.x * q.y - p.y * q.x, p.x * q.x + p.y * q.y);
      EXPECT_NEAR(std::hypot(q.x, q.y), 5, 1e-9);
      EXPECT_EQ(q.z, 0);
    }
    EXPECT_NEAR(turned, angle, 1e-9);
  }
}

TEST(Arc, that_is_none_says_what_to_write) {
  const auto says = [](const Result<Arc>& arc, const char* words) {
    ASSERT_FALSE(arc);
    EXPECT_EQ(arc.error().fault, Fault::Inconsistent);
    EXPECT_NE(arc.error().message.find(words), std::string::npos) << arc.error().message;
  };
  says(arc_through({0, 0, 0}, {1, 1, 0}, {2, 2, 0}), "on one line");
  says(arc_through({0, 0, 0}, {50, 0.0005, 0}, {100, 0, 0}), "on one line");
  says(arc_through({0, 0, 0}, {1, 1, 0}, {0, 0, 0}), "'circle'");
  says(arc_through({0, 0, 0}, {0, 0, 0}, {2, 2, 0}), "'through'");
  says(arc_about({1, 1}, {1, 1, 5}, 1), "no radius");
  says(arc_about({1, 1}, {2, 1, 0}, 0), "0 deg");
}

TEST(Spiral, has_the_radius_of_its_angle_and_sags_no_more_than_allowed) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> radius(0, 40), pitches(0.2, 8), starts(-3, 3);
  for (int n = 0; n < 60; ++n) {
    const Spiral s{{20, 30, 2}, n % 4 == 0 ? 0 : radius(random), radius(random) + 1, pitches(random), starts(random),
                   n % 2 == 1};
    const double sag = 0.002;
    const auto curve = sample(s, sag, kMany);
    ASSERT_TRUE(curve);
    const std::string what = "seed 5, case " + std::to_string(n);
    const double all = 2 * pi * std::abs(s.to_radius_mm - s.from_radius_mm) / s.pitch_mm;
    const auto at = [&](double t) {
      const double r = s.from_radius_mm + (s.to_radius_mm - s.from_radius_mm) * t / all;
      const double angle = s.start_rad + (s.clockwise ? -t : t);
      return Vec3{20 + r * std::cos(angle), 30 + r * std::sin(angle), 2};
    };
    EXPECT_LT(norm(curve->points.front() - at(0)), 1e-9) << what;
    EXPECT_LT(norm(curve->points.back() - at(all)), 1e-9) << what;
    // Along the spiral itself in tiny steps: never far from the chords, which are taken in their order.
    double length = 0, worst = 0;
    std::size_t chord = 1;
    Vec3 last = at(0);
    const int steps = static_cast<int>(all * 400) + 1000;
    const auto off = [&](std::size_t i, Vec3 p) {
      const Vec3 leg = curve->points[i] - curve->points[i - 1];
      const double t = std::clamp(dot(p - curve->points[i - 1], leg) / dot(leg, leg), 0.0, 1.0);
      return norm(p - (curve->points[i - 1] + leg * t));
    };
    for (int k = 1; k <= steps; ++k) {
      const Vec3 p = at(all * k / steps);
      length += norm(p - last);
      last = p;
      while (chord + 1 < curve->points.size() && off(chord + 1, p) <= off(chord, p)) ++chord;
      worst = std::max(worst, off(chord, p));
    }
    EXPECT_LE(worst, sag * 1.0001) << what;
    EXPECT_NEAR(curve->length_mm, length, 1e-4 * length) << what;
    expect_no_crumbs(curve->points, what);
  }
}

TEST(Curve, of_too_many_points_is_refused_before_they_are_made) {
  const auto spiral = sample(Spiral{{0, 0, 0}, 0, 1000, 0.01, 0, false}, 5e-5, kMany);
  ASSERT_FALSE(spiral);
  EXPECT_EQ(spiral.error().fault, Fault::TooManySteps);
  EXPECT_NE(spiral.error().message.find("corner_tolerance"), std::string::npos);
  const auto arc = arc_about({0, 0}, {1000, 0, 0}, 2 * pi);
  ASSERT_TRUE(arc);
  EXPECT_FALSE(sample(*arc, 1e-9, 1000));
}

TEST(Curve, turns_by_at_most_15_degrees_from_chord_to_chord) {
  const auto most_deg = [](const std::vector<Vec3>& points) {
    double most = 0;
    for (std::size_t i = 2; i < points.size(); ++i) {
      const Vec3 a = points[i - 1] - points[i - 2], b = points[i] - points[i - 1];
      most = std::max(most, std::atan2(norm(cross(a, b)), dot(a, b)) * 180 / pi);
    }
    return most;
  };
  // So large a sag that nothing but the turn limits the chords.
  for (const double pitch : {0.2, 1.0, 5.0})
    for (const auto& [from, to] : {std::pair{0.0, 7.0}, std::pair{7.0, 0.0}, std::pair{0.3, 4.0}, std::pair{4.0, 0.3}})
      for (const bool clockwise : {false, true}) {
        const auto curve = sample(Spiral{{20, 30, 2}, from, to, pitch, 0.7, clockwise}, 1, kMany);
        ASSERT_TRUE(curve);
        EXPECT_LE(most_deg(curve->points), 15 + 1e-6) << from << " to " << to << ", " << pitch << " a turn";
        expect_no_crumbs(curve->points, "spiral");
      }
  for (const double angle : {0.01, 0.4, 2.0, 2 * pi}) {
    const auto curve = sample(*arc_about({0, 0}, {5, 0, 0}, angle), 1, kMany);
    ASSERT_TRUE(curve);
    EXPECT_LE(most_deg(curve->points), 15 + 1e-6) << angle;
  }
}

}  // namespace
}  // namespace gantry::recipes
