#include "vision/annotate.hpp"

#include <gtest/gtest.h>
#include <png.h>

namespace gantry::vision {
namespace {

std::uint32_t big_endian(const std::vector<std::byte>& bytes, std::size_t at) {
  std::uint32_t v = 0;
  for (std::size_t i = 0; i < 4; ++i) v = v << 8 | std::to_integer<std::uint32_t>(bytes[at + i]);
  return v;
}

// PNG (ISO/IEC 15948) 5.2, 11.2.2: signature, then IHDR with width, height, depth and colour type.
TEST(Annotate, writes_png_of_the_right_size_and_kind) {
  const Image image{120, 80, std::vector<std::uint8_t>(9600, 90)};
  const FoundMark found{.at_px = {60.2, 39.7}, .sigma_px = {}};
  const auto colour = annotated_png(image, {Disc{40}, true}, {55, 44}, &found, 2);
  ASSERT_TRUE(colour);
  EXPECT_EQ(big_endian(*colour, 0), 0x89504E47U);
  EXPECT_EQ(big_endian(*colour, 16), 60U);
  EXPECT_EQ(big_endian(*colour, 20), 40U);
  EXPECT_EQ(std::to_integer<int>((*colour)[25]), 2);
}

// Read by the decoder that everybody uses.
TEST(Annotate, found_outline_is_green_and_the_expected_cross_is_not) {
  const Image image{120, 80, std::vector<std::uint8_t>(9600, 90)};
  const FoundMark found{.at_px = {60, 40}, .sigma_px = {}};
  const auto bytes = annotated_png(image, {Disc{40}, true}, {20, 20}, &found, 1);
  ASSERT_TRUE(bytes);
  png_image png{};
  png.version = PNG_IMAGE_VERSION;
  ASSERT_NE(png_image_begin_read_from_memory(&png, bytes->data(), bytes->size()), 0);
  png.format = PNG_FORMAT_RGB;
  std::vector<std::uint8_t> rgb(PNG_IMAGE_SIZE(png));
  ASSERT_NE(png_image_finish_read(&png, nullptr, rgb.data(), 0, nullptr), 0);
  const auto at = [&](std::size_t x, std::size_t y) { return &rgb[3 * (120 * y + x)]; };
  EXPECT_EQ(std::to_integer<int>(std::byte{at(100, 70)[0]}), 90) << "elsewhere the image as it was";
  EXPECT_GT(at(60, 40)[1], at(60, 40)[0] + 50) << "green at the found centre";
  EXPECT_GT(at(20, 20)[0], at(20, 20)[2] + 50) << "red over blue at the expected place";
}

TEST(Annotate, refuses_an_image_that_is_none) {
  EXPECT_FALSE(annotated_png(Image{}, {Disc{4}, true}, {5, 5}, nullptr));
  EXPECT_FALSE(annotated_png(Image{10, 10, std::vector<std::uint8_t>(99)}, {Disc{4}, true}, {5, 5}, nullptr));
}

}  // namespace
}  // namespace gantry::vision
