#include "sim/world/valve.hpp"

#include <gtest/gtest.h>
#include <random>

namespace gantry::sim {
namespace {

TEST(Valve, opens_and_closes_after_its_lags_between_cycles) {
  Valve v(microseconds(2300), microseconds(1700));
  v.command(true, milliseconds(10));
  EXPECT_FALSE(v.next_edge(microseconds(12299)));
  const auto open = v.next_edge(milliseconds(13));
  ASSERT_TRUE(open);
  EXPECT_TRUE(open->open);
  EXPECT_EQ(open->at, microseconds(12300));
  v.command(false, milliseconds(20));
  const auto close = v.next_edge(milliseconds(30));
  ASSERT_TRUE(close);
  EXPECT_FALSE(close->open);
  EXPECT_EQ(close->at, microseconds(21700));
}

TEST(Valve, a_command_shorter_than_the_lag_difference_never_opens) {
  Valve v(milliseconds(5), milliseconds(2));
  v.command(true, milliseconds(10));
  v.command(false, milliseconds(12));
  EXPECT_FALSE(v.next_edge(milliseconds(100)));
  EXPECT_FALSE(v.is_open());
}

TEST(Valve, edges_always_alternate_and_never_go_back_in_time) {
  std::mt19937_64 random(3);
  for (int n = 0; n < 300; ++n) {
    Valve v(microseconds(random() % 6000), microseconds(random() % 6000));
    bool open = false;
    Time last{};
    for (int k = 1; k < 200; ++k) {
      v.command(random() % 3 == 0, milliseconds(k));
      while (const auto e = v.next_edge(milliseconds(k + 1))) {
        EXPECT_NE(e->open, open);
        EXPECT_GE(e->at, last);
        open = e->open;
        last = e->at;
      }
      EXPECT_EQ(v.is_open(), open);
    }
    v.command(false, milliseconds(200));
    while (v.next_edge(milliseconds(300))) {
    }
    EXPECT_FALSE(v.is_open()) << "a closed command always ends with a closed valve";
  }
}

}  // namespace
}  // namespace gantry::sim
