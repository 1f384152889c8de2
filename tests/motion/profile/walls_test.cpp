// Position limits, judged by linear programming: walls.csv holds cases and the least duration that lp_judge.py --search
// found for them (nan: there is no motion).
#include <cmath>
#include <fstream>
#include <gtest/gtest.h>
#include <sstream>

#include "tests/motion/profile/judge.hpp"

namespace gantry::motion {
namespace {

TEST(PositionLimits, no_motion_is_longer_than_linear_programming_finds_and_none_leaves_the_limits) {
  std::ifstream in(std::string(GANTRY_SOURCE_DIR) + "/tests/motion/profile/walls.csv");
  std::string line, id;
  std::getline(in, line);
  ASSERT_EQ(line, "id,p0,v0,a0,pf,vf,af,vmax,vmin,amax,amin,jmax,jmin,pmin,pmax,found");
  int solved = 0, refused = 0;
  while (std::getline(in, line)) {
    std::istringstream cells(line);
    std::getline(cells, id, ',');
    double x[15];
    for (double& value : x) {
      std::string cell;
      std::getline(cells, cell, ',');
      value = std::stod(cell);
    }
    AxisBounds b(x[6], x[7], x[8], x[9], x[10], x[11]);
    b.p_min = x[12], b.p_max = x[13];
    const State from{x[0], x[1], x[2]}, to{x[3], x[4], x[5]};
    const double found = x[14];
    const Plan plan = move(from, to, b);
    if (std::isnan(found)) {
      EXPECT_FALSE(plan) << id << ": there is no motion";
      EXPECT_TRUE(plan.reason == Reason::StartCannotStay || plan.reason == Reason::NoWayWithin) << name(plan.reason);
      ++refused;
      continue;
    }
    ASSERT_TRUE(plan) << id << " " << name(plan.reason);
    EXPECT_EQ(judge::verdict(plan.profile, from, to, b), "") << id;
    EXPECT_LE(duration(plan.profile), found * 1.001) << id;
    ++solved;
  }
  EXPECT_GE(solved, 4);
  EXPECT_GT(refused, 8);
}

TEST(PositionLimits, a_start_outside_or_on_its_way_out_is_told) {
  AxisBounds b(1, 1, 1);
  b.p_min = 0, b.p_max = 1;
  EXPECT_EQ(move({2, 0, 0}, {0.5, 0, 0}, b).reason, Reason::StartCannotStay);
  EXPECT_EQ(move({0.95, 1, 0}, {0.5, 0, 0}, b).reason, Reason::StartCannotStay);
  EXPECT_EQ(move({0.5, 0, 0}, {2, 0, 0}, b).reason, Reason::TargetOutsideBounds);
  EXPECT_EQ(move({0, 0, 0}, {1, 0, 0}, b).reason, Reason::Solved);
}

}  // namespace
}  // namespace gantry::motion
