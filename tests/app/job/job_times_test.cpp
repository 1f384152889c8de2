// What a job takes beside what was forecast, from cycles that are made up here.
#include "app/job/job_times.hpp"

#include <gtest/gtest.h>

namespace gantry::job {
namespace {

constexpr double kCycle_s = 0.001;

class JobTimesTest : public ::testing::Test {
 protected:
  void pass(double seconds, std::uint32_t feature = motion::kTravel, double rate = 1, bool stopped = false) {
    for (int i = 0; i < static_cast<int>(seconds / kCycle_s + 0.5); ++i)
      times.see({.plays = true, .feature = feature, .rate = rate, .stopped = stopped});
  }

  Forecast forecast{10, {{"mark 'A'", 2}, {"dispense 2 features", 6}, {"park", 2}}, {{1, 2}, {0.5, 2}}};
  JobTimes times{&forecast, 2, kCycle_s};
};

TEST_F(JobTimesTest, what_went_as_forecast_is_told_so) {
  EXPECT_DOUBLE_EQ(*times.left_s(), 10);
  times.begin("mark 'A'");
  pass(1.5);
  EXPECT_NEAR(*times.left_s(), 8.5, 1e-9);
  times.image(0.5);
  times.done();
  EXPECT_NEAR(*times.left_s(), 8, 1e-9) << "the image is over as well";
  times.begin("dispense 2 features");
  pass(1), pass(2, 0), pass(0.5), pass(2, 1), pass(0.5);
  times.done();
  times.begin("park");
  pass(2);
  times.done();
  EXPECT_NEAR(*times.left_s(), 0, 1e-9);
  ASSERT_EQ(times.steps().size(), 3u);
  for (const StepTaken& step : times.steps()) {
    EXPECT_NEAR(step.actual_s, *step.predicted_s, 1e-9) << step.what;
    EXPECT_TRUE(step.done) << step.what;
    EXPECT_FALSE(step.disturbed) << step.what;
  }
  for (const FeatureTaken& feature : times.features()) {
    EXPECT_NEAR(feature.actual.travel_s, feature.predicted.travel_s, 1e-9);
    EXPECT_NEAR(feature.actual.on_it_s, feature.predicted.on_it_s, 1e-9);
    EXPECT_FALSE(feature.disturbed);
  }
  EXPECT_DOUBLE_EQ(times.images_s(), 0.5);
}

TEST_F(JobTimesTest, what_is_planned_where_the_board_lies_takes_the_place_of_the_forecast_until_it_has_begun) {
  times.begin("mark 'A'"), pass(2), times.done();
  times.begin("dispense 2 features");
  times.plan({{1.25, 2.25}, {0, 0}});
  EXPECT_EQ(times.features()[0].predicted.on_it_s, 2.25);
  EXPECT_EQ(times.features()[0].predicted.travel_s, 1.25);
  EXPECT_EQ(times.features()[1].predicted.on_it_s, 2) << "is not in what plays";
  pass(1.25), pass(1, 0);
  times.plan({{0.5, 1.25}, {0.75, 1.75}});  // after a hold, what is left
  EXPECT_EQ(times.features()[0].predicted.on_it_s, 2.25);
  EXPECT_EQ(times.features()[1].predicted.on_it_s, 1.75);
  EXPECT_NEAR(*times.left_s(), 8 - 2.25, 1e-9) << "the forecast is what it was";
}

TEST_F(JobTimesTest, nothing_is_counted_between_blocks) {
  times.begin("mark 'A'");
  for (int i = 0; i < 5000; ++i) times.see({.plays = false});
  EXPECT_EQ(times.steps()[0].actual_s, 0);
  EXPECT_DOUBLE_EQ(*times.left_s(), 10);
}

TEST_F(JobTimesTest, a_hold_disturbs_what_it_falls_on_and_nothing_else) {
  times.begin("mark 'A'"), pass(2), times.done();
  times.begin("dispense 2 features");
  pass(1), pass(1, 0), pass(3, 0, 1, true);
  EXPECT_NEAR(*times.left_s(), 6, 1e-9) << "it does not fall while something stands";
  pass(1, 0), pass(0.5), pass(2, 1), pass(0.5);
  times.done();
  EXPECT_TRUE(times.features()[0].disturbed);
  EXPECT_FALSE(times.features()[1].disturbed);
  EXPECT_NEAR(times.features()[0].actual.on_it_s, 5, 1e-9);
  EXPECT_FALSE(times.steps()[0].disturbed);
  EXPECT_TRUE(times.steps()[1].disturbed);
}

TEST_F(JobTimesTest, half_the_speed_takes_twice_as_long) {
  times.begin("mark 'A'"), pass(2), times.done();
  times.begin("dispense 2 features");
  pass(2, motion::kTravel, 0.5);
  EXPECT_NEAR(*times.left_s(), 7, 1e-9);
  pass(2, 0);
  EXPECT_TRUE(times.features()[0].disturbed) << "on the way to it";
}

TEST_F(JobTimesTest, a_step_that_was_cut_goes_on) {
  times.begin("dispense 2 features"), pass(1);
  times.begin("dispense 1 features"), pass(1), times.done();
  EXPECT_NEAR(times.steps()[0].actual_s, 2, 1e-9);
  EXPECT_TRUE(times.steps()[0].disturbed);
  EXPECT_FALSE(times.steps()[1].done);
}

TEST_F(JobTimesTest, without_a_forecast_steps_are_as_they_came) {
  JobTimes alone(nullptr, 0, kCycle_s);
  EXPECT_FALSE(alone.left_s());
  alone.begin("park");
  alone.see({.plays = true});
  alone.done();
  ASSERT_EQ(alone.steps().size(), 1u);
  EXPECT_EQ(alone.steps()[0].what, "park");
  EXPECT_FALSE(alone.steps()[0].predicted_s);
  EXPECT_DOUBLE_EQ(alone.steps()[0].actual_s, kCycle_s);
}

}  // namespace
}  // namespace gantry::job
