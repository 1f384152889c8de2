#include "sim/world/collisions.hpp"

#include <algorithm>
#include <gtest/gtest.h>
#include <random>

#include "tests/sim/world/sample.hpp"

namespace gantry::sim {
namespace {

using Kind = config::Shape::Kind;

/// Judge for upright bodies: their heights overlap, and so do their footprints (circle against turned rectangle).
bool cylinder_meets_box(const Solid& cylinder, const Solid& box) {
  const double r = cylinder.shape.size.x / 2;
  if (std::abs(cylinder.centre.z - box.centre.z) > (cylinder.shape.size.z + box.shape.size.z) / 2) return false;
  const Vec2 d = rotated({cylinder.centre.x - box.centre.x, cylinder.centre.y - box.centre.y}, -box.rotation_rad);
  const Vec2 out{std::max(std::abs(d.x) - box.shape.size.x / 2, 0.0),
                 std::max(std::abs(d.y) - box.shape.size.y / 2, 0.0)};
  return norm(out) <= r;
}

TEST(Overlap, of_cylinder_and_box_agrees_with_footprints_and_heights) {
  std::mt19937_64 random(21);
  std::uniform_real_distribution<double> unit(-1, 1);
  int hits = 0;
  for (int n = 0; n < 3000; ++n) {
    const Solid cylinder{
        "c", {Kind::Cylinder, {6, 6, 20}}, {8 * unit(random), 8 * unit(random), 20 * unit(random)}, 0, {}};
    const Solid box{"b", {Kind::Box, {10, 5, 14}}, {0, 0, 0}, 3 * unit(random), {}};
    const bool expected = cylinder_meets_box(cylinder, box);
    // Within 1e-6 mm of touching either answer is right.
    Solid smaller = cylinder, larger = cylinder;
    smaller.shape.size = {6 - 1e-5, 6 - 1e-5, 20 - 1e-5};
    larger.shape.size = {6 + 1e-5, 6 + 1e-5, 20 + 1e-5};
    if (cylinder_meets_box(smaller, box) != cylinder_meets_box(larger, box)) continue;
    EXPECT_EQ(overlap(OverlapShape(cylinder.shape), cylinder, OverlapShape(box.shape), box), expected) << "case " << n;
    hits += expected;
  }
  EXPECT_GT(hits, 300);
}

class Watching : public testing::Test {
 protected:
  Watching() : machine(sample::machine()), head(machine), watch(head) {
    watch.set_solids(solids_of(machine.scene, nullptr));
  }
  std::vector<std::string> go(const AxisVec& a, const AxisVec& b, int ticks) {
    std::vector<std::string> out;
    for (int k = 0; k < ticks; ++k) {
      AxisVec p = a, q = a;
      for (std::size_t i = 0; i < q.size(); ++i) {
        p[i] += (b[i] - a[i]) * k / ticks;
        q[i] += (b[i] - a[i]) * (k + 1) / ticks;
      }
      for (const Contact& c : watch.step(p, q, 0.001)) {
        out.push_back(std::string(c.moving) + "/" + std::string(c.standing));
        at = c.at;
      }
    }
    return out;
  }
  config::Machine machine;
  Head head;
  CollisionWatch watch;
  Vec3 at;
};

TEST_F(Watching, a_pass_through_a_post_counts_once_and_says_where) {
  // The needle's tip at z = 20 crosses the post (radius 10, top 60) at y = 250.
  const AxisVec a = sample::tool_at(machine, "needle", {300, 250, 20}),
                b = sample::tool_at(machine, "needle", {400, 250, 20});
  AxisVec from = a, to = b;
  from[4] = to[4] = 0;
  const auto hits = go(from, to, 500);
  ASSERT_GE(hits.size(), 1u);
  EXPECT_EQ(std::count(hits.begin(), hits.end(), "needle/post"), 1);
  const auto again = go(to, from, 500);
  EXPECT_EQ(std::count(again.begin(), again.end(), "needle/post"), 1) << "apart in between: a new contact";
}

TEST_F(Watching, a_fast_move_does_not_jump_over_a_thin_wall) {
  watch.set_solids({{"wall", {Kind::Box, {0.3, 100, 40}}, {200, 100, 20}, 0, {}}});
  AxisVec a = sample::tool_at(machine, "needle", {195, 100, 20}),
          b = sample::tool_at(machine, "needle", {205, 100, 20});
  const auto hits = go(a, b, 2);  // 5 mm a tick
  ASSERT_EQ(std::count(hits.begin(), hits.end(), "needle/wall"), 1);
  EXPECT_NEAR(at.x, 200, 0.7);
}

TEST_F(Watching, travel_over_everything_is_free_and_resting_contact_is_not_counted_again) {
  AxisVec a = sample::tool_at(machine, "needle", {20, 20, 70}), b = sample::tool_at(machine, "needle", {390, 280, 70});
  EXPECT_TRUE(go(a, b, 400).empty());
  const AxisVec above = sample::tool_at(machine, "needle", {100, 100, 1}),
                in = sample::tool_at(machine, "needle", {100, 100, -0.5});
  EXPECT_EQ(go(above, in, 30), std::vector<std::string>{"needle/pallet"});
  EXPECT_TRUE(go(in, in, 20).empty());
  const AxisVec aside = sample::tool_at(machine, "needle", {110, 100, -0.5});
  EXPECT_TRUE(go(in, aside, 100).empty()) << "still the same contact";
}

TEST_F(Watching, the_probe_may_touch_slowly_but_not_fast_deep_or_sideways) {
  const AxisVec above = sample::tool_at(machine, "probe", {200, 100, 2}),
                touch = sample::tool_at(machine, "probe", {200, 100, -0.3}),
                deep = sample::tool_at(machine, "probe", {200, 100, -2.6}),
                aside = sample::tool_at(machine, "probe", {200.2, 100, -0.3});
  EXPECT_TRUE(go(above, touch, 460).empty()) << "5 mm/s";
  EXPECT_TRUE(go(touch, above, 100).empty());
  EXPECT_EQ(go(above, touch, 40), std::vector<std::string>{"probe/pallet"}) << "57 mm/s";
  go(touch, above, 100);
  EXPECT_EQ(go(above, deep, 920), std::vector<std::string>{"probe/pallet"}) << "beyond its spring";
  go(deep, above, 1000);
  go(above, touch, 460);
  EXPECT_EQ(go(touch, aside, 200), std::vector<std::string>{"probe/pallet"}) << "dragged";
}

TEST_F(Watching, a_slow_touch_that_a_host_held_up_and_made_up_for_is_a_slow_touch) {
  const auto at_height = [&](double z) { return sample::tool_at(machine, "probe", {200, 100, z}); };
  EXPECT_TRUE(go(at_height(0.6), at_height(0.05), 110).empty()) << "5 mm/s";
  EXPECT_TRUE(go(at_height(0.05), at_height(0.05), 29).empty()) << "29 ms without a frame";
  EXPECT_TRUE(go(at_height(0.05), at_height(-0.1), 1).empty()) << "and all of it at once";
  go(at_height(-0.1), at_height(0.6), 200);
  go(at_height(0.6), at_height(0.05), 110);
  EXPECT_EQ(go(at_height(0.05), at_height(-0.5), 1), std::vector<std::string>{"probe/pallet"})
      << "more than was missed";
}

TEST_F(Watching, every_hit_of_random_straight_moves_agrees_with_fine_sampling) {
  // Judge: the same overlap question asked every 0.01 mm, for the syringe (a cylinder) against boxes by footprint.
  std::mt19937_64 random(77);
  std::uniform_real_distribution<double> unit(-1, 1);
  int hits = 0, checked = 0;
  for (int n = 0; n < 200; ++n) {
    const std::string name = "box " + std::to_string(n);
    const Solid box{name, {Kind::Box, {20, 12, 30}}, {0, 0, 0}, unit(random), {}};
    watch.set_solids({box});
    const Vec3 a{40 * unit(random), 40 * unit(random), 10 * unit(random)},
        b{40 * unit(random), 40 * unit(random), 10 * unit(random)};
    bool expected = false, close = false;
    const int samples = static_cast<int>(norm(b - a) / 0.01) + 1;
    for (int k = 0; k <= samples; ++k) {
      Solid c{"syringe", {Kind::Cylinder, {20, 20, 60}}, a + (b - a) * (static_cast<double>(k) / samples), 0, {}};
      expected |= cylinder_meets_box(c, box);
      c.shape.size = {20.05, 20.05, 60};
      close |= cylinder_meets_box(c, box);
    }
    if (expected != close) continue;  // a graze of less than what 0.2 mm steps can see
    ++checked;
    AxisVec p{}, q{};  // the syringe's centre is at (0, 0, -40)
    p[0] = a.x, p[1] = a.y, p[2] = a.z + 40, q[0] = b.x, q[1] = b.y, q[2] = b.z + 40;
    const auto found = go(p, q, 25);
    EXPECT_EQ(std::count(found.begin(), found.end(), "syringe/" + name) > 0, expected) << "case " << n;
    hits += expected;
  }
  EXPECT_GT(hits, 40);
  EXPECT_GT(checked, 150);
}

/// Judge: the arm's corners and the pole's outline, asked every 0.0002 rad; the pole is a cylinder, the arm a box.
TEST_F(Watching, what_turns_with_c_hits_what_fine_sampling_says) {
  machine.c = AxisId{3};
  machine.head = {{"arm", {Kind::Box, {40, 6, 8}}, {30, 4, -20}, 0.3, false, true}};
  const Head turning(machine);
  const Vec3 tip = config::find_tool(machine, "needle")->tip;
  std::mt19937_64 random(78);
  std::uniform_real_distribution<double> unit(-1, 1);
  int hits = 0, free = 0;
  for (int n = 0; n < 300; ++n) {
    CollisionWatch one(turning);
    const Solid pole{"pole", {Kind::Cylinder, {6, 6, 20}}, {45 * unit(random), 45 * unit(random), -20}, 0, {}};
    one.set_solids({pole});
    AxisVec p{}, q{};
    p[0] = 10 * unit(random), p[1] = 10 * unit(random), p[3] = 3 * unit(random);
    q = p, q[3] = 3 * unit(random);
    if (n % 2 == 0) q[0] += 15 * unit(random), q[1] += 15 * unit(random);
    bool expected = false, close = false;
    const int samples =
        1 + static_cast<int>(std::abs(q[3] - p[3]) / 0.0002 + std::hypot(q[0] - p[0], q[1] - p[1]) / 0.01);
    for (int k = 0; k <= samples; ++k) {
      const AxisVec now = between(p, q, static_cast<double>(k) / samples);
      const Vec2 centre = rotated({30 - tip.x, 4 - tip.y}, now[3]);
      Solid arm{"arm",
                {Kind::Box, {40, 6, 8}},
                {now[0] + tip.x + centre.x, now[1] + tip.y + centre.y, -20},
                0.3 + now[3],
                {}};
      expected |= cylinder_meets_box(pole, arm);
      arm.shape.size = {40.3, 6.3, 8};
      close |= cylinder_meets_box(pole, arm);
    }
    if (expected != close) continue;  // a graze of less than what 0.2 mm steps can see
    bool met = false;
    const int ticks = n % 3 == 0 ? 1 : 40;
    for (int k = 0; k < ticks; ++k)
      met |= !one.step(between(p, q, static_cast<double>(k) / ticks), between(p, q, static_cast<double>(k + 1) / ticks),
                       0.001)
                  .empty();
    EXPECT_EQ(met, expected) << "case " << n;
    (expected ? hits : free) += 1;
  }
  EXPECT_GT(hits, 60);
  EXPECT_GT(free, 60);
}

TEST(Head, a_bent_needle_that_turns_takes_its_tip_round) {
  config::Machine machine = sample::machine();
  machine.c = AxisId{3};
  machine.sim.needle_error = {0.4, 0, 0};
  for (config::Body& body : machine.head) body.on_turn = body.name == "needle";
  const Head head(machine);
  const Vec3 nominal = config::find_tool(machine, "needle")->tip;
  AxisVec q{};
  q[3] = 1.5707963267948966;
  EXPECT_NEAR(head.in_machine(head.needle, q).x, nominal.x, 1e-9);
  EXPECT_NEAR(head.in_machine(head.needle, q).y, nominal.y + 0.4, 1e-9);
  for (config::Body& body : machine.head) body.on_turn = false;
  const Head still(machine);
  EXPECT_NEAR(still.in_machine(still.needle, q).x, nominal.x + 0.4, 1e-9);
}

}  // namespace
}  // namespace gantry::sim
