#include "devices/rt/sender_watch.hpp"

#include <gtest/gtest.h>

namespace gantry::devices {
namespace {

MacAddress address(int last) { return {std::byte{2}, {}, {}, {}, {}, static_cast<std::byte>(last)}; }

TEST(SenderWatch, a_master_is_known_by_its_third_frame) {
  SenderWatch w;
  for (std::uint32_t i = 0; i < 2; ++i) {
    w.heard(address(1), i);
    EXPECT_FALSE(w.other());
  }
  w.heard(address(1), 2);
  EXPECT_EQ(w.other(), (OtherMaster{address(1), 3}));
  w.heard(address(1), 900'000);  // and later each of its frames counts
  EXPECT_EQ(w.other(), (OtherMaster{address(1), 4}));
}

TEST(SenderWatch, two_masters_that_take_turns_are_both_known) {
  SenderWatch w;
  for (std::uint32_t i = 0; i < 10; ++i) w.heard(address(static_cast<int>(i % 2)), i);
  EXPECT_EQ(w.other(), (OtherMaster{address(1), 10}));
}

/// A bit that flips every now and then: 48 addresses, thousands of frames apart.
TEST(SenderWatch, a_bad_cable_is_nobody_however_long_it_lasts) {
  SenderWatch w;
  for (std::uint32_t i = 0; i < 100'000; ++i) w.heard(address(static_cast<int>(i * 7 % 48)), 600 * i);
  EXPECT_FALSE(w.other());
  for (std::uint32_t i = 0; i < 100; ++i) w.heard(address(9), 60'000'000 + 600 * i);
  EXPECT_FALSE(w.other());
}

TEST(SenderWatch, a_master_is_known_among_frames_that_were_changed) {
  SenderWatch w;
  for (std::uint32_t i = 0; i < 12; ++i) w.heard(i % 4 == 3 ? address(200) : address(static_cast<int>(i)), 10 * i);
  EXPECT_EQ(w.other(), (OtherMaster{address(200), 3}));
}

/// Our own count runs over after 2^32 frames.
TEST(SenderWatch, counts_on_where_the_sequence_begins_anew) {
  SenderWatch w;
  for (const std::uint32_t sequence : {0xFFFFFFF0u, 0xFFFFFFFFu, 5u}) w.heard(address(1), sequence);
  EXPECT_EQ(w.other(), (OtherMaster{address(1), 3}));
}

}  // namespace
}  // namespace gantry::devices
