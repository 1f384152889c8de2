// recipes/patterns.yaml in virtual time: where each pattern lies by the world's log, judged by formulas that share
// nothing with the recipe's code.
#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <map>
#include <numbers>

#include "core/units.hpp"
#include "tests/machine/deposits.hpp"

namespace gantry {
namespace {

using std::numbers::pi;
using test::Rig;

/// The needle may be so far off sideways on a bead: marks, following, and valve edges within a tick.
constexpr double kOff_mm = 0.020;
constexpr double kCurve_mm = 0.05;  ///< corner tolerance of the curves

class Patterns : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    recipe_ = new recipes::Recipe(test::load_recipe("recipes/patterns.yaml"));
    Rig rig({.placement = "dx=1.1 mm, dy=-0.6 mm, rot=0.7 deg"});
    result_ = new record::JobResult(rig.run(*recipe_));
  }
  static void TearDownTestSuite() { delete result_, delete recipe_; }

  static const std::vector<Vec3>& path(const std::string& id) {
    static const std::vector<Vec3> kNone{{1e9, 1e9, 1e9}};
    for (const record::Deposit& d : result_->deposits)
      if (d.id == id) return d.board_mm;
    ADD_FAILURE() << "not dispensed: " << id;
    return kNone;
  }
  static double length(const std::vector<Vec3>& p) {
    double mm = 0;
    for (std::size_t i = 1; i < p.size(); ++i) mm += norm(p[i] - p[i - 1]);
    return mm;
  }
  static void expect_near(Vec3 p, Vec3 want, double mm, const std::string& what) {
    EXPECT_NEAR(p.x, want.x, mm) << what;
    EXPECT_NEAR(p.y, want.y, mm) << what;
    EXPECT_NEAR(p.z, want.z, 0.03) << what;
  }
  /// Every point of the log on the circle, swept by the angle, which is above 0 counter-clockwise.
  static void expect_arc(const std::string& id, Vec2 centre, double radius, Vec2 from, double angle) {
    const auto& p = path(id);
    expect_near(p.front(), {from.x, from.y, 0.3}, kOff_mm, id);
    const Vec2 to = centre + rotated(from - centre, angle);
    expect_near(p.back(), {to.x, to.y, 0.3}, kOff_mm, id);
    double swept = 0, worst = 0;
    for (std::size_t i = 0; i < p.size(); ++i) {
      const Vec2 r{p[i].x - centre.x, p[i].y - centre.y};
      worst = std::max(worst, std::abs(norm(r) - radius));
      EXPECT_NEAR(p[i].z, 0.3, 0.03) << id;
      if (i == 0) continue;
      const Vec2 s{p[i - 1].x - centre.x, p[i - 1].y - centre.y};
      swept += std::atan2(s.x * r.y - s.y * r.x, dot(s, r));
    }
    EXPECT_LE(worst, kCurve_mm + kOff_mm) << id;
    EXPECT_NEAR(swept, angle, 2 * kOff_mm / radius) << id;
    EXPECT_NEAR(length(p), radius * std::abs(angle), 0.2) << id;
  }
  /// Largest distance of the log from a polyline and of the polyline from the log.
  static void expect_along(const std::string& id, const std::vector<Vec2>& line, double tolerance_mm) {
    const auto& p = path(id);
    const auto off = [](Vec2 q, const auto& points, std::size_t n, auto at) {
      double best = 1e9;
      for (std::size_t i = 1; i < n; ++i) {
        const Vec2 a = at(points[i - 1]), leg = at(points[i]) - a;
        const double t = dot(leg, leg) > 0 ? std::clamp(dot(q - a, leg) / dot(leg, leg), 0.0, 1.0) : 0;
        best = std::min(best, norm(q - (a + leg * t)));
      }
      return best;
    };
    const auto plane = [](Vec3 q) { return Vec2{q.x, q.y}; };
    double worst = 0, missed = 0;
    for (const Vec3 q : p) worst = std::max(worst, off(plane(q), line, line.size(), [](Vec2 v) { return v; }));
    for (const Vec2 q : line) missed = std::max(missed, off(q, p, p.size(), plane));
    EXPECT_LE(worst, tolerance_mm + kOff_mm) << id;
    EXPECT_LE(missed, tolerance_mm + kOff_mm) << id << ": corners";
    EXPECT_LT(norm(plane(p.front()) - line.front()), kOff_mm) << id;
    EXPECT_LT(norm(plane(p.back()) - line.back()), kOff_mm) << id;
  }

