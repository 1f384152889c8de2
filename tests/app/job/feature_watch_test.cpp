#include "app/job/feature_watch.hpp"

#include <gtest/gtest.h>
#include <numeric>
#include <random>

namespace gantry::job {
namespace {

using enum FeatureState;

/// A made-up loop: the path and the valve, cycle by cycle.
struct Loop {
  std::vector<FeatureState> features;
  FeatureWatch watch;
  std::uint32_t feature = motion::kTravel;
  bool valve = false, stopped = false;
  int changes = 0;

  explicit Loop(std::size_t n) : Loop(n, in_file(n)) {}
  Loop(std::size_t n, std::vector<std::size_t> order) : features(n, Open), watch(std::move(order)) {}
  static std::vector<std::size_t> in_file(std::size_t n) {
    std::vector<std::size_t> order(n);
    std::iota(order.begin(), order.end(), 0u);
    return order;
  }
  Loop& pass(int cycles = 1, std::uint32_t block = 3) {
    for (int i = 0; i < cycles; ++i)
      changes += watch.see(features, {.block = block, .feature = feature, .valve_open = valve, .stopped = stopped});
    return *this;
  }
  Loop& on(std::uint32_t f) { return feature = f, pass(); }
  Loop& travel(int cycles = 100) { return feature = motion::kTravel, pass(cycles); }
  Loop& open(bool is = true) { return valve = is, pass(); }
  Loop& stop(bool is = true) { return stopped = is, pass(); }
};

TEST(FeatureWatch, ahead_of_a_feature_the_valve_opens_for_the_next_in_the_order_of_the_job) {
  Loop loop(3, {0, 2, 1});
  loop.travel().on(0).open().open(false).travel().open();
  EXPECT_EQ(loop.features, (std::vector{Done, Open, Begun}));
  loop.on(2).open(false).travel().open().on(1).open(false);
  EXPECT_EQ(loop.features, (std::vector{Done, Done, Done}));

  Loop cut(3, {0, 2, 1});
  cut.travel().on(0).open().open(false).travel().open().on(2).stop().open(false);
  EXPECT_EQ(cut.features, (std::vector{Done, Open, Interrupted}));
}

TEST(FeatureWatch, a_feature_is_done_when_its_valve_has_closed_and_not_before) {
  Loop loop(3);
  loop.travel().on(0);
  EXPECT_EQ(loop.features[0], Open) << "the needle is there, nothing has come out";
  loop.open();
  EXPECT_EQ(loop.features[0], Begun);
  loop.open(false);
  EXPECT_EQ(loop.features[0], Done);
  loop.travel().on(1).open().open(false);
  EXPECT_EQ(loop.features, (std::vector{Done, Done, Open}));
  EXPECT_EQ(loop.changes, 4);
}

TEST(FeatureWatch, the_valve_may_open_ahead_of_its_feature_and_close_behind_it) {
  Loop loop(2);
  loop.travel().open();  // by its lead
  EXPECT_EQ(loop.features[0], Begun);
  loop.on(0).pass(20).travel(5).open(false);  // the outputs come later than the path
  EXPECT_EQ(loop.features, (std::vector{Done, Open}));
  loop.travel().open().open(false).on(1).travel();  // a short dot with long leads
  EXPECT_EQ(loop.features, (std::vector{Done, Done}));
}

TEST(FeatureWatch, a_dot_shorter_than_the_delay_of_the_outputs_is_its_own) {
  Loop loop(2);
  loop.travel().on(0).travel(3).open().open(false).travel();
  EXPECT_EQ(loop.features, (std::vector{Done, Open}));
}

TEST(FeatureWatch, a_stop_that_closes_the_valve_interrupts_and_resuming_does_not_mend_it) {
  Loop loop(2);
  loop.on(0).open();
  loop.stopped = true, loop.open(false);
  EXPECT_EQ(loop.features[0], Interrupted);
  loop.stop(false).pass(50).travel().on(1).open().open(false);
  EXPECT_EQ(loop.features, (std::vector{Interrupted, Done}));
}

TEST(FeatureWatch, a_hold_before_the_valve_opens_leaves_the_feature_whole) {
  Loop loop(1);
  loop.on(0).stop().pass(30).stop(false).open().open(false).travel();
  EXPECT_EQ(loop.features[0], Done);
}

TEST(FeatureWatch, a_feature_that_a_stop_has_kept_dry_is_interrupted) {
  Loop loop(2);
  loop.on(0).stop().pass(30).stop(false).pass(30).travel();  // the opening was passed while braking
  EXPECT_EQ(loop.features, (std::vector{Interrupted, Open}));
  loop.open().on(1).open(false).travel();
  EXPECT_EQ(loop.features, (std::vector{Interrupted, Done}));
}

TEST(FeatureWatch, an_opening_that_a_hold_takes_back_and_gives_again_is_of_the_same_feature) {
  Loop loop(3);
  loop.on(0).open().open(false).travel().open();
  loop.stopped = true, loop.open(false);
  EXPECT_EQ(loop.features, (std::vector{Done, Interrupted, Open})) << "a drop beside it";
  loop.stop(false).travel().open().on(1).open(false).travel();
  EXPECT_EQ(loop.features, (std::vector{Done, Interrupted, Open}));
  loop.on(2).open().open(false).travel();
  EXPECT_EQ(loop.features, (std::vector{Done, Interrupted, Done}));
}

TEST(FeatureWatch, an_abort_before_the_valve_opens_leaves_the_feature_open) {
  Loop loop(2);
  loop.on(0).stop().pass(20);
  loop.pass(200, 0);
  EXPECT_EQ(loop.features, (std::vector{Open, Open}));
}

TEST(FeatureWatch, features_that_are_not_dispensed_are_passed_over) {
  Loop loop(4);
  loop.features = {Done, Interrupted, Open, Open};
  loop.travel().open().on(2).open(false).travel();
  EXPECT_EQ(loop.features, (std::vector{Done, Interrupted, Done, Open}));
}

TEST(FeatureWatch, random_runs_agree_with_what_the_valve_was_opened_for) {
  std::mt19937_64 random(20);
  const auto from_to = [&](int low, int high) { return std::uniform_int_distribution<int>(low, high)(random); };
  for (int n = 0; n < 3000; ++n) {
    Loop loop(6);
    std::vector<FeatureState> expected(6, Done);
    for (std::uint32_t f = 0; f < 6; ++f) {
      // Cycles from the start of the travel there: when the path comes and goes, when the valve opens and closes.
      const int come = from_to(70, 200), stay = from_to(1, 80);
      const int opens = come - from_to(0, 60) + from_to(0, 10), closes = opens + from_to(1, 90);
      const bool cut = from_to(0, 5) == 0;
      if (cut) expected[f] = Interrupted;
      for (int t = 0; t < std::max(come + stay, closes) + 70; ++t) {
        loop.feature = t >= come && t < come + stay ? f : motion::kTravel;
        loop.valve = t >= opens && t < closes;
        loop.stopped = cut && t >= closes && t < closes + 10;
        loop.pass();
      }
    }
    ASSERT_EQ(loop.features, expected) << n;
  }
}

}  // namespace
}  // namespace gantry::job
