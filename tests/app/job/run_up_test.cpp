// Which way a bead is begun where its run-up is blocked. The wall that blocks it is a distance; the judge of each
// length is the textbook's: from rest to v at jerk j takes v sqrt(v/j), where the acceleration's limit is not come to.
#include "app/job/run_up.hpp"

#include <cmath>
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "motion/geometry.hpp"

namespace gantry::job {
namespace {

constexpr double kSpeed = 20, kJerk = 0.98 * 80000;  // beads use so much of it

motion::Limits three_axes() {
  motion::Limits l;
  l.axes = 3;
  for (std::size_t i = 0; i < 3; ++i) l.axis[i] = {-500, 500, 500, 4000, 80000}, l.linear[i] = true;
  l.tick_s = 0.001;
  return l;
}

double run_up_mm(double v) { return v * std::sqrt(v / kJerk); }

motion::BeadSpec a_line(double speed_mm_s) {
  motion::BeadSpec spec;
  spec.points = {{0, 0, 0}, {30, 0, 0}};
  spec.speed_mm_s = speed_mm_s;
  spec.valve = 1, spec.lift_axis = 2;
  return spec;
}

recipes::Material glue(double min_speed, double speed = kSpeed) {
  recipes::Material m;
  m.name = "glue", m.speed = speed, m.retract = 3, m.min_speed = min_speed;
  return m;
}

/// A wall so far before the bead's first point, or before where it was cut, and so high.
struct Wall {
  double at_mm = 0, high_mm = 1e9, cut_mm = 0;
  int asked = 0;
  Result<void> operator()(const motion::BeadMotion& bead, RunUp::Kind) {
    ++asked;
    for (std::size_t k = 0; k < bead.bead_begin; ++k)
      for (int n = 0; n <= 20; ++n) {
        const motion::Geometry& g = bead.segments[k].geometry;
        const AxisVec q = motion::point(g, g.length * n / 20);
        if (q[0] < cut_mm - at_mm - 1e-9 && q[2] < high_mm)
          return fail(Fault::Collision, "needle comes within 2 mm of post");
      }
    return {};
  }
};

Result<BegunBead> begun(Wall& wall, const recipes::Material& m) {
  return plan_begin(three_axes(), a_line(m.speed), m,
                    [&](const auto& bead, RunUp::Kind kind) { return wall(bead, kind); });
}

TEST(RunUp, is_whole_where_it_is_free) {
  Wall wall{run_up_mm(kSpeed) + 0.01};
  const auto bead = begun(wall, glue(5));
  ASSERT_TRUE(bead);
  EXPECT_EQ(bead->how.kind, RunUp::Kind::Whole);
  EXPECT_NEAR(bead->how.entry_mm_s, kSpeed, 0.02 * kSpeed);
  EXPECT_NEAR(bead->how.mm, run_up_mm(kSpeed), 0.03);
  EXPECT_EQ(wall.asked, 1);
}

TEST(RunUp, is_as_short_as_the_body_asks_for_at_the_highest_entry_speed_that_is_free) {
  for (const double min_speed : {0.0, 2.0, 8.0})
    for (const double entry : {9.5, 12.0, 16.0, 19.5}) {
      Wall wall{run_up_mm(entry)};
      const auto bead = begun(wall, glue(min_speed));
      ASSERT_TRUE(bead) << bead.error().message;
      EXPECT_EQ(bead->how.kind, RunUp::Kind::Shorter);
      const double step = (kSpeed - min_speed) / 16;
      EXPECT_LE(bead->how.entry_mm_s, entry + 1e-6);
      EXPECT_GE(bead->how.entry_mm_s, entry - 1.3 * step) << min_speed;
      EXPECT_LE(bead->how.mm, wall.at_mm + 1e-9);
      EXPECT_NE(bead->how.blocked.find("post"), std::string::npos);
      EXPECT_LE(wall.asked, 6);
    }
}

TEST(RunUp, comes_from_above_where_the_body_is_low_and_no_shorter_one_is_allowed) {
  // At 100 mm/s a tenth of the run-up is done 31 ms after its start, 43 ms before its end; there the needle, which
  // brakes at its jerk, is still j t^3 / 6 = 0.97 mm high.
  const double fast = 100;
  Wall wall{0.9 * run_up_mm(fast), 0.8}, higher{0.9 * run_up_mm(fast), 1.1};
  const auto bead = begun(wall, glue(fast, fast));
  ASSERT_TRUE(bead) << bead.error().message;
  EXPECT_EQ(bead->how.kind, RunUp::Kind::FromAbove);
  EXPECT_NEAR(bead->how.entry_mm_s, fast, 0.02 * fast);
  EXPECT_FALSE(begun(higher, glue(fast, fast)));
  EXPECT_NEAR(bead->motion.start[2], 3, 1e-9);
}

TEST(RunUp, is_left_out_where_nothing_else_is_free_and_min_speed_allows_it) {
  Wall wall{0};
  const auto bead = begun(wall, glue(0));
  ASSERT_TRUE(bead) << bead.error().message;
  EXPECT_EQ(bead->how.kind, RunUp::Kind::FromRest);
  EXPECT_EQ(bead->how.entry_mm_s, 0);
  EXPECT_EQ(bead->motion.bead_begin, 0u);
}

TEST(RunUp, that_is_blocked_in_every_way_is_named) {
  Wall wall{0.01};
  const auto none = begun(wall, glue(10));
  ASSERT_FALSE(none);
  EXPECT_EQ(none.error().fault, Fault::Collision);
  for (const std::string word : {"run-up", "post", "min_speed", "10 mm/s"})
    EXPECT_NE(none.error().message.find(word), std::string::npos) << none.error().message;
}

TEST(RunUp, is_none_where_the_material_has_a_start_dwell_and_nothing_else_is_tried) {
  recipes::Material m = glue(0);
  m.start_dwell_s = 0.2;
  Wall free{0};
  const auto bead = begun(free, m);
  ASSERT_TRUE(bead);
  EXPECT_EQ(bead->how.kind, RunUp::Kind::Whole);
  EXPECT_EQ(bead->motion.bead_begin, 0u);
  int asked = 0;
  const auto blocked = plan_begin(three_axes(), a_line(kSpeed), m, [&](const auto&, RunUp::Kind) -> Result<void> {
    ++asked;
    return fail(Fault::Collision, "needle comes within 2 mm of post");
  });
  EXPECT_FALSE(blocked);
  EXPECT_EQ(asked, 1);
}

constexpr double kCut_mm = 12;

motion::BeadSpec a_cut_line(double speed_mm_s) {
  motion::BeadSpec spec = a_line(speed_mm_s);
  spec.begin_mm = kCut_mm, spec.lift_mm = 0.6;
  return spec;
}

Result<BegunBead> joined(Wall& wall, const recipes::Material& m) {
  return plan_begin(three_axes(), a_cut_line(m.speed), m,
                    [&](const auto& bead, RunUp::Kind kind) { return wall(bead, kind); });
}

TEST(RunUp, of_a_bead_that_was_cut_is_shorter_where_a_body_is_in_the_way) {
  for (const double min_speed : {0.0, 8.0})
    for (const double entry : {9.5, 16.0, 19.5}) {
      Wall wall{run_up_mm(entry), 1e9, kCut_mm};
      const auto bead = joined(wall, glue(min_speed));
      ASSERT_TRUE(bead) << bead.error().message;
      EXPECT_EQ(bead->how.kind, RunUp::Kind::Shorter);
      EXPECT_TRUE(bead->how.joins);
      EXPECT_GE(bead->motion.start[0], kCut_mm - wall.at_mm - 1e-9);
      EXPECT_GE(bead->how.entry_mm_s, entry - 1.3 * (kSpeed - min_speed) / 16) << min_speed;
      EXPECT_NEAR(bead->motion.bead_length_mm, 30 - kCut_mm, 1e-6);
      const std::string words = in_words(bead->how, glue(min_speed));
      EXPECT_EQ(words.substr(0, 11), "goes on at ") << words;
      EXPECT_NE(words.find("post"), std::string::npos) << words;
    }
}

TEST(RunUp, of_a_bead_that_was_cut_is_none_where_nothing_else_is_free) {
  Wall wall{0, 1e9, kCut_mm}, another = wall;
  const auto bead = joined(wall, glue(0));
  ASSERT_TRUE(bead) << bead.error().message;
  EXPECT_EQ(bead->how.kind, RunUp::Kind::FromRest);
  EXPECT_NEAR(bead->motion.start[0], kCut_mm, 1e-9);
  EXPECT_EQ(bead->motion.start[2], 0);
  const auto none = joined(another, glue(10));
  ASSERT_FALSE(none);
  for (const std::string word : {"run-up", "post", "min_speed", "10 mm/s"})
    EXPECT_NE(none.error().message.find(word), std::string::npos) << none.error().message;
}

TEST(RunUp, of_a_bead_that_was_cut_comes_from_retract_where_the_body_is_low) {
  Wall wall{4, 1, kCut_mm};
  const auto bead = joined(wall, glue(kSpeed));
  ASSERT_TRUE(bead) << bead.error().message;
  EXPECT_EQ(bead->how.kind, RunUp::Kind::FromAbove);
  EXPECT_NEAR(bead->motion.start[2], 3, 1e-9);
  EXPECT_NEAR(bead->how.entry_mm_s, kSpeed, 0.02 * kSpeed);
}

TEST(RunUp, a_plan_that_is_given_up_ends_the_search) {
  int asked = 0;
  const auto given_up =
      plan_begin(three_axes(), a_line(kSpeed), glue(0), [&](const auto&, RunUp::Kind) -> Result<void> {
        return ++asked == 1 ? fail(Fault::Collision, "post") : fail(Fault::Aborted, "given up");
      });
  ASSERT_FALSE(given_up);
  EXPECT_EQ(given_up.error().fault, Fault::Aborted);
  EXPECT_EQ(asked, 2);
}

}  // namespace
}  // namespace gantry::job
