#include "devices/rt/scale.hpp"

#include <gtest/gtest.h>
#include <limits>
#include <random>

namespace gantry::devices {
namespace {

TEST(AxisScale, goes_to_counts_and_back_within_half_a_count) {
  const unsigned seed = 1;
  SCOPED_TRACE(seed);
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> place(-2000, 2000);
  for (const bool invert : {false, true}) {
    AxisScale s(2000.0 / 3.0, invert);
    s.set_reference(Counts{-777}, 12.34);
    for (int i = 0; i < 10'000; ++i) {
      const double mm = place(random);
      const Counts c = s.to_counts(mm);
      EXPECT_LE(std::abs(s.to_position(c) - mm), 0.5 / (2000.0 / 3.0) + 1e-9);
      EXPECT_EQ(s.to_counts(s.to_position(c)), c);
    }
  }
}

TEST(AxisScale, a_reference_puts_a_count_on_a_coordinate) {
  AxisScale s(2000, true);
  s.set_reference(Counts{0}, 5.0);
  EXPECT_DOUBLE_EQ(s.to_position(Counts{0}), 5.0);
  EXPECT_EQ(s.to_counts(4.0).value, 2000);
}

TEST(Unwrap, follows_a_counter_round_and_round) {
  const unsigned seed = 2;
  SCOPED_TRACE(seed);
  std::mt19937_64 random(seed);
  std::uniform_int_distribution<std::int64_t> step(-2'000'000'000, 2'000'000'000);
  Unwrap u;
  std::int64_t truth = std::numeric_limits<std::int32_t>::max() - 1000;
  u.step(static_cast<std::int32_t>(truth));
  for (int i = 0; i < 100'000; ++i) {
    truth += step(random);
    ASSERT_EQ(u.step(wrap(Counts{truth})).value, truth);
  }
}

}  // namespace
}  // namespace gantry::devices
