// What a job was forecast to take before its first motion, against the ticks that it took on boards that lie elsewhere.
#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <random>

#include "tests/machine/deposits.hpp"

namespace gantry {
namespace {

using test::Rig;

constexpr double kCycle_s = 0.001;

struct Sums {
  double predicted_s = 0, actual_s = 0;
};

/// Of the steps behind the last touch.
Sums after_touches(const record::JobResult& r) {
  Sums sums;
  for (const job::StepTaken& step : r.steps) {
    if (step.what.find("touch") != std::string::npos || step.what.starts_with("mark")) continue;
    sums.predicted_s += step.predicted_s.value_or(1e9), sums.actual_s += step.actual_s;
  }
  return sums;
}

void expect_forecast(const record::JobResult& r) {
  test::expect_done(r);
  const Sums behind = after_touches(r);
  EXPECT_NEAR(behind.actual_s, behind.predicted_s, 1e-3 * behind.predicted_s);
  EXPECT_NEAR(r.actual_s, r.predicted_s, 0.02 * r.predicted_s);
  double steps_s = 0;
  for (const job::StepTaken& step : r.steps) {
    EXPECT_TRUE(step.done) << step.what;
    EXPECT_FALSE(step.disturbed) << step.what;
    steps_s += step.actual_s;
  }
  EXPECT_NEAR(steps_s, r.actual_s, kCycle_s / 2) << "all that plays is a step's";
  std::size_t dispensed = 0;
  for (std::size_t i = 0; i < r.feature_times.size(); ++i) {
    const job::FeatureTaken& f = r.feature_times[i];
    dispensed += f.actual.on_it_s > 0;
    EXPECT_NEAR(f.actual.on_it_s, f.predicted.on_it_s, 1.5 * kCycle_s) << r.feature_names[i];
    EXPECT_FALSE(f.disturbed) << r.feature_names[i];
  }
  EXPECT_EQ(dispensed, r.features_done);
}

TEST(Forecast, holds_on_boards_that_lie_elsewhere) {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> shift(-1, 1), turn(-0.7, 0.7);
  for (const char* file : {"recipes/demo-board.yaml", "recipes/patterns.yaml"})
    for (int i = 0; i < 3; ++i) {
      const std::string placement =
          fmt::format("dx={:.3f} mm, dy={:.3f} mm, rot={:.3f} deg", shift(random), shift(random), turn(random));
      SCOPED_TRACE(fmt::format("{} at {}", file, placement));
      Rig rig({.placement = placement});
      expect_forecast(rig.run(file));
    }
}

TEST(Forecast, of_work_on_a_part_holds_on_a_board_that_slopes) {
  for (const char* slope :
       {"tilt_x=0 deg, tilt_y=0 deg", "tilt_x=0.02 deg, tilt_y=0 deg", "tilt_x=0.3 deg, tilt_y=-0.2 deg"}) {
    SCOPED_TRACE(slope);
    Rig rig({.placement = fmt::format("dx=0 mm, dy=0 mm, dz=0 mm, rot=0 deg, {}", slope)});
    expect_forecast(rig.run("recipes/on-parts.yaml"));
  }
}

TEST(Forecast, is_exact_on_a_board_that_lies_where_it_should) {
  Rig rig({.placement = "dx=0 mm, dy=0 mm, rot=0 deg, dz=0 mm"});
  const record::JobResult r = rig.run("recipes/demo-board.yaml");
  expect_forecast(r);
  for (const job::StepTaken& step : r.steps)
    EXPECT_NEAR(step.actual_s, *step.predicted_s, 0.012) << step.what << ": half a camera's pixel, a probe's scatter";
  for (std::size_t i = 0; i < r.feature_times.size(); ++i)
    EXPECT_NEAR(r.feature_times[i].actual.on_it_s, r.feature_times[i].predicted.on_it_s, 1.5 * kCycle_s)
        << r.feature_names[i];
}

// Ways around a body are searched by chance: the same ones are taken again, and give way where the board lies
// elsewhere.
TEST(Forecast, of_ways_around_a_bridge_holds) {
  Rig nominal({.placement = "dx=0 mm, dy=0 mm, rot=0 deg, dz=0 mm, tilt_x=0 deg, tilt_y=0 deg"});
  expect_forecast(nominal.run("recipes/portal.yaml"));
  for (const char* at : {"dx=0.4 mm, dy=-0.3 mm, rot=0.2 deg", "dx=-0.6 mm, dy=0.5 mm, rot=-0.3 deg", "dx=0.9 mm"}) {
    SCOPED_TRACE(at);
    Rig rig({.placement = fmt::format("dz=0 mm, tilt_x=0 deg, tilt_y=0 deg, {}", at)});
    const record::JobResult r = rig.run("recipes/portal.yaml");
    test::expect_done(r);
    const Sums behind = after_touches(r);
    EXPECT_NEAR(behind.actual_s, behind.predicted_s, 0.003 * behind.predicted_s);
  }
}

// The probe goes its last millimetres at its own speed, which is all that a board off its height changes: dz / speed.
TEST(Forecast, misses_of_a_board_off_its_height_what_the_probe_goes_down_to_it_and_nothing_else) {
  constexpr double kUp_mm = -1.2;
  Rig rig({.placement = fmt::format("dx=0 mm, dy=0 mm, rot=0 deg, dz={} mm, tilt_x=0 deg, tilt_y=0 deg", kUp_mm)});
  const record::JobResult r = rig.run("recipes/demo-board.yaml");
  test::expect_done(r);
  const double touch_s = -kUp_mm / rig.machine().probe.speed_mm_s;
  int touches = 0;
  for (const job::StepTaken& step : r.steps) {
    const bool touch = step.what.starts_with("touch");
    touches += touch;
    EXPECT_NEAR(step.actual_s - *step.predicted_s, touch ? touch_s : 0, 0.008 + 1e-3 * *step.predicted_s) << step.what;
  }
  EXPECT_EQ(touches, 3);
  EXPECT_NEAR(r.actual_s - r.predicted_s, 3 * touch_s, 2e-3 * r.predicted_s);
}

TEST(Forecast, knows_where_the_second_job_begins) {
  const recipes::Recipe recipe = test::load_recipe("recipes/demo-board.yaml");
  Rig rig({.placement = "dx=0 mm, dy=0 mm, rot=0 deg, dz=0 mm"});
  for (int job = 0; job < 2; ++job) {
    const record::JobResult r = rig.run(recipe);
    SCOPED_TRACE(job);
    expect_forecast(r);
    EXPECT_NEAR(r.steps.front().actual_s, *r.steps.front().predicted_s, 0.012);
  }
}

TEST(Forecast, stays_what_it_was_when_the_job_is_disturbed) {
  Rig plain({.placement = "dx=0 mm, dy=0 mm, rot=0 deg"}), slowed({.placement = "dx=0 mm, dy=0 mm, rot=0 deg"});
  const record::JobResult as_usual = plain.run("recipes/demo-board.yaml");
  int steps = 0;
  slowed.on_step = [&](run::Owner& owner) {
    if (++steps != 20'000) return;
    EXPECT_TRUE(owner.order({.kind = run::OrderKind::Override, .value = 0.5}));
  };
  const record::JobResult r = slowed.run("recipes/demo-board.yaml");
  EXPECT_EQ(r.predicted_s, as_usual.predicted_s);
  EXPECT_GT(r.actual_s, as_usual.actual_s + 5);
  const auto disturbed = [](const job::StepTaken& s) { return s.disturbed; };
  EXPECT_TRUE(std::any_of(r.steps.begin(), r.steps.end(), disturbed));
  EXPECT_FALSE(r.steps.front().disturbed) << "long over";
}

}  // namespace
}  // namespace gantry
