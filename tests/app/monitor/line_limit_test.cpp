#include "app/monitor/line_limit.hpp"

#include <gtest/gtest.h>

namespace gantry::monitor {
namespace {

TEST(LineLimit, lets_a_burst_pass_and_then_one_line_now_and_again) {
  LineLimit limit;
  const Time begin = std::chrono::hours(1000);
  int admitted = 0;
  for (int i = 0; i < 1000; ++i) admitted += limit.admit(begin) ? 1 : 0;
  EXPECT_EQ(admitted, LineLimit::kBurst);
  EXPECT_FALSE(limit.admit(begin + LineLimit::kPause - Time(1)));
  EXPECT_TRUE(limit.admit(begin + 2 * LineLimit::kPause));
  EXPECT_EQ(limit.left_out_words(), " (981 more lines were left out)");
  EXPECT_EQ(limit.left_out_words(), "");
}

TEST(LineLimit, a_flood_of_a_day_is_less_than_four_megabytes) {
  LineLimit limit;
  std::size_t bytes = 0;
  for (Time now{0}; now < std::chrono::hours(24); now += milliseconds(10))
    if (limit.admit(now)) bytes += LineLimit::kLongest + 100;
  EXPECT_LT(bytes, 4'000'000u);
  EXPECT_GT(bytes, 1'000'000u);
}

TEST(LineLimit, quiet_times_earn_the_burst_again_and_no_more) {
  LineLimit limit;
  for (int i = 0; i < 100; ++i) limit.admit(Time{0});
  int admitted = 0;
  for (int i = 0; i < 100; ++i) admitted += limit.admit(std::chrono::hours(24)) ? 1 : 0;
  EXPECT_EQ(admitted, LineLimit::kBurst);
}

TEST(Printable, is_one_bounded_line_that_steers_no_terminal) {
  EXPECT_EQ(printable("a\n\n"), "a");
  EXPECT_EQ(printable("a\nb\x1b[2Jc\x7f"), "a b\uFFFD[2Jc\uFFFD");
  EXPECT_EQ(printable("a\u009b2Jb\u202ec\x9b"), "a\uFFFD2Jb\uFFFDc\uFFFD") << "C1, a turn of direction, no UTF-8";
  EXPECT_EQ(printable(std::string(5000, 'x')).size(), LineLimit::kLongest);
  const std::string wide = printable(std::string(5000, '\x1b'));
  EXPECT_LE(wide.size(), LineLimit::kLongest);
  EXPECT_EQ(wide.size() % 3, 0u) << "cut between characters";
}

}  // namespace
}  // namespace gantry::monitor
