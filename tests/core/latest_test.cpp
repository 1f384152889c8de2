#include "core/rt/latest.hpp"

#include <array>
#include <atomic>
#include <cstdint>
#include <gtest/gtest.h>
#include <thread>
#include <vector>

namespace gantry::rt {
namespace {

TEST(Latest, is_empty_until_the_first_store) {
  Latest<int> latest;
  int value = 7;
  EXPECT_FALSE(latest.load(value));
  EXPECT_EQ(value, 7);
  latest.store(3);
  EXPECT_TRUE(latest.load(value));
  EXPECT_EQ(value, 3);
}

TEST(Latest, carries_values_whose_size_is_no_multiple_of_a_word) {
  struct Odd {
    char bytes[11];
  };
  Latest<Odd> latest;
  latest.store({"0123456789"});
  Odd read{};
  ASSERT_TRUE(latest.load(read));
  EXPECT_STREQ(read.bytes, "0123456789");
}

TEST(Latest, readers_never_see_half_a_value_nor_an_older_one_than_before) {
  struct Wide {
    std::array<std::uint64_t, 20> copies{};
  };
  constexpr std::uint64_t kValues = 200000;
  Latest<Wide> latest;
  std::atomic<bool> done = false;
  std::atomic<int> wrong = 0;
  std::vector<std::thread> readers;
  for (int r = 0; r < 2; ++r)
    readers.emplace_back([&] {
      std::uint64_t last = 0;
      bool finished = false;
      while (!finished) {
        finished = done.load();
        Wide wide;
        if (!latest.load(wide)) continue;
        for (const std::uint64_t copy : wide.copies)
          if (copy != wide.copies[0]) ++wrong;
        if (wide.copies[0] < last) ++wrong;
        last = wide.copies[0];
      }
      if (last != kValues) ++wrong;  // nobody stores any more: the last value is there to be read
    });
  for (std::uint64_t n = 1; n <= kValues; ++n) {
    Wide wide;
    wide.copies.fill(n);
    latest.store(wide);
    if (n % 64 == 0) std::this_thread::yield();
  }
  done = true;
  for (std::thread& reader : readers) reader.join();
  EXPECT_EQ(wrong, 0);
}

}  // namespace
}  // namespace gantry::rt
