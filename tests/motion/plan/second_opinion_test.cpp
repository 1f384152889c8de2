// FCL's opinion of certified motions: none against them in random scenes, and always one against a certifier that is
// wrong by more than the step. That certifier is planted: it has seen other bodies than FCL.
#include "motion/plan/second_opinion.hpp"

#include <array>
#include <cstdio>
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "core/meeting.hpp"
#include "motion/geometry.hpp"
#include "motion/plan/find_path.hpp"
#include "tests/motion/plan/random_bodies.hpp"

namespace gantry::motion {
namespace {

using test::at;
using test::bare_machine;
using test::box;
using test::line;

/// From `from` over `over` (half way, pulled like a rope) to `to`: a parabola.
Segment arc(Vec3 from, Vec3 over, Vec3 to) {
  Segment s;
  Geometry& g = s.geometry;
  g.degree = 3, g.moving = 0b111;
  g.from = at(from.x, from.y, from.z);
  g.u = {1, 0, 0, 0, 0};
  const Vec3 first = (over - from) * 2, second = from - over * 2 + to;
  for (std::size_t i = 0; i < 3; ++i) g.c[3 * i] = component(first, i), g.c[3 * i + 1] = component(second, i);
  const auto on = [&](double u) { return from + first * u + second * (u * u); };
  for (int k = 0; k < 1000; ++k) g.whole += norm(on((k + 1) / 1000.0) - on(k / 1000.0));
  g.length = g.whole;
  return s;
}

const ClearanceRules kClear{.clearance_mm = 0.5, .approaches = {}};

Result<std::size_t> asked(const Scene& scene, const Segment& segment, const ClearanceRules& rules = kClear) {
  return fcl_opinion()(scene, rules, {&segment, 1});
}

TEST(SecondOpinion, agrees_with_what_was_certified_in_200_random_scenes) {
  constexpr std::uint64_t kSeed = 20261123;
  test::RandomBodies random(kSeed);
  const Opinion fcl = fcl_opinion();
  std::size_t free = 0, poses = 0, hits = 0, seen = 0;
  for (int n = 0; n < 200; ++n) {
    const bool grid = n % 2 == 0;
    Scene scene(bare_machine());
    std::vector<config::Body> bodies;
    for (int i = 0; i < 40; ++i) {
      config::Body body = random.body(100, grid);
      body.name = fmt::format("body {}", i);
      body.centre = body.centre + Vec3{200, 150, 0};
      body.centre.z = grid ? random.whole(-8, 20) : random.real(-8, 20);
      if (i % 10 == 0) body.shape.size.z = 0.05;  // a foil
      if (body.shape.kind == config::Shape::Kind::Capsule)
        body.shape.size.z = std::max(body.shape.size.z, body.shape.size.x);
      bodies.push_back(body);
    }
    scene.add(bodies);
    for (int k = 0; k < 100; ++k) {
      const auto q = [&] {
        return grid ? at(random.whole(80, 320), random.whole(30, 270), random.whole(0, 40), random.whole(0, 15))
                    : at(random.real(80, 320), random.real(30, 270), random.real(0, 40), random.real(0, 15));
      };
      const AxisVec from = q(), to = k % 4 == 0 ? at(from[0], from[1], random.real(0, 40), from[4]) : q();
      // Without any clearance, FCL would have to find what is apart by a nanometre.
      const ClearanceRules rules{.clearance_mm = k % 2 == 0 ? 0.0 : 0.5, .approaches = {}};
      const bool certified = certify(scene, std::array{from, to}, rules).has_value();
      const auto opinion = fcl(scene, rules, std::array{line(from, to)});
      ++(certified ? free : hits);
      if (!certified) seen += !opinion;
      if (!certified) continue;
      ASSERT_TRUE(opinion) << to_text(opinion.error()) << " seed " << kSeed << " scene " << n << " motion " << k;
      poses += *opinion;
    }
  }
  std::printf("%zu certified motions, %zu poses, none contradicted; of %zu others FCL is against %zu\n", free, poses,
              hits, seen);
  EXPECT_GT(free, 2000u);
  EXPECT_GT(seen, hits * 9 / 10);
}

TEST(SecondOpinion, a_certifier_that_has_not_seen_a_body_is_contradicted_with_both_verdicts_the_bodies_and_the_point) {
  Scene believed(bare_machine()), true_scene(bare_machine());
  const config::Body far_off = box("far off", {10, 10, 10}, {400, 300, 5});
  believed.add(far_off);
  true_scene.add(std::array{far_off, box("part U7", {8, 8, 3}, {150, 100, 1.5})});
  const AxisVec from = at(100, 100, 2), to = at(200, 100, 2);
  ASSERT_TRUE(certify(believed, std::array{from, to}, kClear));
  const auto against = asked(true_scene, line(from, to));
  ASSERT_FALSE(against);
  const Error& e = against.error();
  EXPECT_EQ(e.fault, Fault::Internal);
  for (const char* says : {"by the proof it is free", "needle keeps 0.5 mm from part U7", "FCL says that they meet"})
    EXPECT_NE(e.message.find(says), std::string::npos) << e.message;
  ASSERT_NE(e.meeting, nullptr);
  EXPECT_EQ(e.meeting->head, "needle");
  EXPECT_EQ(e.meeting->standing, "part U7");
  EXPECT_NEAR(e.meeting->machine_mm.x, 146, 1.5);  // its near face
  EXPECT_NE(e.message.find(true_scene.told(e.meeting->machine_mm)), std::string::npos) << e.message;
  EXPECT_TRUE(asked(true_scene, line(at(100, 100, 4.2), at(200, 100, 4.2)))) << "over it";
}

/// Whatever body of the head meets it, and wherever on the motion.
TEST(SecondOpinion, a_body_that_is_planted_on_a_certified_motion_is_always_noticed) {
  constexpr std::uint64_t kSeed = 8;
  test::RandomBodies random(kSeed);
  const Scene empty(bare_machine());
  const Opinion fcl = fcl_opinion();
  for (int i = 0; i < 1000; ++i) {
    const AxisVec from = at(random.real(0, 400), random.real(0, 300), random.real(0, 80), random.real(0, 15)),
                  to = at(random.real(0, 400), random.real(0, 300), random.real(0, 80), random.real(0, 15));
    ASSERT_TRUE(certify(empty, std::array{from, to}, kClear));
    const auto& body = empty.head()[static_cast<std::size_t>(random.whole(0, 3))];
    const double on = i % 10 == 0 ? 0 : i % 10 == 1 ? 1 : random.real(0, 1);
    const Vec3 there = body.solid.centre + empty.carried(body, between(from, to, on));
    Scene planted(bare_machine());
    planted.add(box("planted", {1.1, 1.1, 1.1}, there, random.real(-3, 3)));
    const auto against = fcl(planted, kClear, std::array{line(from, to)});
    ASSERT_FALSE(against) << "seed " << kSeed << " case " << i << " " << body.name;
    EXPECT_EQ(against.error().meeting->standing, "planted");
  }
}

/// A foil that the needle, 1 mm across, touches at one pose and at no other.
TEST(SecondOpinion, leaves_no_pose_out) {
  const Opinion fcl = fcl_opinion();
  const std::array motion{line(at(100, 100, 2), at(160, 100, 2)), line(at(160, 100, 2), at(200, 100, 2))};
  for (int k = 0; k <= 100; ++k) {
    Scene scene(bare_machine());
    scene.add(box("foil", {0.05, 5, 5}, {100.0 + k, 100, 2.5}));
    EXPECT_FALSE(fcl(scene, kClear, motion)) << "pose " << k;
  }
}

TEST(SecondOpinion, looks_at_curves_at_lifts_and_at_every_segment_of_a_motion) {
  Scene scene(bare_machine());
  scene.add(box("post", {1, 1, 10}, {150, 120, 5}));
  // Both ends and the straight line between them are free; the curve goes through the post.
  EXPECT_TRUE(asked(scene, line(at(100, 100, 2), at(200, 100, 2))));
  const auto curve = asked(scene, arc({100, 100, 2}, {150, 140, 2}, {200, 100, 2}));
  ASSERT_FALSE(curve);
  EXPECT_NE(curve.error().message.find("needle"), std::string::npos) << curve.error().message;
  const std::array bead{line(at(100, 100, 2), at(120, 100, 2)), line(at(120, 100, 2), at(120, 120, 2)),
                        line(at(120, 120, 2), at(180, 120, 2))};
  EXPECT_FALSE(fcl_opinion()(scene, kClear, bead));
  // The probe rides on the lift, which alone moves: 15 mm, onto a plate.
  Scene plate(bare_machine());
  plate.add(box("plate", {10, 10, 1}, {100, 130, 8}));
  const auto lift = asked(plate, line(at(100, 100, 0, 0), at(100, 100, 0, 15)));
  ASSERT_FALSE(lift);
  EXPECT_NE(lift.error().message.find("probe"), std::string::npos) << lift.error().message;
}

TEST(SecondOpinion, looks_at_a_pose_at_least_every_millimetre_and_at_both_ends) {
  Scene scene(bare_machine());
  scene.add(box("far off", {10, 10, 10}, {400, 300, 5}));
  EXPECT_EQ(*asked(scene, line(at(100, 100, 50), at(110, 100, 50))), 11u);
  EXPECT_EQ(*asked(scene, line(at(100, 100, 50), at(110.1, 100, 50))), 12u);
  EXPECT_EQ(*asked(scene, line(at(100, 100, 50), at(100.1, 100, 50))), 2u);
  EXPECT_EQ(*asked(scene, line(at(100, 100, 50, 0), at(101, 100, 50, 15))), 17u) << "the lift goes 15.03 mm";
  const auto curve = asked(scene, arc({100, 100, 50}, {150, 140, 50}, {200, 100, 50}));
  EXPECT_GE(*curve, 108u);
  EXPECT_LE(*curve, 250u);
  const std::array bead{line(at(100, 100, 50), at(120, 100, 50)), line(at(120, 100, 50), at(120, 120, 50)),
                        line(at(120, 120, 50), at(180, 120, 50))};
  EXPECT_EQ(*fcl_opinion()(scene, kClear, bead), 101u) << "20, 20 and 60 mm, and corners once";
  const auto there_and_back = asked(scene, arc({100, 100, 50}, {100, 140, 50}, {100, 100, 50}));
  EXPECT_GE(*there_and_back, 41u) << "20 mm, and its ends are one place";
  Segment dwell;
  dwell.geometry = standing(at(100, 100, 50), 1);
  EXPECT_EQ(*asked(scene, dwell), 0u) << "it stands where the motion before has ended";
}

TEST(SecondOpinion, pairs_that_the_rules_let_near_are_not_asked_and_all_others_are) {
  Scene scene(bare_machine());
  scene.add(std::array{box("board", {100, 100, 2}, {150, 150, 0.9}), box("clip", {4, 4, 4}, {180, 150, 2})});
  const ClearanceRules near{.clearance_mm = 0.5, .approaches = {{"needle", "board", -0.1}}};
  EXPECT_TRUE(asked(scene, line(at(130, 150, 20), at(130, 150, 1.85)), near));
  EXPECT_FALSE(asked(scene, line(at(130, 150, 20), at(130, 150, 1.85))));
  const auto clip = asked(scene, line(at(130, 150, 1.85), at(190, 150, 1.85)), near);
  ASSERT_FALSE(clip);
  EXPECT_EQ(clip.error().meeting->standing, "clip");
  const auto unknown =
      asked(scene, line(at(130, 150, 20), at(130, 150, 10)), {.clearance_mm = 0.5, .approaches = {{"x", "board", 0}}});
  ASSERT_FALSE(unknown);
  EXPECT_EQ(unknown.error().fault, Fault::UnknownReference);
}

/// What has no size at all in a direction does not end the program, nor does what touches.
TEST(SecondOpinion, bodies_without_size_and_bodies_that_touch_are_no_trouble) {
  using Form = config::Shape::Kind;
  Scene scene(bare_machine());
  scene.add(std::array{box("point", {0, 0, 0}, {150, 100, 2}), box("sheet", {50, 50, 0}, {150, 100, 0}),
                       config::Body{"ball", {Form::Capsule, {4, 4, 4}}, {160, 100, 0}, 0, false},
                       config::Body{"wire", {Form::Capsule, {0, 0, 30}}, {170, 100, 0}, 0, false},
                       config::Body{"disc", {Form::Cylinder, {8, 8, 0}}, {180, 100, 0}, 0, false},
                       box("table", {400, 300, 10}, {200, 150, -5})});
  const Opinion fcl = fcl_opinion();
  for (int i = 0; i <= 400; ++i) {
    const double z = 0.01 * i - 1;
    const std::array there{line(at(140, 100, z), at(190, 100, z))};
    static_cast<void>(fcl(scene, kClear, there));
  }
  // The needle's tip on the table to the nanometre: nobody's to decide, and no contact where it is off it.
  Scene table(bare_machine());
  table.add(box("table", {400, 300, 10}, {200, 150, -5}));
  const ClearanceRules contact{.clearance_mm = 0, .approaches = {}};
  const AxisVec from = at(140, 100, 2e-9), to = at(190, 100, 2e-9);
  ASSERT_TRUE(certify(table, std::array{from, to}, contact));
  EXPECT_TRUE(asked(table, line(from, to), contact));
  EXPECT_FALSE(asked(table, line(at(140, 100, -0.01), at(190, 100, -0.01)), contact));
}

/// A machine may ask for no clearance: then bodies that are apart by some nanometres are free.
TEST(SecondOpinion, bodies_that_are_apart_by_next_to_nothing_are_not_contradicted) {
  constexpr std::uint64_t kSeed = 77;
  test::RandomBodies random(kSeed);
  const ClearanceRules none{.clearance_mm = 0, .approaches = {}};
  int asked_for = 0;
  for (int i = 0; i < 8000; ++i) {
    const bool grid = i % 2 == 0;
    Scene scene(bare_machine());
    config::Body body = random.body(20, grid);
    body.centre = body.centre + Vec3{100.0 + (i % 3 == 0 ? 0 : i % 3 == 1 ? 55 : 0), 100.0 + (i % 3 == 2 ? 30 : 0), 30};
    body.name = "body";
    scene.add(body);
    const double x = grid ? random.whole(90, 110) : random.real(90, 110), z = random.real(0, 60);
    const bool down = i % 4 < 2;
    const AxisVec from = down ? at(x, 100, 90) : at(x - 140, 100, z), to = down ? at(x, 100, 0) : at(x, 100, z);
    const auto hit = first_hit(scene, from, to, Margins{0, {}});
    if (!hit) continue;
    for (const double gap_mm : {3e-9, 1e-8, 1e-7, 1e-6, 1e-5}) {
      AxisVec near = between(from, to, hit->fraction);
      near[down ? 2 : 0] += down ? gap_mm : -gap_mm;
      if (!certify(scene, std::array{from, near}, none)) continue;
      const auto opinion = asked(scene, line(from, near), none);
      ASSERT_TRUE(opinion) << to_text(opinion.error()) << " seed " << kSeed << " case " << i << " gap " << gap_mm;
      ++asked_for;
    }
  }
  EXPECT_GT(asked_for, 5000);
  std::printf("%d motions that end 3 nm to 10 um from a body, none contradicted\n", asked_for);
}

TEST(SecondOpinion, an_empty_scene_has_nothing_to_meet) {
  EXPECT_EQ(*asked(Scene(bare_machine()), line(at(0, 0, 0), at(5, 0, 0))), 6u);
}

/// A cache of scenes must not answer for another one.
TEST(SecondOpinion, one_asker_keeps_scenes_apart) {
  const Opinion fcl = fcl_opinion();
  const std::array motion{line(at(100, 100, 2), at(200, 100, 2))};
  for (int round = 0; round < 3; ++round)
    for (int i = 0; i < 8; ++i) {
      Scene scene(bare_machine());
      scene.add(box("wall", {2, 200, 30}, {i % 2 == 0 ? 150.0 + i : 300.0 + i, 100, 5}));
      EXPECT_EQ(fcl(scene, kClear, motion).has_value(), i % 2 != 0) << i;
    }
}

}  // namespace
}  // namespace gantry::motion
