#include "motion/plan/find_path.hpp"

#include <gtest/gtest.h>
#include <optional>
#include <utility>

#include "motion/plan/lift_over.hpp"
#include "tests/motion/plan/prism_distance.hpp"
#include "tests/motion/plan/random_bodies.hpp"

namespace gantry::motion {
namespace {

using test::at;
using test::box;
constexpr std::uint64_t kSeed = 2024;

TEST(FindPath, goes_straight_when_nothing_is_in_the_way) {
  Scene scene(test::bare_machine());
  scene.add(box("board", {120, 80, 2}, {100, 100, 1}));
  const auto path = find_path(scene, at(60, 80, 10), at(140, 120, 6), {.clearance_mm = 2, .approaches = {}});
  ASSERT_TRUE(path) << path.error().message;
  EXPECT_EQ(path->kind, PathKind::Straight);
  EXPECT_EQ(path->points, (std::vector<AxisVec>{at(60, 80, 10), at(140, 120, 6)}));
  EXPECT_EQ(path->certificate.pairs, 4U);
  const NearPair& nearest = path->certificate.nearest.others;
  EXPECT_NEAR(nearest.distance_mm, 4, 1e-6);
  EXPECT_EQ(scene.head()[nearest.head].name, "needle");
  EXPECT_EQ(scene.standing()[nearest.standing].name, "board");
  EXPECT_NEAR(nearest.at.z, 2, 1e-9) << "on the board's top";
  EXPECT_TRUE(std::isinf(path->certificate.nearest.by_design.distance_mm)) << "there is no such pair";
}

TEST(FindPath, lifts_over_a_part_as_low_as_its_clearance_lets_it) {
  Scene scene(test::bare_machine());
  scene.add(box("part U7", {10, 10, 12}, {100, 100, 6}));
  const auto path = find_path(scene, at(80, 100, 3), at(120, 100, 3), {.clearance_mm = 2, .approaches = {}});
  ASSERT_TRUE(path) << path.error().message;
  EXPECT_EQ(path->kind, PathKind::LiftOver);
  ASSERT_EQ(path->points.size(), 4U);
  EXPECT_EQ(path->points[1], at(80, 100, path->points[1][2]));
  EXPECT_EQ(path->points[2], at(120, 100, path->points[1][2]));
  EXPECT_NEAR(path->points[1][2], 14, 2e-3);
  EXPECT_GE(path->certificate.nearest.others.distance_mm, 2);
  EXPECT_LT(path->certificate.nearest.others.distance_mm, 2.01);
}

/// Judge: heights in steps of 0.2 mm, each leg by closed forms.
double lowest_by_search(const config::Machine& m, const std::vector<config::Body>& parts, AxisVec from, AxisVec to,
                        double margin, double z_max) {
  const auto free = [&](const AxisVec& p, const AxisVec& q) {
    for (config::Body a : m.head) {
      const auto carried = [&](const AxisVec& v) { return Vec3{v[0], v[1], v[2] - (a.on_lift ? v[4] : 0)}; };
      const Vec3 d = carried(q) - carried(p);
      a.centre = a.centre + carried(p);
      for (const config::Body& b : parts)
        if (test::swept_distance(a, d, b) <= margin) return false;
    }
    return true;
  };
  for (double z = std::max(from[2], to[2]); z <= z_max; z += 0.2) {
    AxisVec up = from, down = to;
    up[2] = down[2] = z;
    up[4] = down[4] = std::min(from[4], to[4]);
    if (free(up, down)) return free(from, up) && free(down, to) ? z : -1;
  }
  return -1;
}

TEST(LiftOver, takes_the_lowest_height_that_is_free_also_between_bodies) {
  test::RandomBodies random(kSeed);
  const config::Machine machine = test::bare_machine();
  int found = 0, none = 0;
  for (int i = 0; i < 100; ++i) {
    std::vector<config::Body> parts;
    Scene scene(machine);
    for (int k = 0; k < 8; ++k) {
      config::Body b = random.body(1, i % 2 == 0);
      b.name = "part " + std::to_string(k);
      b.centre = {random.real(20, 180), random.real(60, 140), k < 6 ? random.real(0, 20) : random.real(40, 120)};
      parts.push_back(b);
      scene.add(b);
    }
    const AxisVec from = at(20, random.real(70, 130), random.real(1, 10), random.real(0, 10));
    const AxisVec to = at(180, random.real(70, 130), random.real(1, 10), random.real(0, 10));
    const auto lifted = lift_over(scene, from, to, {2, {}});
    const double judged = lowest_by_search(machine, parts, from, to, 2, 90);
    if (lifted) {
      ++found;
      EXPECT_GE(judged, lifted->z_mm - 0.01) << "case " << i << " seed " << kSeed;
      EXPECT_LE(judged, lifted->z_mm + 0.2 + 0.002) << "case " << i << " seed " << kSeed;
    } else {
      ++none;
      EXPECT_EQ(judged, -1) << "case " << i << ": " << lifted.error().why;
    }
  }
  EXPECT_GT(found, 25);
  EXPECT_GT(none, 10);
}

TEST(FindPath, is_certified_and_the_same_every_time) {
  test::RandomBodies random(kSeed + 1);
  const config::Machine machine = test::bare_machine();
  int found = 0;
  for (int i = 0; i < 200; ++i) {
    Scene scene(machine);
    for (int k = 0; k < 40; ++k) {
      config::Body b = random.body(1, i % 2 == 0);
      b.name = "part " + std::to_string(k);
      b.centre = {random.real(0, 400), random.real(0, 300), random.real(0, 15)};
      scene.add(b);
    }
    const AxisVec from = at(random.real(0, 400), random.real(0, 300), random.real(10, 40));
    const AxisVec to = at(random.real(0, 400), random.real(0, 300), random.real(10, 40));
    const PathRules rules{.clearance_mm = 1.5, .approaches = {}};
    const auto path = find_path(scene, from, to, rules, 0.2);
    const auto again = find_path(scene, from, to, rules, 0.2);
    ASSERT_EQ(path.has_value(), again.has_value());
    if (!path) {
      EXPECT_EQ(path.error().fault, Fault::Collision);
      EXPECT_EQ(path.error().message, again.error().message);
      continue;
    }
    ++found;
    EXPECT_EQ(path->points, again->points);
    EXPECT_EQ(path->points.front(), from);
    EXPECT_EQ(path->points.back(), to);
    EXPECT_EQ(path->certificate.motions, path->points.size() - 1);
    EXPECT_GE(path->certificate.nearest.others.distance_mm, 1.7 - 1e-9);
    EXPECT_EQ(path->certificate.scene_hash, scene.hash());
  }
  EXPECT_GT(found, 100);
}

TEST(FindPath, names_both_bodies_the_point_and_what_was_tried) {
  Scene scene(test::bare_machine());
  scene.add(box("gate", {6, 1000, 200}, {100, 100, 100}));
  const auto path = find_path(scene, at(10, 100, 10), at(250, 100, 10), {.clearance_mm = 2, .approaches = {}});
  ASSERT_FALSE(path);
  EXPECT_EQ(path.error().fault, Fault::Collision);
  for (const char* part : {"camera comes within 2 mm of gate at (97.00,", "straight (free for", "Z would have to go to",
                           "90.00 mm", "around (there is no path"})
    EXPECT_NE(path.error().message.find(part), std::string::npos) << path.error().message;
}

TEST(FindPath, goes_around_a_wall_with_an_open_end) {
  Scene scene(test::bare_machine());
  scene.add(box("gate", {6, 400, 200}, {100, 100, 100}));  // ends at y 300, the machine at 350
  const PathRules rules{.clearance_mm = 2, .approaches = {}};
  const auto path = find_path(scene, at(10, 100, 10, 0), at(250, 100, 10, 5), rules);
  ASSERT_TRUE(path) << path.error().message;
  EXPECT_EQ(path->kind, PathKind::Detour);
  EXPECT_EQ(path->points.front(), at(10, 100, 10, 0));
  EXPECT_EQ(path->points.back(), at(250, 100, 10, 5));
  EXPECT_GE(path->certificate.nearest.others.distance_mm, 2);
  EXPECT_EQ(find_path(scene, at(10, 100, 10, 0), at(250, 100, 10, 5), rules)->points, path->points);
}

/// By hand: the camera's top is 110 above the tip, the lintel's lower side at 140, and 2 are to be kept: 28 at most.
TEST(FindPath, goes_no_lower_than_wet_deposits_let_it) {
  Scene scene(test::bare_machine());
  scene.add(box("lintel", {6, 1000, 400}, {150, 100, 340}));
  const AxisVec from = at(10, 100, 40), to = at(250, 100, 40);
  PathRules rules{.clearance_mm = 2, .approaches = {}};
  for (const auto& [lowest, passes] : {std::pair{std::optional<double>(), true}, {20.0, true}, {30.0, false}}) {
    rules.lowest_mm = lowest;
    const auto path = find_path(scene, from, to, rules);
    ASSERT_EQ(path.has_value(), passes);
    if (!passes) {
      EXPECT_NE(path.error().message.find("with Z no lower than 30.00 mm, where it is above wet deposits"),
                std::string::npos)
          << path.error().message;
      continue;
    }
    for (const AxisVec& q : path->points) EXPECT_GE(q[2], lowest.value_or(0)) << "while 28 is enough";
  }
  // An end may be lower than that.
  rules.lowest_mm = 60;
  EXPECT_TRUE(find_path(scene, at(10, 100, 20), to, rules));
}

TEST(FindPath, says_when_its_end_itself_is_taken) {
  Scene scene(test::bare_machine());
  scene.add(box("clamp", {20, 20, 30}, {200, 100, 15}));
  const auto path = find_path(scene, at(10, 100, 40), at(200, 100, 10), {.clearance_mm = 2, .approaches = {}});
  ASSERT_FALSE(path);
  EXPECT_NE(path.error().message.find("where the motion ends, needle comes within 2 mm of clamp"), std::string::npos)
      << path.error().message;
}

TEST(FindPath, refuses_goals_beyond_an_axis_and_numbers_that_are_none) {
  const Scene scene(test::bare_machine());
  const auto far = find_path(scene, at(0, 0, 10), at(451, 0, 10), {});
  ASSERT_FALSE(far);
  EXPECT_EQ(far.error().fault, Fault::OutOfReach);
  EXPECT_NE(far.error().message.find("axis X would go to 451.000"), std::string::npos);
  EXPECT_EQ(find_path(scene, at(0, 0, 10), at(0, std::nan(""), 10), {}).error().fault, Fault::OutOfReach);
}

/// Where homing leaves axes may be beyond their limits; the judge are closed forms.
TEST(FindPath, goes_around_from_where_an_axis_stands_beyond_its_limits) {
  const config::Machine m = test::bare_machine();
  const config::Body tower = box("tower", {10, 60, 400}, {40, 0, 0});
  Scene scene(m);
  scene.add(tower);
  AxisVec from = at(-50.6, -50.3, 50), to = at(150, -40, 50);
  from[3] = -3.25;
  const auto path = find_path(scene, from, to, {.clearance_mm = 2, .approaches = {}});
  ASSERT_TRUE(path) << path.error().message;
  EXPECT_EQ(path->kind, PathKind::Detour);
  EXPECT_EQ(path->points.front(), from);
  EXPECT_EQ(path->points.back(), to);
  for (std::size_t i = 0; i + 1 < path->points.size(); ++i) {
    const AxisVec &p = path->points[i], &q = path->points[i + 1];
    for (std::size_t axis = 0; i > 0 && axis < m.axes.size(); ++axis) {
      EXPECT_GE(p[axis], m.axes[axis].p_min);
      EXPECT_LE(p[axis], m.axes[axis].p_max);
    }
    for (config::Body body : m.head) {
      body.centre = body.centre + Vec3{p[0], p[1], p[2]};
      EXPECT_GE(test::swept_distance(body, {q[0] - p[0], q[1] - p[1], q[2] - p[2]}, tower), 2) << body.name;
    }
  }
}

TEST(FindPath, standing_still_is_a_path_of_its_own) {
  const Scene scene(test::bare_machine());
  const auto path = find_path(scene, at(5, 5, 10), at(5, 5, 10), {});
  ASSERT_TRUE(path);
  EXPECT_EQ(path->kind, PathKind::Standstill);
}

TEST(Certify, covers_what_the_path_may_be_off_its_chords_and_names_the_motion_that_fails) {
  Scene scene(test::bare_machine());
  scene.add(box("board", {120, 80, 2}, {100, 100, 1}));
  scene.add(box("part C3", {4, 4, 3}, {80, 90, 3.5}));
  ClearanceRules rules{.clearance_mm = 1, .approaches = {{"needle", "board", 0.23 - 0.5}}};
  const double z = 2.25;
  const std::vector<AxisVec> bead{at(84.2, 80, z), at(84.2, 120, z), at(120, 120, z)};  // 1.7 mm from the part
  const auto proof = certify(scene, bead, rules, 0.5);
  ASSERT_TRUE(proof) << proof.error().message;
  EXPECT_EQ(proof->motions, 2U);
  EXPECT_NEAR(proof->nearest.by_design.distance_mm, 0.25, 1e-6);  // needle over board, as asked
  EXPECT_NEAR(proof->nearest.others.distance_mm, 1.7, 1e-6);      // needle beside the part
  EXPECT_EQ(scene.standing()[proof->nearest.others.standing].name, "part C3");
  EXPECT_EQ(proof->nearest.others.motion, 0U);
  rules.approaches.front().clearance_mm = 0.23;
  const auto low = certify(scene, bead, rules, 0.021);
  ASSERT_FALSE(low) << "an approach is no nearer than it says, off the chords as well";
  EXPECT_NE(low.error().message.find("of board"), std::string::npos) << low.error().message;
  EXPECT_TRUE(certify(scene, bead, rules, 0.019));
  rules.approaches.front().clearance_mm = -1;
  const auto wide = certify(scene, bead, rules, 0.8);
  ASSERT_FALSE(wide);
  EXPECT_EQ(wide.error().fault, Fault::Collision);
  EXPECT_NE(wide.error().message.find("needle comes within 1.8 mm of part C3"), std::string::npos)
      << wide.error().message;
  EXPECT_NE(wide.error().message.find("along motion 1 of 2"), std::string::npos) << wide.error().message;
}

TEST(Scene, hash_changes_with_any_body) {
  Scene a(test::bare_machine()), b(test::bare_machine());
  EXPECT_EQ(a.hash(), b.hash());
  a.add(box("part", {1, 2, 3}, {4, 5, 6}));
  EXPECT_NE(a.hash(), b.hash());
  b.add(box("part", {1, 2, 3}, {4, 5, 6.001}));
  EXPECT_NE(a.hash(), b.hash());
}

}  // namespace
}  // namespace gantry::motion
