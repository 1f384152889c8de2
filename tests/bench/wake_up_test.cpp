// The bench's own arithmetic: a bench that misreads its peer compares nothing.
#include <gtest/gtest.h>

#include "bench/wake_up/cyclictest.hpp"
#include "bench/wake_up/subject.hpp"

namespace gantry::bench {
namespace {

TEST(Latencies, quantiles_of_a_known_distribution) {
  Latencies l;
  EXPECT_EQ(l.quantile(0.5), 0);
  for (int us = 0; us < 1000; ++us) l.add(us);
  EXPECT_EQ(l.quantile(0.5), 500);
  EXPECT_EQ(l.quantile(0.99), 990);
  EXPECT_EQ(l.quantile(0.999), 999);
  EXPECT_EQ(l.quantile(1), 999);
  EXPECT_EQ(l.above(989), 10u);
  EXPECT_EQ(l.above(5000), 0u);
}

// A loop of 1 ms that wakes 5.3 ms late has slept through five deadlines; one that wakes 0.9 ms late through none.
TEST(Latencies, periods_slept_through_are_counted_each) {
  Latencies l;
  l.add(900, 100);
  EXPECT_EQ(l.whole(1000), 0u);
  l.add(5300);
  l.add(1000, 2);
  EXPECT_EQ(l.whole(1000), 7u);
}

// Printed by `cyclictest -q -m -p 90 -i 1000 -t 1 -l 1000 -h 5` of rt-tests 2.4, shortened.
constexpr const char* kPrinted =
    "# /dev/cpu_dma_latency set to 0us\n"
    "# Histogram\n"
    "000000 000000\n"
    "000001 000003\n"
    "000002 000900\n"
    "000003 000094\n"
    "000004 000000\n"
    "# Total: 000000997\n"
    "# Min Latencies: 00001\n"
    "# Avg Latencies: 00002\n"
    "# Max Latencies: 00521\n"
    "# Histogram Overflows: 00003\n"
    "# Histogram Overflow at cycle number:\n"
    "# Thread 0: 00000 00016 00017\n";

TEST(Cyclictest, histogram_is_read_with_its_overflows_at_the_maximum) {
  const auto l = parse_histogram(kPrinted);
  ASSERT_TRUE(l);
  EXPECT_EQ(l->count(), 1000u);
  EXPECT_EQ(l->quantile(0), 1);
  EXPECT_EQ(l->quantile(0.5), 2);
  EXPECT_EQ(l->quantile(0.95), 3);
  EXPECT_EQ(l->quantile(0.999), 521);
  EXPECT_EQ(l->max(), 521);
}

TEST(Cyclictest, anything_else_is_an_error) {
  EXPECT_FALSE(parse_histogram(""));
  EXPECT_FALSE(parse_histogram("Unable to change scheduling policy!\n"));
}

TEST(Summary, wake_up_and_cost_are_read_and_a_loop_without_priority_is_no_measure) {
  const std::string text =
      R"({"cycle": {"cycles": 40000, "deadline_misses": 7, "skipped": 5, "stalls": 2, "real_time_priority": true,
    "wake_us": {"p50": 12.5, "p99": 40, "p99_9": 90.25, "max": 1234},
    "compute_us": {"p50": 5, "p99": 6, "p99_9": 9, "max": 30}}})";
  const auto f = parse_summary(text);
  ASSERT_TRUE(f) << f.error().message;
  EXPECT_EQ(f->at, (std::array<double, 3>{12.5, 40, 90.25}));
  EXPECT_EQ(f->stalls, 2u);
  EXPECT_EQ(f->slept, 5u);
  EXPECT_EQ(f->missed, 7u);
  EXPECT_EQ(f->cycles, 40000u);
  EXPECT_EQ(f->cost, "5.0 / 6.0 / 9.0 / 30.0");
  std::string refused = text;
  refused.replace(refused.find("true"), 4, "false");
  EXPECT_EQ(parse_summary(refused).error().fault, Fault::RealTimeRefused);
  EXPECT_FALSE(parse_summary("{}"));
  EXPECT_FALSE(parse_summary(""));
}

}  // namespace
}  // namespace gantry::bench
