#include "app/job/block_builder.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <numbers>
#include <optional>
#include <type_traits>

#include "app/job/limits.hpp"
#include "motion/geometry.hpp"
#include "tests/app/job/reference.hpp"

namespace gantry::job {
namespace {

// Nobody but the builder makes a block that may be played, and it takes nothing that it has not certified.
static_assert(!std::is_default_constructible_v<ProvenBlock>);
static_assert(!std::is_aggregate_v<ProvenBlock>);

struct BlockBuilderTest : testing::Test {
  config::Machine machine = test::reference();
  motion::Limits limits = limits_of(machine);
  motion::Scene scene{machine};
  motion::PathRules rules{.clearance_mm = machine.clearance_mm, .approaches = {}};
  AxisVec high = test::parked(machine);

  BlockBuilder builder(Breath breath = {}) { return {limits, scene, 5, high, std::move(breath)}; }
  AxisVec moved(double x, double y, double z) {
    AxisVec q = high;
    q[machine.x.value] += x, q[machine.y.value] += y, q[machine.z.value] += z;
    return q;
  }
};

TEST_F(BlockBuilderTest, segments_join_carry_their_block_and_the_last_ends_it) {
  BlockBuilder b = builder();
  ASSERT_TRUE(b.straight(moved(20, 0, 0), rules));
  ASSERT_TRUE(b.dwell(0.01, {}, 3));
  ASSERT_TRUE(b.travel(moved(20, 30, -5), rules));
  const ProvenBlock block = b.finish().value();
  EXPECT_EQ(block.number(), 5u);
  EXPECT_EQ(block.end(), moved(20, 30, -5));
  AxisVec at = high;
  double seconds = 0;
  for (const motion::Segment& s : block.segments()) {
    EXPECT_EQ(s.block, 5u);
    EXPECT_EQ(s.ends_block, &s == &block.segments().back());
    EXPECT_EQ(s.feature, s.kind == motion::SegmentKind::Dwell ? 3u : motion::kTravel);
    for (std::size_t i = 0; i < limits.axes; ++i) EXPECT_NEAR(motion::point(s.geometry, 0)[i], at[i], 1e-9);
    if (s.kind == motion::SegmentKind::Path) at = motion::point(s.geometry, s.geometry.length);
    for (const motion::Phase& p : s.nominal.phases) seconds += p.duration_s;
  }
  for (std::size_t i = 0; i < limits.axes; ++i) EXPECT_NEAR(at[i], block.end()[i], 1e-9);
  EXPECT_NEAR(block.duration_s(), seconds, 1e-9);
  EXPECT_GE(block.motions(), 2u);
}

/// Home again after a turn: what rounding has left of X is no place of its own, and the turn is played.
TEST_F(BlockBuilderTest, a_turn_where_the_linear_axes_stand_but_for_rounding_is_a_motion) {
  for (const double left : {0.0, 3.6e-15, 1e-13}) {
    AxisVec from = high, to = high;
    from[machine.x.value] += left;
    from[3] += 0.035;
    BlockBuilder b{limits, scene, 5, from};
    ASSERT_TRUE(b.travel(to, rules)) << left;
    const auto block = b.finish();
    ASSERT_TRUE(block) << left << ": " << to_text(block.error());
    EXPECT_NEAR(motion::point(block->segments().front().geometry, 0)[3], from[3], 1e-9) << left;
    EXPECT_GT(block->duration_s(), 0.01) << left;
  }
}

/// X answers at once, Y late: at speed the targets lie beside a slanted line. Past a post that is as near as it may be
/// the line is slowed until they keep clear, and no override may take that back: it is a piece.
TEST_F(BlockBuilderTest, a_line_that_is_slowed_for_its_targets_is_never_played_faster) {
  limits.response_delay_s[machine.x.value] = 0.001, limits.response_delay_s[machine.y.value] = 0.009;
  const AxisVec to = moved(60, 60, 0);
  const motion::SceneBody& of_head = scene.head().front();
  const Vec3 middle = of_head.solid.centre + scene.carried(of_head, moved(30, 30, 0));
  const auto past = [&](double aside_mm) -> std::optional<motion::Segment> {
    motion::Scene with_post(machine);
    config::Body post{"post", {config::Shape::Kind::Box, {2, 2, 4000}}, {}, 0, false};
    post.centre = middle + Vec3{aside_mm, -aside_mm, 0};
    with_post.add(post);
    BlockBuilder b(limits, with_post, 5, high);
    if (!b.straight(to, rules)) return std::nullopt;
    return b.finish().value().segments().front();
  };
  double blocked = 0, free = 300;
  ASSERT_FALSE(past(blocked));
  ASSERT_TRUE(past(free));
  EXPECT_EQ(past(free)->kind, motion::SegmentKind::Path);
  while (free - blocked > 1e-4) (past((free + blocked) / 2) ? free : blocked) = (free + blocked) / 2;
  const motion::Segment slowed = *past(free);
  EXPECT_LT(slowed.v_cap, past(300)->v_cap / 2 * 1.001);
  EXPECT_EQ(slowed.kind, motion::SegmentKind::Piece);
}

TEST_F(BlockBuilderTest, what_is_not_free_is_not_taken) {
  const config::Body wall{"wall", {config::Shape::Kind::Box, {2, 4000, 4000}}, {}, 0, false};
  config::Body there = wall;
  for (const motion::SceneBody& body : scene.head()) {
    const Vec3 at = body.solid.centre + scene.carried(body, moved(60, 0, 0));
    if (at.x + body.half_box.x > there.centre.x) there.centre = {at.x + body.half_box.x, at.y, at.z};
  }
  scene.add(there);
  BlockBuilder b = builder();
  for (const auto& refused : {b.straight(moved(120, 0, 0), rules), b.travel(moved(120, 0, 0), rules),
                              b.until_probe(moved(120, 0, 0), rules, 5)}) {
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().fault, Fault::Collision);
    EXPECT_NE(refused.error().message.find("wall"), std::string::npos) << refused.error().message;
  }
  motion::BeadSpec spec;
  spec.points = {moved(20, 0, 0), moved(120, 0, 0)};
  spec.speed_mm_s = 20;
  const auto bead = motion::plan_bead(limits, spec);
  ASSERT_TRUE(bead);
  ASSERT_TRUE(b.straight(bead->start, rules));
  const auto refused = b.bead(*bead, rules, 0);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().fault, Fault::Collision);
  EXPECT_EQ(b.at(), bead->start);
  const ProvenBlock block = b.finish().value();
  for (const motion::Segment& s : block.segments())
    EXPECT_LE(motion::point(s.geometry, s.geometry.length)[machine.x.value], bead->start[machine.x.value] + 1e-9);
}

