#include <algorithm>
#include <array>
#include <gtest/gtest.h>
#include <vector>

#include "devices/wire/cia301.hpp"
#include "devices/wire/coe.hpp"
#include "devices/wire/ethercat.hpp"
#include "devices/wire/sii.hpp"

namespace gantry::devices::wire {
namespace {

std::vector<std::byte> bytes(std::initializer_list<int> values) {
  std::vector<std::byte> b;
  for (int v : values) b.push_back(static_cast<std::byte>(v));
  return b;
}

TEST(Wire, little_endian_values_go_in_and_out_also_at_compile_time) {
  constexpr auto at_compile_time = [] {
    std::array<std::byte, 8> b{};
    put_le<std::int32_t>(b, 1, -2);
    return std::pair{b, get_le<std::int32_t>(b, 1)};
  }();
  static_assert(at_compile_time.second == -2);
  std::array<std::byte, 8> b{};
  put_le<std::int32_t>(b, 1, -2);
  EXPECT_EQ(b, at_compile_time.first);
  EXPECT_EQ(b[1], std::byte{0xFE});
  EXPECT_EQ(b[4], std::byte{0xFF});
  EXPECT_EQ(get_le<std::uint16_t>(bytes({0x34, 0x12}), 0), 0x1234);
}

// Header of an FPRD of 6 bytes from 0130h of station 1001h, written down from ETG.1000.4 table 19 by hand.
TEST(Wire, datagram_header_has_the_layout_of_the_standard) {
  const auto by_hand = bytes({0x04, 0x7F, 0x01, 0x10, 0x30, 0x01, 0x06, 0x80, 0x00, 0x00});
  std::vector<std::byte> ours(kDatagramHeader);
  put_datagram_header(ours, {.command = Command::Fprd,
                             .index = 0x7F,
                             .address = physical_address(0x1001, reg::kAlStatus),
                             .length = 6,
                             .more = true});
  EXPECT_EQ(ours, by_hand);
  const auto h = get_datagram_header(by_hand);
  EXPECT_EQ(h.adp(), 0x1001);
  EXPECT_EQ(h.ado(), 0x0130);
  EXPECT_TRUE(h.more);
  EXPECT_FALSE(h.circulating);
}

TEST(Wire, auto_increment_addresses_count_down_from_zero) {
  EXPECT_EQ(auto_increment(0), 0x0000);
  EXPECT_EQ(auto_increment(1), 0xFFFF);
  EXPECT_EQ(auto_increment(7), 0xFFF9);
}

// ETG.1000.4 tables 56 and 59 by hand.
TEST(Wire, fmmu_and_sync_manager_have_the_layout_of_the_standard) {
  const auto fmmu = to_bytes(Fmmu{.logical_start = 0x00010009,
                                  .length = 9,
                                  .physical_start = 0x1100,
                                  .type = static_cast<std::uint8_t>(FmmuType::Write),
                                  .active = true});
  EXPECT_TRUE(std::ranges::equal(fmmu, bytes({0x09, 0, 0x01, 0, 0x09, 0, 0, 7, 0x00, 0x11, 0, 2, 1, 0, 0, 0})));
  EXPECT_EQ(get_fmmu(fmmu).physical_start, 0x1100);
  const auto sm = to_bytes(SyncManager{.start = 0x1080, .length = 128, .control = kSmControlMailboxIn, .activate = 1});
  EXPECT_TRUE(std::ranges::equal(sm, bytes({0x80, 0x10, 0x80, 0, 0x22, 0, 1, 0})));
  EXPECT_EQ(get_sync_manager(sm).length, 128);
}

// CRC-8 with polynomial 07h has the catalogued check value F4h over "123456789" from 0; from FFh, the same comes out
// when the first byte is inverted.
TEST(Wire, sii_checksum_is_crc8_from_ff) {
  EXPECT_EQ(sii_checksum(bytes({0xCE, '2', '3', '4', '5', '6', '7', '8', '9'})), 0xF4);
}

// SDO upload of 6041h:0 and its expedited answer 0250h, after ETG.1000.6 tables 33 and 34, by hand.
TEST(Wire, mailbox_and_sdo_have_the_layout_of_the_standard) {
  std::vector<std::byte> request(kMailboxHeader + kCoeHeader + kSdoBytes);
  put_mailbox_header(request, {.length = 10, .type = MailboxType::Coe, .counter = 5});
  put_le<std::uint16_t>(request, 6, coe_header(CoeService::SdoRequest));
  put_sdo_header(std::span(request).subspan(8), {.command = sdo::kUploadRequest, .index = 0x6041});
  EXPECT_EQ(request, bytes({0x0A, 0, 0, 0, 0, 0x53, 0x00, 0x20, 0x40, 0x41, 0x60, 0, 0, 0, 0, 0}));

  const auto reply = bytes({0x4B, 0x41, 0x60, 0x00, 0x50, 0x02, 0, 0});
  const auto h = get_sdo_header(reply);
  EXPECT_EQ(h.command & sdo::kCommandMask, sdo::kUploadResponse);
  EXPECT_EQ(sdo::expedited_size(h.command), 2u);
  EXPECT_EQ(h.data, 0x0250u);
  EXPECT_EQ(sdo::expedited_size_bits(2), 0x08);
}

TEST(Wire, mailbox_counter_runs_from_1_to_7) {
  EXPECT_EQ(next_counter(0), 1);
  EXPECT_EQ(next_counter(6), 7);
  EXPECT_EQ(next_counter(7), 1);
}

TEST(Wire, codes_have_texts_and_unknown_ones_say_so) {
  EXPECT_EQ(abort_text(0x06090030), "value out of range");
  EXPECT_EQ(abort_text(0x12345678), "unknown abort code");
  EXPECT_EQ(al_status_text(0x001B), "SyncManager watchdog: outputs came too late or not at all");
  EXPECT_EQ(al_status_text(0x8001), "vendor-specific AL status code");
  EXPECT_TRUE(std::ranges::is_sorted(kAlStatusCodes, {}, &AlStatusText::code));
  EXPECT_TRUE(std::ranges::is_sorted(kAbortCodes, {}, &AbortText::code));
}

TEST(Wire, dc_difference_is_sign_and_magnitude) {
  EXPECT_EQ(dc_difference_ns(0x00000010), 16);
  EXPECT_EQ(dc_difference_ns(0x80000010), -16);
}

}  // namespace
}  // namespace gantry::devices::wire
