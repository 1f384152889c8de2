// Whoever is asked for a second opinion is asked of every motion that a job plays, and its word counts.
#include <gtest/gtest.h>

#include "app/job/block_builder.hpp"
#include "app/job/limits.hpp"
#include "app/job/prove.hpp"
#include "app/job/rise.hpp"
#include "motion/geometry.hpp"
#include "motion/path/bead.hpp"
#include "tests/app/job/reference.hpp"

namespace gantry::job {
namespace {

const std::string kMarks =
    "marks:\n  a: {at: [5 mm, 5 mm], diameter: 1 mm}\n  b: {at: [75 mm, 45 mm], diameter: 1 mm}\n"
    "touches:\n  t: {at: [40 mm, 50 mm]}\n";

TEST(Opinion, is_asked_of_every_segment_that_moves_and_of_no_other) {
  const config::Machine machine = test::reference();
  const motion::Limits limits = limits_of(machine);
  const motion::Scene scene(machine);
  const motion::PathRules rules{.clearance_mm = machine.clearance_mm, .approaches = {}};
  std::vector<motion::Segment> seen;
  const motion::Opinion opinion = [&](const motion::Scene& among, const motion::PathRules& by,
                                      std::span<const motion::Segment> all) -> Result<std::size_t> {
    EXPECT_EQ(among.hash(), scene.hash());
    EXPECT_EQ(by.clearance_mm, rules.clearance_mm);
    seen.insert(seen.end(), all.begin(), all.end());
    return 10 * all.size();
  };
  AxisVec at = test::parked(machine);
  const auto moved = [&](double x, double y, double z) {
    AxisVec q = at;
    q[machine.x.value] += x, q[machine.y.value] += y, q[machine.z.value] += z;
    return q;
  };
  BlockBuilder builder(limits, scene, 1, at, {}, opinion);
  ASSERT_TRUE(builder.travel(moved(50, 30, -5), rules));
  ASSERT_TRUE(builder.straight(moved(50, 30, -7), rules));
  ASSERT_TRUE(builder.dwell(0.1));
  motion::BeadSpec spec;
  spec.points = {moved(60, 30, -7), moved(90, 30, -7), moved(90, 60, -7)};
  spec.speed_mm_s = 20, spec.corner_tolerance_mm = 0.2;
  const auto bead = motion::plan_bead(limits, spec);
  ASSERT_TRUE(bead);
  ASSERT_TRUE(builder.straight(bead->start, rules));
  ASSERT_TRUE(builder.bead(*bead, rules, 0));
  ASSERT_TRUE(builder.until_probe(moved(90, 60, -9), rules, 5));
  const ProvenBlock block = builder.finish().value();
  std::size_t moving = 0;
  for (const motion::Segment& s : block.segments()) {
    if (s.geometry.degree == 0) continue;
    ASSERT_LT(moving, seen.size());
    EXPECT_EQ(motion::point(seen[moving].geometry, 0), motion::point(s.geometry, 0));
    EXPECT_EQ(seen[moving].geometry.length, s.geometry.length);
    ++moving;
  }
  EXPECT_EQ(moving, seen.size());
  EXPECT_EQ(block.poses(), 10 * moving);
}

TEST(Opinion, that_is_against_a_motion_keeps_it_out_of_the_block) {
  const config::Machine machine = test::reference();
  const motion::Limits limits = limits_of(machine);
  const motion::Scene scene(machine);
  const AxisVec at = test::parked(machine);
  AxisVec to = at;
  to[machine.x.value] += 10;
  const motion::PathRules rules{.clearance_mm = machine.clearance_mm, .approaches = {}};
  const auto refused = [&](const auto& add) {
    BlockBuilder builder(limits, scene, 1, at, {}, [](const auto&, const auto&, auto) -> Result<std::size_t> {
      return fail(Fault::Internal, "no");
    });
    const Result<void> added = add(builder);
    const Error error = added ? builder.finish().error() : added.error();
    EXPECT_EQ(error.message, "no");
    if (added) return;  // it waited for the motions that might have followed
    EXPECT_EQ(builder.at(), at);
    const ProvenBlock block = builder.finish().value();
    for (const motion::Segment& s : block.segments()) EXPECT_EQ(s.geometry.degree, 0);
  };
  refused([&](BlockBuilder& b) { return b.travel(to, rules); });
  refused([&](BlockBuilder& b) { return b.vertical(to, rules, 1); });
  refused([&](BlockBuilder& b) { return b.straight(to, rules); });
  refused([&](BlockBuilder& b) { return b.until_probe(to, rules, 5); });
}

/// Where the head stands low when a job begins.
TEST(Opinion, is_asked_of_the_rise_and_its_words_stay_its_own) {
  const config::Machine machine = test::reference();
  AxisVec low = test::parked(machine);
  low[machine.z.value] = machine.safe_z_mm - 10;
  const auto up = plan_rise(machine, Surroundings(machine), 1, low,
                            [](const auto&, const auto&, auto) -> Result<std::size_t> { return 11; });
  ASSERT_TRUE(up && *up);
  EXPECT_EQ((*up)->poses(), 11u);
  const auto refused =
      plan_rise(machine, Surroundings(machine), 1, low,
                [](const auto&, const auto&, auto) -> Result<std::size_t> { return fail(Fault::Internal, "no"); });
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().fault, Fault::Internal);
  EXPECT_EQ(refused.error().message, "no");
}

TEST(Opinion, of_fcl_is_not_against_a_job_that_was_proved) {
  const config::Machine machine = test::reference();
  for (const char* file : {"recipes/demo-board.yaml", "recipes/patterns.yaml", "recipes/portal.yaml"}) {
    const auto compiled = recipes::load_for(file, machine);
    ASSERT_TRUE(compiled) << file;
    const auto proof = prove_nominal(machine, compiled->recipe, compiled->job, {}, motion::fcl_opinion());
    ASSERT_TRUE(proof) << to_text(proof.error());
    EXPECT_GT(proof->poses, proof->motions) << file;
    const auto alone = prove_nominal(machine, compiled->recipe, compiled->job);
    EXPECT_EQ(alone->poses, 0u);
    EXPECT_EQ(alone->forecast.s, proof->forecast.s);
  }
}

/// The proof is given a part that is less high than the one that FCL is shown.
TEST(Opinion, names_the_line_whose_motion_a_wrong_certifier_has_let_through) {
  const config::Machine machine = test::reference();
  const recipes::Recipe recipe = test::dots(3, 4, kMarks);
  const auto job = recipes::compile(recipe, machine);
  ASSERT_TRUE(job);
  const motion::Opinion fcl = motion::fcl_opinion();
  ASSERT_TRUE(prove_nominal(machine, recipe, *job, {}, fcl));
  const Vec3 dot = recipes::to_machine(recipe, machine, {}, {}, {40, 10}, 0);  // d[0][2]
  const motion::Opinion shown_more = [&](const motion::Scene& scene, const motion::PathRules& rules,
                                         std::span<const motion::Segment> all) {
    motion::Scene real = scene;
    real.add(config::Body{"wire", {config::Shape::Kind::Box, {2, 2, 1}}, dot + Vec3{0, 0, 0.7}, 0, false});
    return fcl(real, rules, all);
  };
  const auto refused = prove_nominal(machine, recipe, *job, {}, shown_more);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().fault, Fault::Internal);
  EXPECT_EQ(refused.error().where.find("dots.yaml:"), 0u) << to_text(refused.error());
  EXPECT_NE(refused.error().message.find("dot 'd[0][2]'"), std::string::npos) << refused.error().message;
  EXPECT_NE(refused.error().message.find("wire"), std::string::npos) << refused.error().message;
}

}  // namespace
}  // namespace gantry::job