/// Along a low wall at the very clearance targets have no room beside a slanted path, at any speed: it goes up from its
/// ends, where Z alone moves and is exactly on its path, and across above the wall as fast as anywhere.
TEST_F(BlockBuilderTest, a_path_along_a_wall_at_the_very_clearance_goes_over_it) {
  const auto x = static_cast<std::size_t>(machine.x.value), y = static_cast<std::size_t>(machine.y.value),
             z = static_cast<std::size_t>(machine.z.value);
  ASSERT_NE(limits.response_delay_s[x], limits.response_delay_s[y]);
  const double kDiagonal = std::sqrt(0.5), along = 60;
  const AxisVec from = moved(20, 20, -20), to = moved(20 + along * kDiagonal, 20 + along * kDiagonal, -20);
  const auto lowest = std::ranges::find(scene.head(), "probe_stylus", &motion::SceneBody::name);
  ASSERT_NE(lowest, scene.head().end());
  const Vec3 tip = lowest->solid.centre + scene.carried(*lowest, from);
  // A wall 2 mm thick, 3 mm higher than the stylus' end, as long as the motion and parallel to it.
  const double off = lowest->half_box.x + rules.clearance_mm + 1, low = tip.z - lowest->half_box.z;
  const auto wall = [&](double nearer) {
    const double n = off - nearer;
    return config::Body{
        "wall",
        {config::Shape::Kind::Box, {along, 2, 13}},
        {tip.x + along / 2 * kDiagonal + n * kDiagonal, tip.y + along / 2 * kDiagonal - n * kDiagonal, low + 3 - 6.5},
        std::numbers::pi / 4,
        false};
  };
  {
    BlockBuilder there = builder();
    ASSERT_TRUE(there.travel(from, rules));
    ASSERT_TRUE(there.travel(to, rules));
    const double free_s = there.finish().value().duration_s();
    scene.add(wall(-1e-7));
    BlockBuilder b = builder();
    ASSERT_TRUE(b.travel(from, rules));
    ASSERT_TRUE(b.travel(to, rules));
    const Result<ProvenBlock> block = b.finish();
    ASSERT_TRUE(block) << to_text(block.error());
    EXPECT_LT(block->duration_s(), free_s + 0.5);
    double top = -1e9;
    for (const motion::Segment& s : block->segments())
      for (const double at : {0.0, s.geometry.length / 2, s.geometry.length}) {
        const AxisVec q = motion::point(s.geometry, at);
        if (q[x] > from[x] + 1 && q[x] < to[x] - 1) top = std::max(top, q[z]);
        // Low down beside the wall, only Z moves.
        if (q[z] < from[z] + 0.5 && q[x] > from[x] - 1) {
          EXPECT_TRUE(std::abs(q[x] - from[x]) < 1e-9 || std::abs(q[x] - to[x]) < 1e-9) << q[x];
        }
      }
    EXPECT_GE(top, from[z] + 1);
  }
  motion::Scene nearer(machine);
  nearer.add(wall(1e-5));
  BlockBuilder b{limits, nearer, 5, high, {}};
  Result<void> taken = b.travel(from, rules);
  if (taken) taken = b.travel(to, rules);
  if (taken)
    if (const auto block = b.finish(); !block) taken = tl::unexpected(block.error());
  ASSERT_FALSE(taken) << "its ends are 1e-5 mm too near";
  EXPECT_NE(taken.error().message.find("wall"), std::string::npos) << taken.error().message;
}

