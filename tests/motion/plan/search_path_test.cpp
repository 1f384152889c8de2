// Paths where they are hard to find, and proofs that there is none: slots of a millimetre and less, pockets, bridges,
// foils. Each path is judged by samples 0.05 mm apart with closed forms that share nothing with the planner.
#include "motion/plan/search_path.hpp"

#include <chrono>
#include <gtest/gtest.h>
#include <random>

#include "motion/plan/certificate.hpp"
#include "tests/motion/plan/prism_distance.hpp"

namespace gantry::motion {
namespace {

using config::Body;
using Form = config::Shape::Kind;

Body box(std::string name, Vec3 low, Vec3 high, double yaw_deg = 0) {
  return {std::move(name), {Form::Box, high - low}, (low + high) * 0.5, yaw_deg * 3.14159265358979323846 / 180, false};
}
Body needle(double diameter = 0.2) {
  return {"needle", {Form::Capsule, {diameter, diameter, 30}}, {0, 0, 15}, 0, false};
}
Body syringe(double diameter = 20) {
  return {"syringe", {Form::Cylinder, {diameter, diameter, 40}}, {0, 0, 50}, 0, false};
}

config::Machine space(Vec3 low, Vec3 high, double clearance_mm, std::vector<Body> head) {
  config::Machine m;
  const char* const names[] = {"X", "Y", "Z"};
  for (std::uint8_t i = 0; i < 3; ++i) {
    config::Axis a;
    a.id = AxisId{i}, a.name = names[i];
    a.p_min = i == 0 ? low.x : i == 1 ? low.y : low.z, a.p_max = i == 0 ? high.x : i == 1 ? high.y : high.z;
    m.axes.push_back(a);
  }
  m.x = AxisId{0}, m.y = AxisId{1}, m.z = AxisId{2};
  m.clearance_mm = clearance_mm, m.head = std::move(head);
  return m;
}

struct Case {
  explicit Case(config::Machine machine) : m(std::move(machine)) {}
  config::Machine m;
  SearchAnswer search(Vec3 from, Vec3 to) const {
    const Scene scene(m);
    const auto start = std::chrono::steady_clock::now();
    SearchAnswer out = search_path(scene, {from.x, from.y, from.z}, {to.x, to.y, to.z}, {m.clearance_mm, {}});
    const double s = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    std::printf("  %s: status %d, closed in %d, %zu points, %.2f mm, %.1f ms\n",
                testing::UnitTest::GetInstance()->current_test_info()->name(), static_cast<int>(out.status),
                static_cast<int>(out.closed_in), out.points.size(), out.length_mm, 1e3 * s);
    if (out.status == SearchStatus::Ok) judge(scene, out, from, to);
    return out;
  }
  void judge(const Scene& scene, const SearchAnswer& found, Vec3 from, Vec3 to) const {
    ASSERT_GE(found.points.size(), 2U);
    EXPECT_EQ(found.points.front(), (AxisVec{from.x, from.y, from.z}));
    EXPECT_EQ(found.points.back(), (AxisVec{to.x, to.y, to.z}));
    const auto proof = certify(scene, found.points, {m.clearance_mm, {}});
    EXPECT_TRUE(proof) << proof.error().message;
    double length = 0, least = 1e9;
    for (std::size_t i = 0; i + 1 < found.points.size(); ++i) {
      const AxisVec &p = found.points[i], &q = found.points[i + 1];
      const Vec3 a{p[0], p[1], p[2]}, d{q[0] - p[0], q[1] - p[1], q[2] - p[2]};
      length += norm(d);
      const int steps = 1 + static_cast<int>(norm(d) / 0.05);
      for (int k = 0; k <= steps; ++k)
        for (Body h : m.head) {
          h.centre = h.centre + a + d * (1.0 * k / steps);
          for (const Body& b : m.scene) least = std::min(least, test::distance(h, b));
        }
    }
    EXPECT_GT(least, m.clearance_mm);
    EXPECT_NEAR(length, found.length_mm, 1e-9 * length);
  }
};

/// A wall across the whole space with one slot, low enough for the syringe, and a beam over it that nobody gets over.
Case wall_with_slot(double slot_mm, double clearance_mm, double thickness_mm) {
  Case c(space({0, 0, 0}, {200, 150, 60}, clearance_mm, {needle(), syringe()}));
  const double y = 63.0;
  c.m.scene = {box("left", {100, -50, -20}, {100 + thickness_mm, y, 28}),
               box("right", {100, y + slot_mm, -20}, {100 + thickness_mm, 200, 28}),
               box("over", {100 - 15, -50, 72}, {100 + 15 + thickness_mm, 200, 130})};
  return c;
}

TEST(SearchPath, goes_through_a_slot_of_a_millimetre) {
  const Case c = wall_with_slot(1.0, 0.2, 20);
  const auto found = c.search({20, 30, 0.5}, {180, 120, 0.5});
  EXPECT_EQ(found.status, SearchStatus::Ok);
}
TEST(SearchPath, goes_through_a_slot_that_leaves_ten_micrometres) {
  const Case c = wall_with_slot(0.61, 0.2, 20);  // 0.2 needle + 2 x 0.2 clearance
  EXPECT_EQ(c.search({20, 30, 0.5}, {180, 120, 0.5}).status, SearchStatus::Ok);
}
TEST(SearchPath, proves_that_a_slot_of_just_the_needle_and_its_clearance_is_none) {
  const Case c = wall_with_slot(0.6, 0.2, 20);
  const auto found = c.search({20, 30, 0.5}, {180, 120, 0.5});
  EXPECT_EQ(found.status, SearchStatus::NoPath);
  EXPECT_EQ(found.closed_in, ClosedIn::Neither) << "a wall across all of it is no pocket";
}
TEST(SearchPath, goes_through_a_slanted_slot) {
  Case c = wall_with_slot(1.5, 0.2, 5);
  for (Body& b : c.m.scene) b.rotation_rad = 0.3;  // each about its own middle: another gap, no face along an axis
  const auto found = c.search({20, 30, 0.5}, {180, 120, 0.5});
  EXPECT_EQ(found.status, SearchStatus::Ok);
}

/// A box of walls, a lid over it.
Case pocket(double wall_mm, bool lid, double yaw_deg = 0, double clearance_mm = 0.1) {
  Case c(space({0, 0, 0}, {200, 150, 60}, clearance_mm, {needle()}));
  const double h = 25, w = wall_mm;
  const Vec3 m{140, 80, 0};
  const auto turned = [&](Body b) {
    const Vec2 d = rotated(Vec2{b.centre.x - m.x, b.centre.y - m.y}, yaw_deg * 3.14159265358979323846 / 180);
    b.centre.x = m.x + d.x, b.centre.y = m.y + d.y;
    b.rotation_rad = yaw_deg * 3.14159265358979323846 / 180;
    return b;
  };
  c.m.scene = {turned(box("west", {m.x - 20 - w, m.y - 20 - w, -5}, {m.x - 20, m.y + 20 + w, h})),
               turned(box("east", {m.x + 20, m.y - 20 - w, -5}, {m.x + 20 + w, m.y + 20 + w, h})),
               turned(box("south", {m.x - 20, m.y - 20 - w, -5}, {m.x + 20, m.y - 20, h})),
               turned(box("north", {m.x - 20, m.y + 20, -5}, {m.x + 20, m.y + 20 + w, h}))};
  if (lid) c.m.scene.push_back(turned(box("lid", {m.x - 20 - w, m.y - 20 - w, 35}, {m.x + 20 + w, m.y + 20 + w, 95})));
  return c;
}

TEST(SearchPath, tells_which_end_is_in_a_pocket_of_foil) {
  for (const double foil : {5.0, 0.05}) {
    const Case c = pocket(foil, true);
    auto found = c.search({20, 30, 1}, {140, 80, 1});
    EXPECT_EQ(found.status, SearchStatus::NoPath) << foil;
    EXPECT_EQ(found.closed_in, ClosedIn::Goal);
    found = c.search({140, 80, 1}, {20, 30, 1});
    EXPECT_EQ(found.status, SearchStatus::NoPath);
    EXPECT_EQ(found.closed_in, ClosedIn::Start);
  }
}
TEST(SearchPath, proves_pockets_that_stand_askew) {
  for (const double wall : {5.0, 0.3, 0.05}) {
    const Case c = pocket(wall, true, 17);
    const auto found = c.search({20, 30, 1}, {140, 80, 1});
    EXPECT_EQ(found.status, SearchStatus::NoPath) << wall;
    EXPECT_EQ(found.closed_in, ClosedIn::Goal) << wall;
  }
}
TEST(SearchPath, goes_over_the_wall_of_a_pocket_without_a_lid) {
  const Case c = pocket(0.05, false, 17);
  EXPECT_EQ(c.search({20, 30, 1}, {140, 80, 1}).status, SearchStatus::Ok);
}

TEST(SearchPath, goes_around_a_bridge_that_cannot_be_lifted_over) {
  Case c(space({0, 0, 0}, {300, 200, 60}, 1, {needle(1), syringe()}));
  c.m.scene = {box("bridge", {140, -50, 20}, {160, 150, 120})};  // its end is open at y 150
  const auto found = c.search({50, 50, 2}, {250, 50, 2});
  ASSERT_EQ(found.status, SearchStatus::Ok);
  EXPECT_LT(found.length_mm, 420);
  c.m.scene.push_back(box("closed", {140, 150, -10}, {160, 260, 120}));
  c.m.scene.push_back(box("under", {140, -50, -10}, {160, 150, 20}));
  EXPECT_EQ(c.search({50, 50, 2}, {250, 50, 2}).status, SearchStatus::NoPath);
}

TEST(SearchPath, passes_under_a_bridge_by_a_hair) {
  Case c(
      space({0, 0, 0}, {300, 200, 60}, 0.5, {needle(0.2), {"nozzle", {Form::Box, {6, 6, 8}}, {0, 0, 12}, 0.4, false}}));
  c.m.scene = {box("bridge", {140, -50, 16.51 + 3}, {160, 260, 120}), box("sill", {135, -50, -10}, {165, 260, 2.0})};
  EXPECT_EQ(c.search({50, 50, 1}, {250, 50, 1}).status, SearchStatus::NoPath);  // the needle is 30 long
  c.m.head[0] = {"needle", {Form::Capsule, {0.2, 0.2, 10}}, {0, 0, 5}, 0, false};
  EXPECT_EQ(c.search({50, 50, 1}, {250, 50, 1}).status, SearchStatus::Ok);
}

TEST(SearchPath, tells_an_end_that_collides_with_its_pair) {
  Case c(space({0, 0, 0}, {200, 150, 60}, 0.5, {needle(), syringe()}));
  c.m.scene = {box("tower", {100, 50, 0}, {120, 70, 45})};
  auto found = c.search({94, 60, 1}, {20, 20, 1});  // the syringe, 10 mm about the tip, meets the tower
  ASSERT_EQ(found.status, SearchStatus::StartCollides);
  EXPECT_EQ(found.hit->head, 1U);
  found = c.search({20, 20, 1}, {94, 60, 1});
  EXPECT_EQ(found.status, SearchStatus::GoalCollides);
  found = c.search({20, 20, 1}, {20, 20, 61});
  EXPECT_EQ(found.status, SearchStatus::GoalCollides);
  EXPECT_EQ(found.beyond, 2U);
}

/// Posts of the pitch of the needle: only cylinders, no flat face anywhere.
TEST(SearchPath, finds_and_refuses_gaps_between_posts) {
  for (const double gap : {0.8, 0.55, 0.45}) {
    Case c(space({0, 0, 0}, {100, 80, 20}, 0.15, {needle(0.2)}));
    const double pitch = 4 + gap;
    for (int i = -10; i < 40; ++i) {
      const double y = i * pitch;
      c.m.scene.push_back({"post " + std::to_string(i), {Form::Cylinder, {4, 4, 100}}, {50, y, 10}, 0, false});
    }
    const auto found = c.search({10, 10, 1}, {90, 70, 1});
    EXPECT_EQ(found.status, gap > 0.5 ? SearchStatus::Ok : SearchStatus::NoPath) << gap;
  }
}

/// Three walls whose slots lie apart: a maze for chance, a walk for cells.
TEST(SearchPath, walks_through_a_row_of_slots) {
  Case c(space({0, 0, 0}, {200, 150, 20}, 0.2, {needle(0.2)}));
  for (int i = 0; i < 3; ++i) {
    const double x = 50.0 + 40 * i, y = i % 2 == 0 ? 20 : 120;
    c.m.scene.push_back(box("a" + std::to_string(i), {x, -50, -10}, {x + 8, y, 100}));
    c.m.scene.push_back(box("b" + std::to_string(i), {x, y + 1, -10}, {x + 8, 250, 100}));
  }
  EXPECT_EQ(c.search({10, 70, 1}, {190, 70, 1}).status, SearchStatus::Ok);
}

/// Parts in contact leave no path between them, whatever the numbers round to.
TEST(SearchPath, finds_no_path_between_parts_in_contact) {
  Case c(space({0, 0, 0}, {200, 90, 30}, 0, {{"point", {Form::Capsule, {0.2, 0.2, 0.2}}, {0, 0, 0.1}, 0, false}}));
  for (int i = 0; i < 10; ++i)
    for (int k = 0; k < 4; ++k)
      c.m.scene.push_back(box("brick " + std::to_string(4 * i + k), {100, 0.1 + 10.0 * i - 5, 10.0 * k - 5},
                              {110, 0.1 + 10.0 * (i + 1) - 5, 10.0 * (k + 1) - 5}));
  const auto found = c.search({20, 30, 1}, {180, 30, 1});
  EXPECT_EQ(found.status, SearchStatus::NoPath);
}

/// Boxes askew and cylinders over 400 x 300 mm, none nearer than `away_mm` to `keep`.
std::vector<Body> clutter(int count, Vec2 keep, double away_mm) {
  std::mt19937_64 random(17);
  const auto real = [&](double low, double high) { return std::uniform_real_distribution<double>(low, high)(random); };
  const double size = std::min(30.0, 260 / std::sqrt(count));
  std::vector<Body> out;
  while (static_cast<int>(out.size()) < count) {
    const double h = real(2, 30);
    Body b{"part " + std::to_string(out.size()), {Form::Box, {0, 0, h}}, {real(0, 400), real(0, 300), h / 2}, 0, false};
    b.shape.size.x = real(0.3, 1) * size, b.shape.size.y = real(0.3, 1) * size;
    if (out.size() % 3 == 0)
      b.shape.kind = Form::Cylinder, b.shape.size.y = b.shape.size.x;
    else
      b.rotation_rad = real(0, 3);
    if (std::hypot(b.centre.x - keep.x, b.centre.y - keep.y) > away_mm) out.push_back(b);
  }
  return out;
}
Case among(std::vector<Body> sealed, int parts, Vec2 keep, double away_mm) {
  Case c(space({0, 0, 0}, {400, 300, 100}, 0.3, {needle()}));
  c.m.scene = std::move(sealed);
  for (Body& b : clutter(parts, keep, away_mm)) c.m.scene.push_back(std::move(b));
  return c;
}
/// Iterations, which do not depend on the host; 10,000 of them take 0.1 s where it is slow.
constexpr std::size_t kFewCuts = 10000;

TEST(SearchPath, proves_a_pocket_askew_among_many_bodies) {
  const Vec3 out{20, 20, 60}, in{200, 150, 2};
  for (const int parts : {0, 20, 200, 2000})
    for (const double foil : {0.05, 2.0}) {
      std::vector<Body> walls;
      for (const Vec2 d : {Vec2{1, 0}, Vec2{-1, 0}, Vec2{0, 1}, Vec2{0, -1}}) {
        const Vec2 at = rotated(d * 12, 0.576);
        const double x = d.x != 0 ? foil : 24 + foil, y = d.x != 0 ? 24 + foil : foil;
        walls.push_back({"wall " + std::to_string(walls.size()),
                         {Form::Box, {x, y, 60}},
                         {in.x + at.x, in.y + at.y, 20},
                         0.576,
                         false});
      }
      walls.push_back({"lid", {Form::Box, {24 + foil, 24 + foil, foil}}, {in.x, in.y, 50}, 0.576, false});
      const Case c = among(walls, parts, {in.x, in.y}, 40);
      for (const bool inwards : {true, false}) {
        const auto found = inwards ? c.search(out, in) : c.search(in, out);
        EXPECT_EQ(found.status, SearchStatus::NoPath) << parts << " parts, foil of " << foil;
        EXPECT_EQ(found.closed_in, inwards ? ClosedIn::Goal : ClosedIn::Start) << parts << " parts, foil of " << foil;
        EXPECT_LT(found.cuts, kFewCuts);
      }
    }
}
TEST(SearchPath, proves_a_ring_of_posts_among_many_bodies) {
  const Vec3 out{20, 20, 60}, in{200, 150, 2};
  for (const int parts : {0, 20, 200, 2000}) {
    std::vector<Body> posts;  // 3.14 mm apart, 2.6 mm thick: no room for needle and clearance
    for (int i = 0; i < 50; ++i) {
      const Vec2 at = rotated(Vec2{25, 0}, i * 2 * 3.14159265358979323846 / 50);
      posts.push_back(
          {"post " + std::to_string(i), {Form::Cylinder, {2.6, 2.6, 250}}, {in.x + at.x, in.y + at.y, 100}, 0, false});
    }
    const Case c = among(posts, parts, {in.x, in.y}, 50);
    for (const bool inwards : {true, false}) {
      const auto found = inwards ? c.search(out, in) : c.search(in, out);
      EXPECT_EQ(found.status, SearchStatus::NoPath) << parts;
      EXPECT_EQ(found.closed_in, inwards ? ClosedIn::Goal : ClosedIn::Start) << parts;
      EXPECT_LT(found.cuts, kFewCuts);
    }
  }
}
/// From such a wall on there is room on both sides of it, however near it stands to one side of the workspace.
TEST(SearchPath, proves_a_wall_from_side_to_side_which_closes_neither_end_in) {
  for (const int parts : {0, 20, 200, 2000})
    for (const double yaw : {0.0, 0.12})
      for (const double x : {40.0, 200.0}) {
        const Case c = among({{"wall", {Form::Box, {4, 800, 300}}, {x, 150, 75}, yaw, false}}, parts, {x, 150}, 0);
        const auto found = c.search({5, 290, 60}, {380, 280, 60});
        EXPECT_EQ(found.status, SearchStatus::NoPath) << parts << " parts, yaw " << yaw << ", x " << x;
        EXPECT_EQ(found.closed_in, ClosedIn::Neither) << parts << " parts, yaw " << yaw << ", x " << x;
        EXPECT_LT(found.cuts, kFewCuts);
      }
}
/// A corner of the workspace that is walled off is a pocket too.
TEST(SearchPath, tells_an_end_that_is_closed_in_by_walls_and_the_edge_of_the_workspace) {
  Case c(space({0, 0, 0}, {200, 150, 60}, 0.1, {needle()}));
  c.m.scene = {box("east", {40, -20, -5}, {42, 32, 200}), box("north", {-20, 30, -5}, {42, 32, 200})};
  auto found = c.search({150, 100, 1}, {20, 15, 1});
  EXPECT_EQ(found.status, SearchStatus::NoPath);
  EXPECT_EQ(found.closed_in, ClosedIn::Goal);
  c.m.scene.pop_back();  // now it is a wall that ends
  EXPECT_EQ(c.search({150, 20, 1}, {20, 15, 1}).status, SearchStatus::Ok);
}

/// Two walls with a gap between them, their middles `off` beside it.
void slanted_walls(Case& c, double thick, double off, double yaw) {
  for (const double side : {1.0, -1.0})
    c.m.scene.push_back({side > 0 ? "a" : "b",
                         {Form::Box, {thick, 300, 200}},
                         {100 + side * off * std::sin(yaw), 75 - side * off * std::cos(yaw), 40},
                         yaw,
                         false});
}

/// Room beyond needle and clearance in a slot that no axis is along; no face helps to find it.
TEST(SearchPath, goes_through_slanted_slots_of_a_few_micrometres) {
  for (const double room : {0.1, 0.003, 0.001})
    for (const double yaw : {0.05, 0.52, 1.5}) {
      Case c(space({0, 0, 0}, {200, 150, 30}, 0.5, {needle()}));
      const double off = (1.2 + room) / 2 + 150;
      slanted_walls(c, 3, off, yaw);
      const auto found = c.search({20, 40, 2}, {180, 100, 2});
      EXPECT_EQ(found.status, SearchStatus::Ok) << room << " mm, " << yaw;
    }
}
TEST(SearchPath, goes_through_slanted_slots_of_a_micrometre_however_deep) {
  for (const double thick : {10.0, 60.0})
    for (const double yaw : {0.05, 0.41, 1.2, 2.4}) {
      Case c(space({0, 0, 0}, {200, 150, 30}, 0.5, {needle()}));
      slanted_walls(c, thick, 1.201 / 2 + 150, yaw);
      const Vec2 ahead = rotated({thick / 2 + 15, 20}, yaw);
      for (const double side : {1.0, -1.0})
        EXPECT_EQ(
            c.search({100 - side * ahead.x, 75 - side * ahead.y, 2}, {100 + side * ahead.x, 75 + side * ahead.y, 20})
                .status,
            SearchStatus::Ok)
            << thick << " mm deep, " << yaw;
    }
  // The head's own bodies stand askew as well, unlike the walls.
  for (const double yaw : {0.41, 1.2}) {
    Case c(space({0, 0, 0}, {200, 150, 30}, 0.5, {{"block", {Form::Box, {6, 4, 30}}, {0, 0, 15}, 0.9, false}}));
    const double across = 6 * std::abs(std::sin(0.9 - yaw)) + 4 * std::abs(std::cos(0.9 - yaw));
    slanted_walls(c, 30, (across + 1.001) / 2 + 150, yaw);
    const Vec2 ahead = rotated({30, 20}, yaw);
    EXPECT_EQ(c.search({100 - ahead.x, 75 - ahead.y, 2}, {100 + ahead.x, 75 + ahead.y, 2}).status, SearchStatus::Ok);
  }
}
TEST(SearchPath, carries_the_syringe_through_a_slanted_corridor_that_leaves_it_twenty_micrometres) {
  Case c(space({0, 0, 0}, {200, 150, 30}, 0.5,
               {needle(), {"syringe", {Form::Cylinder, {16, 16, 30}}, {0, 0, 27}, 0, false}}));
  const double off = 17.02 / 2 + 150, yaw = 0.35;
  slanted_walls(c, 40, off, yaw);
  EXPECT_EQ(c.search({20, 40, 2}, {180, 100, 2}).status, SearchStatus::Ok);
}

TEST(SearchPath, is_the_same_every_time) {
  const Case c = wall_with_slot(1.0, 0.2, 20);
  const auto first = c.search({20, 30, 0.5}, {180, 120, 0.5});
  for (int i = 0; i < 100; ++i) ASSERT_EQ(c.search({20, 30, 0.5}, {180, 120, 0.5}).points, first.points);
}

}  // namespace
}  // namespace gantry::motion
