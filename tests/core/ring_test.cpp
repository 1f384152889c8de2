#include "core/rt/ring.hpp"

#include <array>
#include <cstdint>
#include <gtest/gtest.h>
#include <thread>

namespace gantry::rt {
namespace {

TEST(Ring, holds_exactly_its_capacity_in_order) {
  Ring<int, 4> ring;
  for (int round = 0; round < 3; ++round) {  // across the wrap
    for (int i = 0; i < 4; ++i) ASSERT_TRUE(ring.push(10 * round + i));
    EXPECT_FALSE(ring.push(99));
    EXPECT_EQ(ring.size(), 4u);
    int value = 0;
    for (int i = 0; i < 4; ++i) {
      ASSERT_TRUE(ring.pop(value));
      EXPECT_EQ(value, 10 * round + i);
    }
    EXPECT_FALSE(ring.pop(value));
    EXPECT_EQ(ring.size(), 0u);
  }
}

TEST(Ring, peek_looks_ahead_without_taking) {
  Ring<int, 4> ring;
  EXPECT_EQ(ring.peek(0), nullptr);
  int value = 0;
  ring.push(1), ring.push(2), ring.pop(value), ring.push(3);
  ASSERT_NE(ring.peek(0), nullptr);
  EXPECT_EQ(*ring.peek(0), 2);
  ASSERT_NE(ring.peek(1), nullptr);
  EXPECT_EQ(*ring.peek(1), 3);
  EXPECT_EQ(ring.peek(2), nullptr);
  EXPECT_EQ(ring.size(), 2u);
}

/// Fills a cache line and more, so that a torn value shows.
struct Wide {
  std::array<std::uint64_t, 9> copies;
};

TEST(Ring, two_threads_lose_nothing_tear_nothing_and_keep_the_order) {
  constexpr std::uint64_t kValues = 200000;
  Ring<Wide, 16> ring;
  std::thread producer([&] {
    for (std::uint64_t n = 0; n < kValues;) {
      Wide wide;
      wide.copies.fill(n);
      if (ring.push(wide))
        ++n;
      else
        std::this_thread::yield();
    }
  });
  std::uint64_t expected = 0;
  bool intact = true;
  while (expected < kValues) {
    Wide wide;
    const Wide* ahead = ring.peek(3);
    if (ahead != nullptr) intact = intact && ahead->copies[0] == expected + 3 && ahead->copies[8] == expected + 3;
    if (!ring.pop(wide)) {
      std::this_thread::yield();
      continue;
    }
    for (const std::uint64_t copy : wide.copies) intact = intact && copy == expected;
    ++expected;
  }
  producer.join();
  EXPECT_TRUE(intact);
  EXPECT_EQ(ring.size(), 0u);
}

}  // namespace
}  // namespace gantry::rt
