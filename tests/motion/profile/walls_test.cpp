// Position limits, judged by linear programming: walls.csv (one axis) and walls_together.csv (two, with a minimum
// duration) hold cases and the least duration that lp_judge.py --search
// found for them (nan: there is no motion).
#include <cmath>
#include <fstream>
#include <gtest/gtest.h>
#include <random>
#include <sstream>
#include <string>
#include <vector>

#include "motion/profile/together.hpp"
#include "tests/motion/profile/judge.hpp"

namespace gantry::motion {
namespace {

struct Row {
  std::string id;
  std::vector<double> x;  // as in the header, without the id
};

std::vector<Row> rows_of(const std::string& file, std::size_t columns) {
  std::ifstream in(std::string(GANTRY_SOURCE_DIR "/tests/motion/profile/") + file);
  std::vector<Row> rows;
  std::string line, cell;
  std::getline(in, line);
  while (std::getline(in, line)) {
    std::istringstream cells(line);
    Row row;
    std::getline(cells, row.id, ',');
    while (std::getline(cells, cell, ',')) row.x.push_back(std::stod(cell));
    EXPECT_EQ(row.x.size(), columns) << row.id;
    rows.push_back(row);
  }
  return rows;
}

/// p0,v0,a0,pf,vf,af,vmax,vmin,amax,amin,jmax,jmin,pmin,pmax
AxisMove axis_of(const double* x) {
  AxisMove m{{x[0], x[1], x[2]}, {x[3], x[4], x[5]}, {x[6], x[7], x[8], x[9], x[10], x[11]}};
  m.bounds.p_min = x[12], m.bounds.p_max = x[13];
  return m;
}

TEST(PositionLimits, no_motion_is_longer_than_linear_programming_finds_and_none_leaves_the_limits) {
  int solved = 0, refused = 0;
  for (const Row& row : rows_of("walls.csv", 15)) {
    const AxisMove m = axis_of(row.x.data());
    const double found = row.x.back();
    const Plan plan = move(m.from, m.to, m.bounds);
    if (std::isnan(found)) {
      EXPECT_FALSE(plan) << row.id << ": there is no motion";
      EXPECT_TRUE(plan.reason == Reason::StartCannotStay || plan.reason == Reason::NoMotionWithin) << name(plan.reason);
      ++refused;
      continue;
    }
    ASSERT_TRUE(plan) << row.id << " " << name(plan.reason);
    EXPECT_EQ(judge::verdict(plan.profile, m.from, m.to, m.bounds), "") << row.id;
    EXPECT_LE(duration(plan.profile), found * 1.001) << row.id;
    EXPECT_GE(duration(plan.profile), found * 0.98) << row.id << ": shorter than there is, by the search's own step";
    ++solved;
  }
  EXPECT_GE(solved, 60);
  EXPECT_GE(refused, 12);
}

TEST(PositionLimits, no_common_duration_is_longer_than_linear_programming_finds) {
  int solved = 0, refused = 0;
  for (const Row& row : rows_of("walls_together.csv", 30)) {
    const AxisMove axes[] = {axis_of(row.x.data()), axis_of(row.x.data() + 14)};
    const double least = row.x[28], found = row.x[29];
    const Joint joint = move_together(axes, {.min_duration_s = std::isnan(least) ? 0 : least});
    ++(std::isnan(found) ? refused : solved);
    ASSERT_EQ(static_cast<bool>(joint), !std::isnan(found)) << row.id << " " << name(joint.reason);
    if (!joint) continue;
    EXPECT_LE(joint.duration_s, found * 1.001) << row.id;
    EXPECT_GE(joint.duration_s, found * 0.99) << row.id;
    for (std::size_t i = 0; i < 2; ++i)
      EXPECT_EQ(judge::verdict(joint.profiles[i], axes[i].from, axes[i].to, axes[i].bounds), "") << row.id;
  }
  EXPECT_GE(solved, 19);
  EXPECT_GE(refused, 3);
}

// A motion drawn at random, and limits close around it: a witness that there is a motion within them in its duration.
class Witnesses {
 public:
  AxisMove next(double duration_s) {
    for (;;) {
      AxisMove m;
      m.bounds = AxisBounds(bound(), -bound(), bound(), -bound(), bound(), -bound());
      m.from = {uniform(-1, 1), uniform(-1, 1), uniform(-1, 1)};
      Profile witness{m.from, {}};
      for (int i = 0; i < 5; ++i) witness.phases.push_back({duration_s / 5, uniform(m.bounds.j_min, m.bounds.j_max)});
      m.to = end_state(witness);
      const judge::Integrated x = judge::integrate(witness);
      const double room = std::pow(10.0, uniform(-3.5, -0.5)) * static_cast<double>(x.p_high - x.p_low);
      m.bounds.p_min = static_cast<double>(x.p_low) - room * uniform(0, 1);
      m.bounds.p_max = static_cast<double>(x.p_high) + room * uniform(0, 1);
      if (judge::tenable(m.from, m.bounds, 1) && judge::tenable(m.to, m.bounds, -1) &&
          judge::verdict(witness, m.from, m.to, m.bounds).empty())
        return m;
    }
  }
  double uniform(double lo, double hi) { return std::uniform_real_distribution<double>(lo, hi)(random_); }

