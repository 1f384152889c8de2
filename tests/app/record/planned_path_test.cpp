#include "app/record/planned_path.hpp"

#include <gtest/gtest.h>

#include "motion/geometry.hpp"
#include "tests/app/record/snapshots.hpp"

namespace gantry::record {
namespace {

/// A straight piece at constant speed.
motion::Segment straight(std::uint32_t block, Vec3 from, Vec3 to, double speed) {
  motion::Segment s;
  s.block = block;
  s.geometry =
      motion::straight({from.x, from.y, from.z}, {to.x - from.x, to.y - from.y, to.z - from.z}, norm(to - from));
  s.nominal.v0 = speed;
  s.nominal.phases.push_back({s.geometry.length / speed, 0});
  return s;
}

TEST(PlannedPath, plays_segments_at_their_planned_speed) {
  PlannedPath path(three_axes());
  const std::vector<motion::Segment> block{straight(1, {0, 0, 50}, {30, 0, 50}, 100),
                                           straight(1, {30, 0, 50}, {30, 40, 50}, 20)};
  path.add(block);
  path.add(std::vector{straight(2, {30, 40, 50}, {30, 40, 10}, 40)});
  const auto points = path.take();
  EXPECT_NEAR(points.back().t_s, 0.3 + 2.0 + 1.0, 1e-9);
  EXPECT_EQ(points.back().head, (Vec3{30, 40, 10}));
  EXPECT_EQ(points.back().block, 2u);
  bool corner = false;
  double worst = 0;
  for (const auto& p : points) {
    corner = corner || norm(p.head - Vec3{30, 0, 50}) < 1e-9;
    if (p.t_s <= 0.3) worst = std::max(worst, norm(p.head - Vec3{100 * p.t_s, 0, 50}));
  }
  EXPECT_TRUE(corner) << "where the path turns there is a point";
  EXPECT_LT(worst, 1e-9);
}

TEST(PlannedPath, shows_where_the_valve_opens_and_that_dwells_take_time) {
  PlannedPath path(three_axes());
  auto line = straight(1, {0, 0, 0}, {10, 0, 0}, 10);
  const auto valve = config::bit(config::Output::Valve);
  line.events.push_back({.at_s = 4, .lead_s = 0, .mask = valve, .value = valve, .dispense = true});
  motion::Segment dwell;
  dwell.block = 1;
  dwell.kind = motion::SegmentKind::Dwell;
  dwell.geometry = motion::standing({10, 0, 0}, 0.5);
  dwell.nominal.v0 = 1;
  dwell.nominal.phases.push_back({0.5, 0});
  dwell.events.push_back({.at_s = 0.2, .lead_s = 0, .mask = valve, .value = 0, .dispense = false});
  path.add(std::vector{line, dwell});
  const auto points = path.take();
  EXPECT_NEAR(points.back().t_s, 1.5, 1e-9);
  for (const auto& p : points) {
    if (p.t_s < 0.39 || p.t_s > 1.21) {
      EXPECT_FALSE(p.valve) << p.t_s;
    }
    if (p.t_s > 0.42 && p.t_s < 1.19) {
      EXPECT_TRUE(p.valve) << p.t_s;
    }
  }
}

}  // namespace
}  // namespace gantry::record
