// A bead's own plan, played at other rates: the judge of the watch is the rate.
#include "app/job/speed_watch.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <functional>
#include <gtest/gtest.h>

#include "motion/path/bead.hpp"
#include "motion/profile/planner.hpp"
#include "motion/profile/speed_profile.hpp"

namespace gantry::job {
namespace {

constexpr double kTick_s = 0.001, kSpeed = 20;

motion::Limits limits() {
  motion::Limits l;
  l.axes = 3;
  for (std::size_t i = 0; i < 3; ++i) l.axis[i] = {-500, 500, 500, 4000, 80000}, l.linear[i] = true;
  l.tick_s = kTick_s;
  return l;
}

recipes::Recipe recipe(bool follows) {
  const auto parsed = recipes::parse(
      fmt::format("version: 1\nrecipe: r\nboard: {{size: [90 mm, 60 mm], thickness: 8 mm, frame: pallet}}\nmaterials:\n"
                  "  a: {{speed: 20 mm/s, gap: 0.2 mm, valve_open_lead: 8 ms, valve_close_lead: 6 ms, dot_time: 60 ms, "
                  "retract: 3 mm, flow_follows_speed: {}}}\nfeatures:\n"
                  "  - polyline: {{name: f, material: a, points: [[10 mm, 10 mm], [40 mm, 10 mm], [40 mm, 40 mm]]}}\n",
                  follows),
      "r.yaml");
  return parsed.value();
}

/// The bead of `recipe`, played so fast: 1 is as planned.
std::vector<OffSpeed> play(const recipes::Recipe& recipe, const std::function<double(double t_s)>& rate) {
  motion::BeadSpec spec;
  spec.points = {{10, 10, 0}, {40, 10, 0}, {40, 40, 0}};
  spec.speed_mm_s = kSpeed, spec.valve = 1, spec.open_lead_s = 0.008, spec.close_lead_s = 0.006;
  const auto bead = motion::plan_bead(limits(), spec);
  std::deque<motion::Segment> segments(bead->segments.begin(), bead->segments.end());
  double length_mm = 0;
  for (auto& s : segments) s.feature = 0, length_mm += s.geometry.length;
  SpeedWatch watch(recipe, kTick_s);
  watch.begin(segments);
  double s_mm = 0;
  std::size_t at = 0;
  double into_s = 0;
  for (double t = 0; at < segments.size(); t += kTick_s) {
    const double r = rate(t);
    into_s += kTick_s * r;
    while (at < segments.size() && into_s >= motion::duration(segments[at].nominal))
      into_s -= motion::duration(segments[at++].nominal);
    if (at == segments.size()) break;
    const double v = motion::along(segments[at].nominal, into_s).x.v * r;
    s_mm += v * kTick_s;
    const bool open = s_mm > bead->run_up_mm && s_mm < length_mm - bead->run_out_mm;
    watch.see({.feature = 0, .valve_open = open, .path_speed_mm_s = v});
  }
  watch.end();
  return watch.off_speed();
}

TEST(SpeedWatch, a_bead_as_planned_is_at_its_speed_corners_and_all) {
  EXPECT_TRUE(play(recipe(false), [](double) { return 1.0; }).empty());
}

TEST(SpeedWatch, a_bead_at_another_rate_is_named_with_its_speeds) {
  for (const double rate : {0.3, 0.5, 0.9, 1.1, 2.0}) {
    const auto off = play(recipe(false), [&](double) { return rate; });
    ASSERT_EQ(off.size(), 1u) << rate;
    EXPECT_EQ(off[0].feature, 0u);
    EXPECT_NEAR(off[0].asked_mm_s, kSpeed, 0.2);
    EXPECT_NEAR(off[0].worst_mm_s, kSpeed * rate, 0.4);
    EXPECT_GT(off[0].length_mm, 40);
    EXPECT_LT(off[0].length_mm, 60) << "the bead has no more, however slowly it was dispensed";
  }
}

TEST(SpeedWatch, what_the_material_allows_is_no_defect) {
  for (const double rate : {0.96, 1.04}) EXPECT_TRUE(play(recipe(false), [&](double) { return rate; }).empty()) << rate;
  EXPECT_TRUE(play(recipe(true), [](double) { return 2.0; }).empty()) << "its flow follows the speed";
}

TEST(SpeedWatch, a_dip_along_the_bead_is_seen_and_one_in_the_run_up_is_not) {
  const auto dip = [](double from_s, double to_s) {
    return [=](double t) { return t > from_s && t < to_s ? 0.5 : 1.0; };
  };
  const auto off = play(recipe(false), dip(0.8, 0.9));
  ASSERT_EQ(off.size(), 1u);
  EXPECT_NEAR(off[0].length_mm, 1, 0.3) << "0.1 s at 10 mm/s";
  EXPECT_NEAR(off[0].due_mm, 2, 0.6) << "of 0.1 s at 20 mm/s";
  const auto stood = play(recipe(false), [](double t) { return t > 0.8 && t < 0.9 ? 1e-6 : 1.0; });
  ASSERT_EQ(stood.size(), 1u) << "a needle that stands dispenses, too";
  EXPECT_NEAR(stood[0].length_mm, 0, 1e-3);
  EXPECT_TRUE(play(recipe(false), dip(0, 0.004)).empty());
}

TEST(SpeedWatch, a_plan_that_stands_in_mid_bead_is_told_unless_the_recipe_asks_for_it) {
  const auto as_planned = [](double) { return 1.0; };
  recipes::Recipe asks = recipe(false), rounds = asks;
  std::get<recipes::Bead>(rounds.features[0]).corner_tolerance = 1e-4;  // too little to be rounded in
  EXPECT_TRUE(play(asks, as_planned).empty());
  const auto seen = play(rounds, as_planned);
  ASSERT_EQ(seen.size(), 1u);
  EXPECT_EQ(seen[0].feature, 0u);
  EXPECT_EQ(seen[0].stands, 1u);
  EXPECT_NEAR(seen[0].stands_at_mm, 30, 1e-6);
  EXPECT_EQ(seen[0].due_mm, 0) << "it is at its speed where it is steady";
}

}  // namespace
}  // namespace gantry::job