 private:
  double bound() { return uniform(0.5, 4); }
  std::mt19937_64 random_{20240612};
};

TEST(PositionLimits, several_axes_keep_them_where_a_random_motion_does) {
  Witnesses witnesses;
  int bent = 0, longer = 0;
  constexpr int kCases = 3000;
  for (int n = 0; n < kCases; ++n) {
    const double t = witnesses.uniform(0.3, 6);
    AxisMove axes[] = {witnesses.next(t), witnesses.next(t)};
    const double least = n % 2 ? t : 0;
    const Joint joint = move_together(axes, {.min_duration_s = least});
    ASSERT_TRUE(joint) << "case " << n << " axis " << int{joint.axis} << " " << name(joint.reason);
    longer += joint.duration_s > 1.001 * t;
    for (std::size_t i = 0; i < 2; ++i) {
      ASSERT_EQ(judge::verdict(joint.profiles[i], axes[i].from, axes[i].to, axes[i].bounds), "") << "case " << n;
      ASSERT_NEAR(duration(joint.profiles[i]), joint.duration_s, 1e-12 * (1 + joint.duration_s)) << "case " << n;
      axes[i].bounds.p_min = -HUGE_VAL, axes[i].bounds.p_max = HUGE_VAL;
    }
    const Joint open = move_together(axes, {.min_duration_s = least});
    for (std::size_t i = 0; i < 2; ++i) {
      const judge::Integrated x = judge::integrate(open.profiles[i]), y = judge::integrate(joint.profiles[i]);
      bent += x.p_high > y.p_high + 1e-6 || x.p_low < y.p_low - 1e-6;
    }
  }
  EXPECT_GT(bent, 300) << "limits should matter";
  EXPECT_EQ(longer, 0);
}

TEST(PositionLimits, a_wait_is_found_where_the_motion_that_is_bent_would_coast_faster_than_its_bound) {
  // Bent to the upper limit, it would have left it with an acceleration that takes it beyond v_min.
  AxisBounds b(3.4828697780699209, 1.9836375723071127, 3.059279416512203);
  b.v_min = -0.80455300908880434, b.a_min = -3.1636463648936433, b.j_min = -3.5397236132083472;
  b.p_min = -0.85862904173824572, b.p_max = 2.1522008595111379;
  const AxisMove m{{-0.84364113544844754, 0, -0.16342800218942752},
                   {1.9550451915706548, -0.33969674586653598, 0.28048411845280263},
                   b};
  const Joint joint = move_together(std::span(&m, 1), {.min_duration_s = 7.9838790527555954});
  ASSERT_TRUE(joint) << name(joint.reason);
  EXPECT_NEAR(joint.duration_s, 7.9838790527555954, 1e-9);
  EXPECT_EQ(judge::verdict(joint.profiles[0], m.from, m.to, b), "");
}

TEST(PositionLimits, are_kept_on_a_grid_of_durations_however_long) {
  Witnesses random;
  int solved = 0;
  for (int n = 0; n < 2000; ++n) {
    AxisMove axes[] = {random.next(1), random.next(1)};
    for (AxisMove& m : axes) m.to.v = m.to.a = 0, m.bounds.p_max += 3, m.bounds.p_min -= 3;
    const double least = random.uniform(0, 12);
    const Joint joint = move_together(axes, {.min_duration_s = least, .cycle_s = 0.001});
    if (joint.reason == Reason::StartCannotStay) continue;
    ++solved;
    ASSERT_TRUE(joint) << "case " << n << " " << name(joint.reason);
    ASSERT_GE(joint.duration_s, least * (1 - 1e-12));
    ASSERT_NEAR(std::round(joint.duration_s * 1000), joint.duration_s * 1000, 1e-6);
    for (std::size_t i = 0; i < 2; ++i)
      ASSERT_EQ(judge::verdict(joint.profiles[i], axes[i].from, axes[i].to, axes[i].bounds), "") << "case " << n;
  }
  EXPECT_GT(solved, 1900);
}

TEST(PositionLimits, bound_the_line_of_a_phase_synchronised_motion) {
  // x has no limits of its own; y does twice the same and has.
  const State from{-1.07, -0.595, 0}, to{-1.4528, 0, 0};
  const auto twice = [](const State& x) { return State{2 * x.p, 2 * x.v, 2 * x.a}; };
  AxisMove axes[] = {{from, to, {3.32, 3, 1.226}}, {twice(from), twice(to), {6.64, 6, 2.452}}};
  const Joint open = move_together(axes, {.sync = Sync::Phase});
  ASSERT_TRUE(open);
  axes[1].bounds.p_min = 2 * -1.4655, axes[1].bounds.p_max = 2 * 1.4655;
  EXPECT_LT(extent(open.profiles[1]).low, axes[1].bounds.p_min);
  const Joint joint = move_together(axes, {.sync = Sync::Phase});
  ASSERT_TRUE(joint) << name(joint.reason);
  EXPECT_TRUE(joint.straight);
  EXPECT_GT(joint.duration_s, open.duration_s);
  for (std::size_t i = 0; i < 2; ++i)
    EXPECT_EQ(judge::verdict(joint.profiles[i], axes[i].from, axes[i].to, axes[i].bounds), "");
  for (int k = 0; k < 20; ++k) {
    const double t = joint.duration_s * k / 20;
    EXPECT_NEAR(evaluate(joint.profiles[1], t).p, 2 * evaluate(joint.profiles[0], t).p, 1e-12);
  }
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
