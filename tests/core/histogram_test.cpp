// Judge: the sorted samples themselves.
#include "core/rt/histogram.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <random>
#include <vector>

namespace gantry::rt {
namespace {

class HistogramTest : public testing::TestWithParam<double> {};

TEST_P(HistogramTest, quantile_is_at_or_less_than_a_sixteenth_above_the_sorted_samples) {
  constexpr unsigned kSeed = 22;
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  std::mt19937_64 random(kSeed);
  std::lognormal_distribution<double> draw(GetParam(), 1.5);
  Histogram histogram;
  std::vector<std::int64_t> samples;
  for (int i = 0; i < 20000; ++i) {
    const auto ns = static_cast<std::int64_t>(draw(random));
    samples.push_back(ns);
    histogram.add(ns);
  }
  std::sort(samples.begin(), samples.end());
  for (const double q : {0.0, 0.01, 0.5, 0.9, 0.99, 0.999, 0.9999}) {
    const std::int64_t exact = samples[static_cast<std::size_t>(q * static_cast<double>(samples.size()))];
    EXPECT_GE(histogram.quantile(q), exact) << "q " << q;
    EXPECT_LE(static_cast<double>(histogram.quantile(q)), static_cast<double>(exact) * (1 + 1.0 / 16)) << "q " << q;
  }
  EXPECT_EQ(histogram.quantile(1), samples.back());
  EXPECT_EQ(histogram.max(), samples.back());
  EXPECT_EQ(histogram.count(), samples.size());
}

// From a few ns to half a minute.
INSTANTIATE_TEST_SUITE_P(Scales, HistogramTest, testing::Values(1.0, 4.0, 9.0, 15.0, 24.0));

TEST(Histogram, small_values_are_exact) {
  for (int v = 0; v < 32; ++v) {
    Histogram h;
    h.add(v);
    h.add(1000);
    EXPECT_EQ(h.quantile(0), v);
  }
}

TEST(Histogram, bucket_edges_hold_around_every_power_of_two) {
  for (int bit = 4; bit < 40; ++bit)
    for (const std::int64_t off : {-1, 0, 1}) {
      const std::int64_t v = (std::int64_t{1} << bit) + off;
      Histogram h;
      h.add(v);
      h.add(std::int64_t{1} << 42);
      EXPECT_GE(h.quantile(0), v);
      EXPECT_LE(static_cast<double>(h.quantile(0)), static_cast<double>(v) * (1 + 1.0 / 16)) << v;
    }
}

TEST(Histogram, empty_negative_and_huge_values_stay_in_bounds) {
  Histogram h;
  EXPECT_EQ(h.quantile(0.5), 0);
  h.add(-5);
  EXPECT_EQ(h.quantile(0.5), 0);
  h.add(std::numeric_limits<std::int64_t>::max());
  EXPECT_EQ(h.max(), std::numeric_limits<std::int64_t>::max());
  EXPECT_EQ(h.quantile(0), 0);
  EXPECT_GT(h.quantile(0.9), std::int64_t{500} * 1'000'000'000);
}

}  // namespace
}  // namespace gantry::rt