  static inline recipes::Recipe* recipe_ = nullptr;
  static inline record::JobResult* result_ = nullptr;
};

TEST_F(Patterns, are_all_dispensed_within_their_tolerance_and_nothing_is_hit) {
  test::expect_done(*result_);
  test::expect_deposits(*recipe_, *result_);
  EXPECT_TRUE(result_->collisions.empty());
}

TEST_F(Patterns, the_needle_is_purged_before_the_first_deposit) {
  const auto is_purge = [](const record::Deposit& d) { return d.kind == "purge"; };
  ASSERT_GE(result_->deposits.size(), 3u);
  for (std::size_t i = 0; i < result_->deposits.size(); ++i) {
    const record::Deposit& d = result_->deposits[i];
    EXPECT_EQ(is_purge(d), i < 3) << i;
    if (i < 3) expect_near(d.board_mm[0], {100, 5, 0.3}, kOff_mm, "purge");
  }
  EXPECT_EQ(result_->purge_shots, 3u);
  EXPECT_EQ(result_->features_done, recipe_->features.size());
}

TEST_F(Patterns, arcs_and_circles_lie_on_their_circles) {
  expect_arc("bow", {17, 36}, 7, {10, 36}, -pi);
  expect_arc("quarter", {32, 36}, 8, {40, 36}, pi / 2);
  expect_arc("ring", {24, 62}, 10, {24, 72}, -2 * pi);
}

TEST_F(Patterns, the_spiral_has_the_radius_of_its_angle) {
  const auto& p = path("coil");
  double angle = 0, worst = 0;
  for (std::size_t i = 0; i < p.size(); ++i) {
    const Vec2 r{p[i].x - 58, p[i].y - 56};
    if (i > 0) {
      const Vec2 s{p[i - 1].x - 58, p[i - 1].y - 56};
      angle += std::atan2(s.x * r.y - s.y * r.x, dot(s, r));
    }
    worst = std::max(worst, std::abs(norm(r) - (1 + 3 * angle / (2 * pi))));
  }
  // Sideways errors and those along the path: where the radius is 1 mm the spiral climbs by half of a millimetre a mm.
  EXPECT_LE(worst, (kCurve_mm + kOff_mm) * 1.15);
  EXPECT_NEAR(angle, 4 * 2 * pi, 0.02);
  expect_near(p.front(), {59, 56, 0.3}, kOff_mm, "coil");
  expect_near(p.back(), {71, 56, 0.3}, kOff_mm, "coil");
}

TEST_F(Patterns, the_wave_of_the_file_is_a_sine) {
  for (const Vec3 q : path("wave")) EXPECT_NEAR(q.y, 8 + 2 * std::sin(2 * pi * (q.x - 10) / 20), 0.1);
  expect_near(path("wave").front(), {10, 8, 0.3}, kOff_mm, "wave");
  expect_near(path("wave").back(), {50, 8, 0.3}, kOff_mm, "wave");
}

TEST_F(Patterns, the_ramp_keeps_its_gap_over_the_slope) {
  const auto& p = path("ramp");
  for (const Vec3 q : p) EXPECT_NEAR(q.z, 0.3 + 3 * (q.x - 56) / 20, 0.03);
  expect_near(p.back(), {76, 16, 3.3}, kOff_mm, "ramp");
  const auto ramp = std::find_if(result_->deposits.begin(), result_->deposits.end(),
                                 [](const record::Deposit& d) { return d.id == "ramp"; });
  ASSERT_NE(ramp, result_->deposits.end());
  EXPECT_NEAR(ramp->gap_mm, 0.3, 0.03);
  EXPECT_EQ(ramp->asked_gap_mm, 0.3);
}