TEST_F(BlockBuilderTest, a_bead_is_taken_only_where_the_axes_stand) {
  motion::BeadSpec spec;
  spec.points = {moved(20, 0, 0), moved(40, 0, 0)};
  spec.speed_mm_s = 20;
  const auto bead = motion::plan_bead(limits, spec);
  ASSERT_TRUE(bead);
  BlockBuilder b = builder();
  EXPECT_EQ(b.bead(*bead, rules, 0).error().fault, Fault::Internal);
  ASSERT_TRUE(b.travel(bead->start, rules));
  ASSERT_TRUE(b.bead(*bead, rules, 4));
  EXPECT_EQ(b.at(), bead->end);
}

TEST_F(BlockBuilderTest, a_block_without_motion_stands_for_one_tick) {
  const ProvenBlock block = builder().finish().value();
  ASSERT_EQ(block.segments().size(), 1u);
  EXPECT_EQ(block.segments().front().kind, motion::SegmentKind::Dwell);
  EXPECT_TRUE(block.segments().front().ends_block);
  EXPECT_NEAR(block.duration_s(), limits.tick_s, 1e-12);
  EXPECT_EQ(block.end(), high);
}

TEST_F(BlockBuilderTest, a_touch_is_proved_to_its_end_and_rests_where_it_began_by_plan) {
  BlockBuilder b = builder();
  ASSERT_TRUE(b.until_probe(moved(0, 0, -5), rules, 4));
  EXPECT_EQ(b.at(), high);
  const ProvenBlock block = b.finish().value();
  EXPECT_EQ(block.segments().back().kind, motion::SegmentKind::UntilProbe);
  EXPECT_LE(block.segments().back().v_cap, 4);
}

}  // namespace
}  // namespace gantry::job
