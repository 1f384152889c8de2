// The parser of SII EEPROMs, against images written down by hand from ETG.2010 and against nonsense.
#include "devices/ethercat/sii.hpp"

#include <algorithm>
#include <gtest/gtest.h>
#include <random>

namespace gantry::devices {
namespace {

using namespace wire;

void append(Bytes& image, std::initializer_list<int> values) {
  for (int v : values) image.push_back(static_cast<std::byte>(v));
}

/// Words 0000h-003Fh: identity 1111h.., alias 5, mailbox 1000h/128 and 1080h/64, CoE and FoE, 2 KiByte.
Bytes fixed_words() {
  Bytes image(128);
  const auto put = [&](std::size_t word, std::initializer_list<int> low_high) {
    std::size_t at = 2 * word;
    for (int v : low_high) image[at++] = static_cast<std::byte>(v);
  };
  put(0x00, {0x05, 0x0C});
  put(0x04, {0x05, 0x00});
  put(0x08, {0x11, 0x11, 0x00, 0x00, 0x22, 0x22, 0x00, 0x00, 0x33, 0x00, 0x01, 0x00, 0x44, 0x00, 0x00, 0x00});
  put(0x14, {0x00, 0x11, 0x40, 0x00, 0x40, 0x11, 0x40, 0x00});
  put(0x18, {0x00, 0x10, 0x80, 0x00, 0x80, 0x10, 0x40, 0x00, 0x0C, 0x00});
  put(0x3E, {0x0F, 0x00, 0x01, 0x00});
  image[14] = static_cast<std::byte>(sii_checksum(std::span<const std::byte>(image).first(14)));
  return image;
}

/// The categories of a small drive: strings, general, FMMU, SM, RxPDO, TxPDO, DC, and one of the vendor's.
Bytes whole_image() {
  Bytes image = fixed_words();
  // Strings: 4: "Motors", "M-1", "Controlword", "DC"; 27 bytes and one of padding: 14 words
  append(image, {10, 0,   14,  0,   4,   6,   'M', 'o', 't', 'o', 'r', 's', 3, 'M', '-', '1',
                 11, 'C', 'o', 'n', 't', 'r', 'o', 'l', 'w', 'o', 'r', 'd', 2, 'D', 'C', 0});
  image.resize(128 + 4 + 28);
  // General: group 1, order 2, name 2, CoE details SDO | info | complete access, flags no LRW, 150 mA
  append(image, {30, 0, 16,   0,    1, 0, 2, 2, 0, 0x23, 0, 0, 0, 0, 0, 2, 0x96, 0,
                 0,  0, 0x11, 0x01, 0, 0, 0, 0, 0, 0,    0, 0, 0, 0, 0, 0, 0,    0});
  append(image, {0x34, 0x12, 1, 0, 0xAB, 0xCD});  // unknown
  append(image, {40, 0, 2, 0, 1, 2, 3, 0});       // FMMU
  append(image,
         {41,   0,    8,    0,    0x00, 0x11, 0x06, 0x00, 0x64, 0x00, 0x01, 0x03,  // SM: outputs at 1100h, 6 bytes
          0x00, 0x14, 0x08, 0x00, 0x20, 0x00, 0x01, 0x04});                        // inputs at 1400h
  append(image, {51, 0, 8, 0, 0x00, 0x16, 1, 2, 0, 3, 0, 0, 0x40, 0x60, 0, 3, 6, 16, 0, 0});  // 1600h: 6040h:00, 16
  append(image, {50, 0, 12, 0, 0x00, 0x1A, 2, 3, 0, 0, 0, 0, 0x41, 0x60, 0, 0, 6, 16, 0, 0, 0, 0, 0, 0, 0, 16, 0, 0});
  append(image, {60, 0, 12, 0, 0x40, 0x42, 0x0F, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0x00, 0x03, 0, 0, 4, 0, 0, 0, 0, 0});
  append(image, {0xFF, 0xFF, 0, 0});
  return image;
}

TEST(Sii, an_image_is_read_as_the_standard_lays_it_out) {
  const auto sii = parse_sii(whole_image());
  ASSERT_TRUE(sii) << to_text(sii.error());
  EXPECT_EQ(sii->damage, "");
  EXPECT_TRUE(sii->checksum_ok);
  EXPECT_EQ(sii->alias, 5);
  EXPECT_EQ(sii->vendor, 0x1111u);
  EXPECT_EQ(sii->product, 0x2222u);
  EXPECT_EQ(sii->revision, 0x00010033u);
  EXPECT_EQ(sii->serial, 0x44u);
  EXPECT_EQ(sii->mailbox.out_start, 0x1000);
  EXPECT_EQ(sii->mailbox.out_bytes, 128);
  EXPECT_EQ(sii->mailbox.in_start, 0x1080);
  EXPECT_EQ(sii->mailbox.in_bytes, 64);
  EXPECT_EQ(sii->bootstrap.out_start, 0x1100);
  EXPECT_TRUE(sii->has_coe());
  EXPECT_EQ(sii->group, "Motors");
  EXPECT_EQ(sii->name, "M-1");
  EXPECT_EQ(sii->coe_details, sii::kCoeSdo | sii::kCoeSdoInfo | sii::kCoeCompleteAccess);
  EXPECT_EQ(sii->flags, sii::kFlagNoLrw);
  EXPECT_EQ(sii->ebus_current_mA, 150);
  EXPECT_EQ(sii->fmmus, (std::vector<std::uint8_t>{1, 2, 3, 0}));
  ASSERT_EQ(sii->sync_managers.size(), 2u);
  EXPECT_EQ(sii->sync_managers[0].registers.start, 0x1100);
  EXPECT_EQ(sii->sync_managers[0].registers.length, 6);
  EXPECT_EQ(sii->sync_managers[0].registers.control, 0x64);
  EXPECT_EQ(sii->sync_managers[1].type, 4);
  ASSERT_EQ(sii->rx_pdos.size(), 1u);
  EXPECT_EQ(sii->rx_pdos[0].index, 0x1600);
  EXPECT_EQ(sii->rx_pdos[0].sync_manager, 2);
  EXPECT_EQ(sii->rx_pdos[0].name, "Controlword");
  EXPECT_EQ(sii->rx_pdos[0].entries[0].address.index, 0x6040);
  EXPECT_EQ(sii->rx_pdos[0].entries[0].bit_length, 16);
  ASSERT_EQ(sii->tx_pdos.size(), 1u);
  ASSERT_EQ(sii->tx_pdos[0].entries.size(), 2u);
  EXPECT_EQ(sii->tx_pdos[0].entries[1].address.index, 0);  // a gap
  ASSERT_EQ(sii->dc_modes.size(), 1u);
  EXPECT_EQ(sii->dc_modes[0].name, "DC");
  EXPECT_EQ(sii->dc_modes[0].cycle0_ns, 1'000'000u);
  EXPECT_EQ(sii->dc_modes[0].activate, 0x0300);
}

TEST(Sii, a_blank_eeprom_and_one_that_is_too_short_are_told) {
  EXPECT_FALSE(parse_sii(Bytes(57)));
  EXPECT_EQ(parse_sii(Bytes{}).error().fault, Fault::SiiInvalid);
  const auto blank = parse_sii(Bytes(2048, std::byte{0xFF}));
  ASSERT_TRUE(blank);  // FFFFh is the end category
  EXPECT_FALSE(blank->checksum_ok);
  EXPECT_TRUE(blank->sync_managers.empty());
}

TEST(Sii, a_category_over_the_end_and_a_pdo_over_its_category_keep_what_came_before) {
  Bytes image = fixed_words();
  append(image, {40, 0, 1, 0, 1, 2, 41, 0, 0xFF, 0x7F, 1, 2, 3, 4});
  const auto over = parse_sii(image);
  ASSERT_TRUE(over);
  EXPECT_NE(over->damage, "");
  EXPECT_EQ(over->fmmus.size(), 2u);
  image = fixed_words();
  append(image, {51, 0, 4, 0, 0x00, 0x16, 200, 2, 0, 0, 0, 0, 0xFF, 0xFF, 0, 0});
  const auto pdo = parse_sii(image);
  ASSERT_TRUE(pdo);
  EXPECT_NE(pdo->damage.find("1600h"), std::string::npos);
  EXPECT_TRUE(pdo->rx_pdos.empty());
}

TEST(Sii, cut_at_any_byte_or_with_any_byte_changed_it_ends_within_its_bounds) {
  const Bytes image = whole_image();
  for (std::size_t size = 0; size <= image.size(); ++size) {
    const Bytes cut(image.begin(), image.begin() + static_cast<std::ptrdiff_t>(size));
    (void)parse_sii(cut);
  }
  std::mt19937 random(20260719);
  for (int i = 0; i < 20'000; ++i) {
    Bytes changed = image;
    for (unsigned n = 1 + static_cast<unsigned>(random()) % 4; n > 0; --n)
      changed[random() % changed.size()] = static_cast<std::byte>(random() & 0xFF);
    const auto sii = parse_sii(changed);
    ASSERT_TRUE(sii);
    ASSERT_LE(sii->name.size(), 255u);
    for (const char c : sii->name) ASSERT_TRUE(c >= 0x20 && c < 0x7F);
    ASSERT_LE(sii->sync_managers.size(), 16u);
  }
}

}  // namespace
}  // namespace gantry::devices
