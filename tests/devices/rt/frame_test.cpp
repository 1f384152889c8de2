#include "devices/rt/frame.hpp"

#include <algorithm>
#include <gtest/gtest.h>
#include <random>
#include <vector>

namespace gantry::devices {
namespace {

using namespace wire;

std::vector<std::byte> answer_of(const Frame& frame, std::uint16_t working_counter) {
  std::vector<std::byte> reply(frame.bytes().begin(), frame.bytes().end());
  reply[6] |= std::byte{kProcessedMacBit};
  for (const Slot& s : frame.slots()) put_le<std::uint16_t>(reply, s.end() - kWorkingCounter, working_counter);
  return reply;
}

Frame two_datagrams(std::uint32_t sequence) {
  Frame f;
  f.start(sequence);
  f.add(Command::Lrw, 0x10000, 6);
  f.add(Command::Brd, physical_address(0, reg::kAlStatus), 2);
  return f;
}

// The whole frame written down by hand after ETG.1000.4 (5.3, 5.4): BRD of one byte from 0000h, padded to 60 bytes.
TEST(Frame, has_the_bytes_of_the_standard) {
  Frame f;
  f.start(0x2A);
  ASSERT_EQ(f.add(Command::Brd, physical_address(0, reg::kType), 1), 0u);
  const std::array<int, 29> by_hand{0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0x10, 0x67, 0x61, 0x6E,
                                    0x74, 0x00, 0x88, 0xA4, 0x0D, 0x10, 0x07, 0x2A, 0x00, 0x00,
                                    0x00, 0x00, 0x01, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00};
  ASSERT_EQ(f.bytes().size(), kMinEthernetFrame);
  for (std::size_t i = 0; i < by_hand.size(); ++i)
    EXPECT_EQ(std::to_integer<int>(f.bytes()[i]), by_hand[i]) << "at " << i;
}

TEST(Frame, takes_its_own_reply_and_gives_its_data) {
  Frame f = two_datagrams(7);
  auto reply = answer_of(f, 3);
  reply[f.slots()[0].data() + 2] = std::byte{0x5A};
  Reply r;
  ASSERT_EQ(match(f, reply, r), Match::Ours);
  EXPECT_EQ(r.working_counter(0), 3);
  EXPECT_EQ(r.data(0)[2], std::byte{0x5A});
  EXPECT_EQ(r.data(1).size(), 2u);
}

TEST(Frame, drops_replies_of_earlier_frames_also_256_cycles_later) {
  const Frame now = two_datagrams(1000);
  Reply r;
  for (std::uint32_t before : {1u, 2u, 255u, 256u, 512u})
    EXPECT_EQ(match(now, answer_of(two_datagrams(1000 - before), 3), r), Match::Late) << before;
}

TEST(Frame, tells_unprocessed_foreign_and_malformed_apart) {
  const Frame f = two_datagrams(9);
  Reply r;
  EXPECT_EQ(match(f, f.bytes(), r), Match::Unprocessed);
  auto other_master = answer_of(two_datagrams(10), 3);
  other_master[8] = std::byte{0x99};
  EXPECT_EQ(match(f, other_master, r), Match::Foreign);
  for (std::size_t at = 6; at < 14; ++at)  // our own, changed on the way: source and EtherType
    for (int bit = 0; bit < 8; ++bit) {
      auto changed = answer_of(f, 3);
      changed[at] ^= static_cast<std::byte>(1 << bit);
      const bool by_stations = at == 6 && bit == 1;
      EXPECT_EQ(match(f, changed, r), by_stations ? Match::Ours : Match::Malformed) << at << ", bit " << bit;
    }
  Frame of_another = two_datagrams(9);  // the same program on another computer
  of_another.set_source({std::byte{0x10}, std::byte{0x67}, std::byte{1}, std::byte{2}, std::byte{3}});
  of_another.start(9);
  static_cast<void>(of_another.add(Command::Brd, 0, 2));
  EXPECT_EQ(match(f, of_another.bytes(), r), Match::Foreign);
  EXPECT_EQ(sender_of(of_another.bytes())->at(2), std::byte{1});
  auto ip = answer_of(two_datagrams(10), 3);
  ip[12] = std::byte{0x08};
  EXPECT_EQ(match(f, ip, r), Match::Foreign);
  EXPECT_FALSE(sender_of(ip));
  const auto whole = answer_of(f, 3);
  for (std::size_t cut = 0; cut < f.slots().back().end(); ++cut)
    EXPECT_EQ(match(f, std::span<const std::byte>(whole).first(cut), r), Match::Malformed) << cut;
}

TEST(Frame, every_changed_header_byte_is_noticed) {
  const Frame f = two_datagrams(9);
  const auto good = answer_of(f, 3);
  Reply r;
  std::vector<std::size_t> header{12, 13, 14, 15};
  for (const Slot& s : f.slots())
    for (std::size_t i = s.header; i < s.data() - 2u; ++i) header.push_back(i);  // not the IRQ field
  for (const std::size_t at : header)
    for (int bit = 0; bit < 8; ++bit) {
      auto bad = good;
      bad[at] ^= static_cast<std::byte>(1 << bit);
      const bool free_field = at == f.slots()[1].header + 2u ||
                              at == f.slots()[1].header + 3u  // ADP of a BRD counts up
                              || ((at == f.slots()[0].header + 7u || at == f.slots()[1].header + 7u) &&
                                  (bit >= 3 && bit <= 6));  // reserved and "circulating"
      EXPECT_EQ(match(f, bad, r) == Match::Ours, free_field) << "byte " << at << " bit " << bit;
    }
}

TEST(Frame, is_full_in_time) {
  Frame f;
  f.start(1);
  EXPECT_EQ(f.room(), kMaxDatagramData);
  EXPECT_EQ(f.add(Command::Lrw, 0, kMaxDatagramData + 1), kNoSlot);
  EXPECT_EQ(f.add(Command::Lrw, 0, kMaxDatagramData), 0u);
  EXPECT_EQ(f.bytes().size(), kMaxFrameBytes);
  EXPECT_EQ(f.add(Command::Brd, 0, 0), kNoSlot);
  f.start(2);
  for (std::size_t i = 0; i < kMaxDatagrams; ++i) EXPECT_NE(f.add(Command::Brd, 0, 2), kNoSlot);
  EXPECT_EQ(f.add(Command::Brd, 0, 2), kNoSlot);
}

TEST(Frame, any_bytes_give_an_answer) {
  const unsigned seed = 20241121;
  SCOPED_TRACE(seed);
  std::mt19937 random(seed);
  const Frame f = two_datagrams(77);
  const auto good = answer_of(f, 3);
  int taken = 0;
  for (int i = 0; i < 200'000; ++i) {
    std::vector<std::byte> bytes(random() % 80);
    const bool from_good = random() % 2 == 0;
    for (std::size_t k = 0; k < bytes.size(); ++k)
      bytes[k] = from_good && random() % 16 != 0 && k < good.size() ? good[k] : static_cast<std::byte>(random());
    Reply r;
    if (match(f, bytes, r) != Match::Ours) continue;
    ++taken;
    EXPECT_EQ(r.data(1).size(), 2u);
  }
  RecordProperty("taken", taken);
}

}  // namespace
}  // namespace gantry::devices