TEST_F(Patterns, fills_run_on_their_lines) {
  std::vector<Vec2> pad;
  for (int k = 0; k < 9; ++k) {
    const double y = 51 + 2 * k;
    pad.push_back({k % 2 == 0 ? 81.0 : 109.0, y});
    pad.push_back({k % 2 == 0 ? 109.0 : 81.0, y});
  }
  expect_along("pad", pad, 0.2);
  // The L by hand: three lines of the foot, then the upright's five, half of 2 mm within the outline.
  const auto& foot = path("corner[0]");
  EXPECT_NEAR(foot.front().x, 57, kOff_mm);
  EXPECT_NEAR(foot.front().y, 23, kOff_mm);
  for (const record::Deposit& d : result_->deposits) {
    if (!d.id.starts_with("corner") && d.id != "wedge") continue;
    for (const Vec3 q : d.board_mm) {
      if (d.id == "wedge") {
        // Signed distances from the triangle's edges: nowhere nearer than a millimetre.
        const Vec2 corners[] = {{88, 10}, {112, 18}, {92, 34}};
        for (int k = 0; k < 3; ++k) {
          const Vec2 a = corners[k], e = corners[(k + 1) % 3] - a;
          EXPECT_GE((e.x * (q.y - a.y) - e.y * (q.x - a.x)) / norm(e), 1 - 0.05 - kOff_mm);
        }
      } else {
        const bool low = q.x > 57 - kOff_mm && q.x < 79 + kOff_mm && q.y > 23 - kOff_mm && q.y < 27 + kOff_mm;
        const bool high = q.x > 57 - kOff_mm && q.x < 61 + kOff_mm && q.y > 23 - kOff_mm && q.y < 37 + kOff_mm;
        EXPECT_TRUE(low || high) << q.x << ", " << q.y;
      }
    }
  }
  ASSERT_EQ(result_->fills.size(), 3u);
  EXPECT_NEAR(result_->fills[0].area_mm2, 30 * 18, 1e-9);
  EXPECT_NEAR(result_->fills[1].area_mm2, 0.5 * std::abs(24.0 * 24 - 4.0 * 8), 1e-9);
  EXPECT_NEAR(result_->fills[2].area_mm2, 24 * 6 + 6 * 10, 1e-9);
}

TEST_F(Patterns, lengths_are_those_of_the_curves) {
  std::map<std::string, double> drawn;
  for (const record::DrawnBead& b : result_->beads) drawn[b.id] = b.length_mm;
  EXPECT_NEAR(drawn["bow"], 7 * pi, 1e-9);
  EXPECT_NEAR(drawn["quarter"], 4 * pi, 1e-9);
  EXPECT_NEAR(drawn["ring"], 20 * pi, 1e-9);
  EXPECT_NEAR(drawn["ramp"], std::hypot(20, 3), 1e-9);
  EXPECT_NEAR(drawn["pad"], 9 * 28 + 8 * 2, 1e-5);
  double coil = 0;
  for (int i = 0; i < 100000; ++i) {  // midpoint rule of sqrt(r^2 + b^2) dt
    const double t = (i + 0.5) * 8 * pi / 100000, b = 3 / (2 * pi);
    coil += std::hypot(1 + b * t, b) * 8 * pi / 100000;
  }
  EXPECT_NEAR(drawn["coil"], coil, 1e-6);
}

// recipes/on-parts.yaml: the part is 3 mm high, the gap 0.4 mm; the valve shuts 0.5 mm before a bead's end.
TEST(OnParts, lies_on_the_part_stands_first_shuts_early_and_goes_one_way) {
  Rig rig({.placement = "dx=0 mm, dy=0 mm, rot=0 deg"});
  const record::JobResult result = rig.run("recipes/on-parts.yaml");
  test::expect_done(result);
  EXPECT_TRUE(result.collisions.empty());
  std::map<std::string, const record::Deposit*> by_id;
  for (const record::Deposit& d : result.deposits) by_id[d.id] = &d;
  ASSERT_EQ(by_id.size(), 5u);
  const auto ends = [&](const char* id, Vec3 from, Vec3 to) {
    const auto& path = by_id.at(id)->board_mm;
    EXPECT_LT(norm(path.front() - from), kOff_mm + kCurve_mm) << id;
    EXPECT_LT(norm(path.back() - to), kOff_mm + kCurve_mm) << id;
    if (path.size() < 2) return;
    ASSERT_TRUE(by_id.at(id)->speed);
    EXPECT_NEAR(by_id.at(id)->speed->stood_s, 0.12, 0.02) << id;
  };
  ends("centre", {30, 30, 3.4}, {30, 30, 3.4});
  ends("lid", {36, 30, 3.4}, {30 + 6 * std::cos(0.5 / 6), 30 - 6 * std::sin(0.5 / 6), 3.4});
  for (int k = 0; k < 3; ++k)
    ends(fmt::format("pad[{}]", k).c_str(), {53, 21 + 2.0 * k, 0.4}, {70.5, 21 + 2.0 * k, 0.4});
}

}  // namespace
}  // namespace gantry
