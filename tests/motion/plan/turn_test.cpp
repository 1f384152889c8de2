// Bodies of the head that turn with C: judged by closed-form distances at thousands of poses along a motion, which
// share nothing with the sweep, its pieces or its bound.
#include <cmath>
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "motion/geometry.hpp"
#include "motion/plan/certificate.hpp"
#include "motion/plan/find_path.hpp"
#include "motion/plan/search_path.hpp"
#include "motion/plan/second_opinion.hpp"
#include "motion/plan/verify.hpp"
#include "tests/motion/plan/prism_distance.hpp"
#include "tests/motion/plan/random_bodies.hpp"

namespace gantry::motion {
namespace {

using Form = config::Shape::Kind;
constexpr std::uint64_t kSeed = 20261125;

/// The bare machine with an arm, a post at the arm's end that rides on the lift, and a block askew beside the line
/// about which they turn; that line is at (3, -2), where the needle's tip is.
config::Machine turning_machine() {
  config::Machine m = test::bare_machine();
  m.axes[3].rotary = true;
  m.tools = {{"needle", {3, -2, 0}, 0}};
  m.head[0].centre = {3, -2, 10};
  m.head.push_back({"arm", {Form::Box, {40, 6, 5}}, {25, -2, 18}, 0.2, false, true});
  m.head.push_back({"lamp", {Form::Cylinder, {8, 8, 12}}, {44, 4, 8}, 0, true, true});
  m.head.push_back({"shaft", {Form::Capsule, {3, 3, 14}}, {6, 1, 12}, 0, false, true});
  return m;
}

AxisVec q(double x, double y, double z, double c, double u = 0) { return {x, y, z, c, u}; }

/// Where a body of the head is: written down again from the machine's definition.
config::Body posed(const config::Machine& m, config::Body body, const AxisVec& at) {
  if (body.on_turn) {
    const Vec2 axis{m.tools[0].tip.x, m.tools[0].tip.y}, arm{body.centre.x - axis.x, body.centre.y - axis.y};
    const double c = std::cos(at[3]), s = std::sin(at[3]);
    body.centre.x = axis.x + c * arm.x - s * arm.y, body.centre.y = axis.y + s * arm.x + c * arm.y;
    body.rotation_rad += at[3];
  }
  body.centre = body.centre + Vec3{at[0], at[1], at[2] - (body.on_lift ? at[4] : 0)};
  return body;
}

double distance_at(const config::Machine& m, const std::vector<config::Body>& parts, const AxisVec& at) {
  double best = 1e9;
  for (const config::Body& head : m.head) {
    const config::Body a = posed(m, head, at);
    for (const config::Body& b : parts) best = std::min(best, test::distance(a, b));
  }
  return best;
}

constexpr int kPoses = 1500;
/// Least distance over poses up to a share of the motion.
double sampled(const config::Machine& m, const std::vector<config::Body>& parts, const AxisVec& from, const AxisVec& to,
               double share = 1) {
  double best = 1e9;
  for (int k = 0; k <= kPoses; ++k) best = std::min(best, distance_at(m, parts, between(from, to, share * k / kPoses)));
  return best;
}
/// Between two poses no point of the head goes farther.
double step_mm(const AxisVec& from, const AxisVec& to) {
  const Vec3 d{to[0] - from[0], to[1] - from[1], std::abs(to[2] - from[2]) + std::abs(to[4] - from[4])};
  return (norm(d) + 50 * std::abs(to[3] - from[3])) / kPoses;
}

struct Case {
  std::vector<config::Body> parts;
  Scene scene;
  AxisVec from{}, to{};
  double margin_mm = 0;
};
Case random_case(test::RandomBodies& random, const config::Machine& machine, int bodies) {
  Case out{{}, Scene(machine), {}, {}, 0};
  for (int i = 0; i < bodies; ++i) {
    config::Body b = random.body(1, false);
    b.name = fmt::format("part {}", i);
    b.centre = {random.real(60, 240), random.real(60, 240), random.real(0, 26)};
    out.parts.push_back(b);
  }
  out.scene.add(out.parts);
  const auto somewhere = [&] {
    return q(random.real(80, 220), random.real(80, 220), random.real(5, 40), random.real(-3.1, 3.1),
             random.real(0, 15));
  };
  out.from = somewhere(), out.to = somewhere();
  switch (random.whole(0, 3)) {
    case 0: out.to = out.from, out.to[3] = random.real(-3.1, 3.1); break;  // C alone
    case 1: out.to[2] = out.from[2], out.to[4] = out.from[4]; break;
    case 2: out.to[0] = out.from[0] + random.real(-20, 20), out.to[1] = out.from[1] + random.real(-20, 20); break;
    default: break;
  }
  out.margin_mm = random.real(0, 2);
  return out;
}

TEST(Turn, free_and_hit_are_what_poses_along_the_motion_say) {
  test::RandomBodies random(kSeed);
  const config::Machine machine = turning_machine();
  int free = 0, hits = 0, narrow = 0;
  for (int n = 0; n < 600; ++n) {
    const Case c = random_case(random, machine, 7);
    const Margins margins{c.margin_mm, {}};
    Proof proof;
    const auto hit = first_hit(c.scene, c.from, c.to, margins, &proof);
    ASSERT_EQ(is_clear(c.scene, c.from, c.to, margins), !hit) << "case " << n << " seed " << kSeed;
    const double truth = sampled(machine, c.parts, c.from, c.to);
    if (!hit) {
      ++free;
      narrow += truth < c.margin_mm + 1;
      ASSERT_GT(truth, c.margin_mm) << "case " << n << " seed " << kSeed;
      ASSERT_TRUE(is_free(c.scene, c.from, c.to, proof, margins)) << "case " << n;
      continue;
    }
    ++hits;
    ASSERT_LT(truth, c.margin_mm + step_mm(c.from, c.to) + 2.1 * kTurn_mm) << "case " << n << " seed " << kSeed;
    const AxisVec there = between(c.from, c.to, hit->fraction);
    if (hit->fraction > 0) {
      ASSERT_GT(sampled(machine, c.parts, c.from, c.to, hit->fraction), c.margin_mm - 1e-8) << "case " << n;
    }
    if (distance_at(machine, c.parts, c.from) > c.margin_mm) {
      ASSERT_LT(distance_at(machine, c.parts, there), c.margin_mm + 3 * kTurn_mm) << "case " << n;
    }
  }
  EXPECT_GT(free, 80);
  EXPECT_GT(hits, 80);
  EXPECT_GT(narrow, 20) << "of the free ones some must be near";
}

/// Judge of the second check: a proof of another motion, in other pieces, or with a piece left out proves nothing.
TEST(Turn, the_second_check_is_not_fooled) {
  test::RandomBodies random(kSeed + 1);
  const config::Machine machine = turning_machine();
  int pieces = 0, lies = 0;
  for (int n = 0; n < 400; ++n) {
    const Case c = random_case(random, machine, 8);
    const Margins margins{c.margin_mm, {}};
    Proof proof;
    if (first_hit(c.scene, c.from, c.to, margins, &proof)) continue;
    const auto part = std::find_if(proof.begin(), proof.end(), [](const Separation& s) { return s.upto < 1; });
    if (part == proof.end()) continue;
    ++pieces;
    Proof as_one = proof;
    for (Separation& s : as_one) s.upto = 1;
    EXPECT_FALSE(is_free(c.scene, c.from, c.to, as_one, margins)) << "the pieces' planes said to hold of all of it";
    Proof without = proof;
    std::erase_if(without, [&](const Separation& s) { return s.head == part->head && s.upto == 1; });
    EXPECT_FALSE(is_free(c.scene, c.from, c.to, without, margins)) << "the last piece is missing";
    Proof backwards = proof;
    const double upto = part->upto;
    for (Separation& s : backwards)
      if (s.head == part->head && s.upto == upto) s.upto = -upto;
    EXPECT_FALSE(is_free(c.scene, c.from, c.to, backwards, margins));
    // The planes of this turn for one that goes on: wherever that meets something, they must not be believed.
    AxisVec farther = c.to;
    farther[3] += farther[3] > c.from[3] ? 1.5 : -1.5;
    if (sampled(machine, c.parts, c.from, farther) >= c.margin_mm) continue;
    ++lies;
    EXPECT_FALSE(is_free(c.scene, c.from, farther, proof, margins)) << "case " << n << " seed " << kSeed;
  }
  EXPECT_GT(pieces, 60);
  EXPECT_GT(lies, 15);
}

TEST(Turn, the_nearest_pair_is_found_to_a_hundredth_of_a_millimetre) {
  test::RandomBodies random(kSeed + 2);
  const config::Machine machine = turning_machine();
  int seen = 0;
  for (int n = 0; n < 200; ++n) {
    const Case c = random_case(random, machine, 8);
    const auto proved = certify(c.scene, std::array{c.from, c.to}, {0, {}});
    if (!proved) continue;
    ++seen;
    const double truth = sampled(machine, c.parts, c.from, c.to), told = proved->nearest.others.distance_mm;
    EXPECT_LT(told, truth + 1e-9) << "never told larger than it is";
    EXPECT_GT(told, truth - step_mm(c.from, c.to) - 0.011) << "case " << n << " seed " << kSeed;
    EXPECT_LT(distance_at(machine, c.parts, between(c.from, c.to, proved->nearest.others.fraction)), told + 0.05);
  }
  EXPECT_GT(seen, 60);
}

TEST(Turn, a_body_that_is_round_about_the_axis_itself_does_not_turn) {
  config::Machine machine = turning_machine();
  for (config::Body& body : machine.head) body.on_turn = body.name == "needle";
  const Scene scene(machine);
  EXPECT_FALSE(scene.turns());
  Scene other(turning_machine());
  EXPECT_TRUE(other.turns());
  EXPECT_NE(scene.hash(), other.hash());
}

/// The arm (42 mm long) stands across a slot of 20 mm: through it only with the arm along.
TEST(Turn, a_path_turns_the_arm_where_the_slot_asks_for_it) {
  config::Machine machine = test::bare_machine();
  machine.axes[2].p_max = 12;  // no way over the walls
  machine.tools = {{"needle", {0, 0, 0}, 0}};
  machine.head = {{"needle", {Form::Capsule, {1, 1, 20}}, {0, 0, 10}, 0, false},
                  {"arm", {Form::Box, {42, 4, 4}}, {21, 0, 8}, 0, false, true}};
  const std::vector<config::Body> parts{test::box("left", {500, 300, 60}, {-50, 150, 30}),
                                        test::box("right", {500, 300, 60}, {470, 150, 30})};
  Scene scene(machine);
  scene.add(parts);
  const AxisVec from = q(210, -45, 2, 0), to = q(210, 345, 2, 0);
  const Margins margins{0.5, {}};
  EXPECT_TRUE(first_hit(scene, from, to, margins)) << "the arm lies across";
  const SearchAnswer found = search_path(scene, from, to, margins);
  ASSERT_EQ(found.status, SearchStatus::Ok);
  EXPECT_TRUE(certify(scene, found.points, {0.5, {}}));
  double most_rad = 0;
  for (std::size_t i = 0; i + 1 < found.points.size(); ++i) {
    most_rad = std::max(most_rad, std::abs(found.points[i + 1][3]));
    EXPECT_GT(sampled(machine, parts, found.points[i], found.points[i + 1]), 0.5);
  }
  EXPECT_GT(most_rad, 1.3) << "90 degrees, less what the slot leaves";
  EXPECT_EQ(found.points, search_path(scene, from, to, margins).points);
}

/// Along one corridor the arm has to lie as along the next it cannot: C has to turn where they meet.
TEST(Turn, a_path_turns_the_arm_on_the_way) {
  config::Machine machine = test::bare_machine();
  machine.axes[2].p_max = 12;
  machine.tools = {{"needle", {0, 0, 0}, 0}};
  machine.head = {{"needle", {Form::Capsule, {1, 1, 20}}, {0, 0, 10}, 0, false},
                  {"arm", {Form::Box, {40, 4, 4}}, {20, 0, 8}, 0, false, true}};
  // A corridor along Y at x = 100, from y = 0 to 150, and one along X at y = 175, from x = 150 on; 30 mm wide each.
  const std::vector<config::Body> parts{
      test::box("left", {285, 600, 60}, {85 - 285 / 2.0, 150, 30}), test::box("below", {600, 500, 60}, {415, -90, 30}),
      test::box("above", {600, 600, 60}, {450, 490, 30}), test::box("cap", {300, 100, 60}, {100, 290, 30})};
  Scene scene(machine);
  scene.add(parts);
  const AxisVec from = q(100, 20, 2, 1.5707963), to = q(400, 175, 2, 0);
  const Margins margins{0.5, {}};
  ASSERT_FALSE(first_hit(scene, from, from, margins));
  ASSERT_FALSE(first_hit(scene, to, to, margins));
  const SearchAnswer found = search_path(scene, from, to, margins);
  ASSERT_EQ(found.status, SearchStatus::Ok);
  EXPECT_TRUE(certify(scene, found.points, {0.5, {}}));
  for (std::size_t i = 0; i + 1 < found.points.size(); ++i)
    EXPECT_GT(sampled(machine, parts, found.points[i], found.points[i + 1]), 0.5);
  EXPECT_EQ(found.points, search_path(scene, from, to, margins).points);
}

/// That no path exists is proved of X, Y and Z with C as it stands: not said where C could turn.
TEST(Turn, no_path_is_not_claimed_where_c_could_turn) {
  config::Machine machine = test::bare_machine();
  machine.axes[2].p_max = 12;
  machine.head = {{"needle", {Form::Capsule, {1, 1, 20}}, {0, 0, 10}, 0, false},
                  {"arm", {Form::Box, {42, 4, 4}}, {21, 0, 8}, 0, false, true}};
  Scene scene(machine);
  scene.add(test::box("wall", {700, 10, 80}, {200, 150, 40}));
  EXPECT_EQ(search_path(scene, q(200, 50, 2, 0), q(200, 250, 2, 0), {0.5, {}}).status, SearchStatus::Budget);
  machine.head[1].on_turn = false;
  Scene standing(machine);
  standing.add(test::box("wall", {700, 10, 80}, {200, 150, 40}));
  EXPECT_EQ(search_path(standing, q(200, 50, 2, 0), q(200, 250, 2, 0), {0.5, {}}).status, SearchStatus::NoPath);
}

TEST(Turn, lifts_over_as_high_as_the_arm_needs_while_it_turns) {
  config::Machine machine = test::bare_machine();
  machine.tools = {{"needle", {0, 0, 0}, 0}};
  machine.head = {{"needle", {Form::Capsule, {1, 1, 20}}, {0, 0, 10}, 0, false},
                  {"arm", {Form::Box, {42, 4, 4}}, {21, 0, 12}, 0, false, true}};
  Scene scene(machine);
  // The needle passes beside the post; the arm, whose lower face is 10 mm over the tip, swings over it.
  const config::Body post = test::box("post", {4, 4, 30}, {100, 120, 15});
  scene.add(post);
  const AxisVec from = q(60, 100, 5, 0), to = q(140, 100, 5, 3);
  const auto margins = Margins{1, {}};
  ASSERT_TRUE(first_hit(scene, from, to, margins));
  const auto over = lift_over(scene, from, to, margins);
  ASSERT_TRUE(over) << over.error().why;
  EXPECT_NEAR(over->z_mm, 30 + 1 - 10, 0.01);
  for (std::size_t i = 0; i + 1 < over->points.size(); ++i)
    EXPECT_GT(sampled(machine, {post}, over->points[i], over->points[i + 1]), 1 - 1e-9);
}

/// FCL sees bodies turn as well: it agrees with what is free, and with little else.
TEST(Turn, the_second_opinion_turns_bodies_too) {
  test::RandomBodies random(kSeed + 3);
  const config::Machine machine = turning_machine();
  const Opinion fcl = fcl_opinion();
  const ClearanceRules rules{.clearance_mm = 0.5, .approaches = {}};
  int free = 0, deep = 0;
  for (int n = 0; n < 300; ++n) {
    const Case c = random_case(random, machine, 8);
    const Segment segment = test::line(c.from, c.to);
    const auto poses = fcl(c.scene, rules, {&segment, 1});
    if (!first_hit(c.scene, c.from, c.to, {0.5, {}})) {
      ++free;
      ASSERT_TRUE(poses) << "case " << n << " seed " << kSeed << ": " << poses.error().message;
      double most_mm = 0;
      for (const config::Body& body : machine.head) {
        const Vec3 a = posed(machine, body, c.from).centre, b = posed(machine, body, c.to).centre;
        most_mm = std::max(most_mm, norm(b - a));
      }
      EXPECT_GE(static_cast<double>(*poses), most_mm / kOpinionStep_mm) << "poses are at most a step apart";
    } else if (distance_at(machine, c.parts, between(c.from, c.to, 0.5)) <= 0) {
      ++deep;
      ASSERT_FALSE(poses) << "case " << n << " seed " << kSeed;
    }
  }
  EXPECT_GT(free, 50);
  EXPECT_GT(deep, 10);
}

}  // namespace
}  // namespace gantry::motion
