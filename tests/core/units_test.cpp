#include "core/units.hpp"

#include <cstdio>
#include <gtest/gtest.h>
#include <numbers>
#include <random>

namespace gantry::units {
namespace {

constexpr double kPi = std::numbers::pi;

struct Good {
  const char* text;
  Dimension dimension;
  double value;
};

// Values worked out by hand: 1 rpm = 2 pi / 60 rad/s, 60 mm/min = 1 mm/s.
const Good kGood[] = {
    {"20 mm/s", Dimension::Speed, 20},
    {"20mm/s", Dimension::Speed, 20},
    {"  20\t mm/s ", Dimension::Speed, 20},
    {"60 mm/min", Dimension::Speed, 1},
    {"0.3 m/s", Dimension::Speed, 300},
    {"0.2 mm", Dimension::Length, 0.2},
    {".2 mm", Dimension::Length, 0.2},
    {"2. mm", Dimension::Length, 2},
    {"-7 um", Dimension::Length, -0.007},
    {"+7 µm", Dimension::Length, 0.007},
    {"1.5 m", Dimension::Length, 1500},
    {"1e3 mm", Dimension::Length, 1000},
    {"1e3mm", Dimension::Length, 1000},
    {"1E-3 mm", Dimension::Length, 0.001},
    {"1e+2 mm", Dimension::Length, 100},
    {"0 mm", Dimension::Length, 0},
    {"-0.5 mm", Dimension::Length, -0.5},
    {"15 ms", Dimension::Time, 0.015},
    {"250 us", Dimension::Time, 0.00025},
    {"1 s", Dimension::Time, 1},
    {"90 deg", Dimension::Angle, kPi / 2},
    {"-1.5 rad", Dimension::Angle, -1.5},
    {"3000 mm/s^2", Dimension::Acceleration, 3000},
    {"3 m/s²", Dimension::Acceleration, 3000},
    {"50 m/s^3", Dimension::Jerk, 50000},
    {"60 rpm", Dimension::AngularSpeed, 2 * kPi},
    {"180 deg/s", Dimension::AngularSpeed, kPi},
    {"360 deg/s²", Dimension::AngularAcceleration, 2 * kPi},
    {"1 rad/s^3", Dimension::AngularJerk, 1},
    {"5 %", Dimension::Ratio, 0.05},
    {"12.5%", Dimension::Ratio, 0.125},
    {"3", Dimension::None, 3},
    {"-0.25", Dimension::None, -0.25},
};

TEST(Units, parses_each_unit_to_that_of_the_house) {
  for (const Good& row : kGood) {
    const auto value = parse(row.text, row.dimension);
    ASSERT_TRUE(value) << row.text << ": " << value.error().message;
    EXPECT_NEAR(*value, row.value, 1e-12 * (1 + std::abs(row.value))) << row.text;
  }
}

struct Bad {
  const char* text;
  Dimension dimension;
  Fault fault;
};

const Bad kBad[] = {
    // no unit, or one of another dimension
    {"20", Dimension::Speed, Fault::BadUnit},
    {"0.05", Dimension::Ratio, Fault::BadUnit},
    {"20 mm", Dimension::Speed, Fault::BadUnit},
    {"20 mm/s", Dimension::Length, Fault::BadUnit},
    {"20 inch", Dimension::Length, Fault::BadUnit},
    {"20 MM", Dimension::Length, Fault::BadUnit},
    {"20 mm mm", Dimension::Length, Fault::BadUnit},
    {"20 mm/s 3", Dimension::Speed, Fault::BadUnit},
    {"90 deg", Dimension::Length, Fault::BadUnit},
    {"1 deg", Dimension::None, Fault::BadUnit},
    {"5 %", Dimension::None, Fault::BadUnit},
    // no number
    {"", Dimension::Length, Fault::BadValue},
    {" ", Dimension::None, Fault::BadValue},
    {"mm", Dimension::Length, Fault::BadValue},
    {"- mm", Dimension::Length, Fault::BadValue},
    {". mm", Dimension::Length, Fault::BadValue},
    {"e3 mm", Dimension::Length, Fault::BadValue},
    {"--3 mm", Dimension::Length, Fault::BadValue},
    {"+-3 mm", Dimension::Length, Fault::BadValue},
    {"1.2.3 mm", Dimension::Length, Fault::BadValue},
    {"1,5 mm", Dimension::Length, Fault::BadValue},
    {"one mm", Dimension::Length, Fault::BadValue},
    // numbers that YAML readers disagree about, or that are none
    {"010 mm", Dimension::Length, Fault::BadValue},
    {"-010", Dimension::None, Fault::BadValue},
    {"0x10 mm", Dimension::Length, Fault::BadUnit},
    {"nan mm", Dimension::Length, Fault::BadValue},
    {".nan", Dimension::None, Fault::BadValue},
    {"inf mm", Dimension::Length, Fault::BadValue},
    {"-.inf", Dimension::None, Fault::BadValue},
    {"1e999 mm", Dimension::Length, Fault::BadValue},
    {"1e mm", Dimension::Length, Fault::BadUnit},
    {"1e-", Dimension::None, Fault::BadValue},
};

TEST(Units, refuses_what_is_no_plain_number_with_its_unit) {
  for (const Bad& row : kBad) {
    const auto value = parse(row.text, row.dimension);
    ASSERT_FALSE(value) << "'" << row.text << "' was read as " << *value;
    EXPECT_EQ(value.error().fault, row.fault) << row.text << ": " << value.error().message;
  }
}

TEST(Units, message_shows_what_was_written_and_an_example_to_follow) {
  const auto value = parse("20", Dimension::Speed);
  ASSERT_FALSE(value);
  EXPECT_NE(value.error().message.find("'20'"), std::string::npos) << value.error().message;
  EXPECT_NE(value.error().message.find("20 mm/s"), std::string::npos) << value.error().message;
  EXPECT_NE(value.error().message.find("mm/min"), std::string::npos) << value.error().message;
}

TEST(Units, examples_parse_in_their_own_dimension_only) {
  for (int d = 0; d <= static_cast<int>(Dimension::AngularJerk); ++d)
    for (int e = 0; e <= static_cast<int>(Dimension::AngularJerk); ++e)
      EXPECT_EQ(parse(example(static_cast<Dimension>(d)), static_cast<Dimension>(e)).has_value(), d == e)
          << example(static_cast<Dimension>(d)) << " as dimension " << e;
}

TEST(Units, printed_value_reads_back_to_the_bit) {
  constexpr unsigned kSeed = 20;
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  std::mt19937_64 random(kSeed);
  std::uniform_real_distribution<double> mantissa(-10, 10), exponent(-9, 9);
  for (int i = 0; i < 10000; ++i) {
    const double value = mantissa(random) * std::pow(10, exponent(random));
    char text[64];
    std::snprintf(text, sizeof text, "%.17g mm", value);
    const auto read = parse(text, Dimension::Length);
    ASSERT_TRUE(read) << text;
    ASSERT_EQ(*read, value) << text;
  }
}

TEST(Units, signs_that_look_like_blanks_and_minuses_are_named) {
  const std::pair<const char*, const char*> tricks[] = {
      {"12\xC2\xA0mm", "a no-break space (U+00A0) in it; write a plain blank"},
      {"12\xE2\x80\xAFmm", "a narrow no-break space (U+202F)"},
      {"12 mm\xE2\x80\x8B", "a zero-width space (U+200B) in it; take it away"},
      {"\xE2\x88\x92"
       "12 mm",
       "a minus sign (U+2212) in it; write '-', for example '12.5 mm'"},
      {"\xE2\x80\x93"
       "12 mm",
       "an en dash (U+2013)"}};
  for (const auto& [text, says] : tricks) {
    const auto read = parse(text, Dimension::Length);
    ASSERT_FALSE(read) << text;
    EXPECT_EQ(read.error().fault, Fault::BadValue);
    EXPECT_NE(read.error().message.find(says), std::string::npos) << read.error().message;
  }
}

TEST(Units, random_text_is_refused_or_finite) {
  constexpr unsigned kSeed = 21;
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  std::mt19937 random(kSeed);
  const std::string letters = "0123456789+-.eE mdsµ/^²nanif x\t";
  for (int i = 0; i < 200000; ++i) {
    std::string text;
    for (auto n = random() % 12; n > 0; --n) text += letters[random() % letters.size()];
    const auto read = parse(text, static_cast<Dimension>(random() % 10));
    if (read) {
      ASSERT_TRUE(std::isfinite(*read)) << text;
    }
  }
}

}  // namespace
}  // namespace gantry::units
