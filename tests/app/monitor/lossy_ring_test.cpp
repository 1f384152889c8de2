#include "app/monitor/lossy_ring.hpp"

#include <gtest/gtest.h>
#include <memory>
#include <random>
#include <thread>
#include <vector>

namespace gantry::monitor {
namespace {

TEST(LossyRing, agrees_with_a_list_that_forgets_the_oldest) {
  const auto seed = std::random_device{}();
  SCOPED_TRACE(::testing::Message() << "seed " << seed);
  std::mt19937 random(seed);
  auto ring = std::make_unique<LossyRing<std::uint64_t, 16>>();
  std::vector<std::uint64_t> all;
  RingCursor cursor = ring->oldest();
  std::uint64_t read = 0, lost = 0, position = 0;
  for (int round = 0; round < 20'000; ++round) {
    for (auto n = random() % 40; n > 0; --n) {
      all.push_back(random());
      ring->push(all.back());
    }
    for (auto n = random() % 30; n > 0; --n) {
      if (all.size() - position > 16) {
        lost += all.size() - 16 - position;
        position = all.size() - 16;
      }
      std::uint64_t value = 0;
      const bool expected = position < all.size();
      ASSERT_EQ(ring->next(cursor, value), expected);
      if (!expected) break;
      ASSERT_EQ(value, all[position++]);
      ++read;
    }
    ASSERT_EQ(cursor.lost, lost);
  }
  EXPECT_GT(read, 1000u);
  EXPECT_GT(lost, 1000u);
}

TEST(LossyRing, a_reader_beside_a_busy_writer_never_sees_a_torn_value_and_counts_what_it_misses) {
  struct Wide {
    std::uint64_t n;
    std::array<std::uint64_t, 40> copies;
  };
  constexpr std::uint64_t kValues = 300'000;
  auto ring = std::make_unique<LossyRing<Wide, 32>>();
  std::thread writer([&] {
    for (std::uint64_t n = 0; n < kValues; ++n) {
      Wide w{n, {}};
      w.copies.fill(n);
      ring->push(w);
    }
  });
  RingCursor cursor;
  std::uint64_t read = 0;
  bool torn = false, ordered = true;
  for (std::uint64_t last = 0; cursor.position < kValues;) {
    Wide w;
    if (!ring->next(cursor, w)) continue;
    ++read;
    for (const auto c : w.copies) torn = torn || c != w.n;
    ordered = ordered && w.n + 1 == cursor.position && w.n >= last;
    last = w.n;
  }
  writer.join();
  EXPECT_FALSE(torn);
  EXPECT_TRUE(ordered);
  EXPECT_EQ(read + cursor.lost, kValues);
  Wide newest;
  EXPECT_TRUE(ring->newest(newest));
  EXPECT_EQ(newest.n, kValues - 1);
}

}  // namespace
}  // namespace gantry::monitor
