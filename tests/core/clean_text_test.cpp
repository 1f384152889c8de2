// What a terminal may show; the judge of what is UTF-8 is nlohmann::json, which refuses to write anything else.
#include "core/clean_text.hpp"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <random>

#include "core/log.hpp"
#include "core/status_line.hpp"

namespace gantry {
namespace {

constexpr const char* kReplaced = "\xEF\xBF\xBD";

TEST(CleanText, leaves_what_people_write) {
  for (const char* text : {"", "board.yaml:4:9: 12.5 mm", "Kl\u00e4rung \u00b5m \u4e2d \U0001F600", "~ !"})
    EXPECT_EQ(clean_text(text), text);
}

TEST(CleanText, nothing_steers_a_terminal) {
  EXPECT_EQ(clean_text("a\x1b[2Jb"), std::string("a") + kReplaced + "[2Jb");
  EXPECT_EQ(clean_text(std::string_view("1\0x", 3)), std::string("1") + kReplaced + "x");
  EXPECT_EQ(clean_text("a\nb\tc\r"), "a b c ");
  for (const char* each : {"\x7f", "\u0085", "\u009b", "\u202e", "\u2066", "\u200f", "\u2028"})
    EXPECT_EQ(clean_text(each), kReplaced);
}

TEST(CleanText, broken_utf8_is_replaced_byte_by_byte) {
  EXPECT_EQ(clean_text("\xff\xfex"), std::string(kReplaced) + kReplaced + "x");
  EXPECT_EQ(clean_text("\xe4\xb8"), std::string(kReplaced) + kReplaced);
  EXPECT_EQ(clean_text("\xc0\xaf"), std::string(kReplaced) + kReplaced) << "not the shortest form";
  EXPECT_EQ(clean_text("\xed\xa0\x80"), std::string(kReplaced) + kReplaced + kReplaced) << "a surrogate";
}

TEST(CleanText, whatever_comes_in_is_utf8_without_control_characters) {
  constexpr unsigned kSeed = 5;
  std::mt19937 random(kSeed);
  std::uniform_int_distribution<int> byte(0, 255), length(0, 12);
  for (int round = 0; round < 20000; ++round) {
    std::string raw(static_cast<std::size_t>(length(random)), ' ');
    for (char& c : raw) c = static_cast<char>(byte(random));
    const std::string clean = clean_text(raw);
    EXPECT_NO_THROW((void)nlohmann::json(clean).dump()) << "seed " << kSeed << " round " << round;
    for (const char c : clean) EXPECT_GE(static_cast<unsigned char>(c), 0x20) << "seed " << kSeed << " round " << round;
    EXPECT_EQ(clean_text(clean), clean);
  }
}

TEST(CleanText, an_error_is_shown_clean) {
  EXPECT_EQ(to_text({Fault::BadValue, "'\xff\x1b' is no number", "a\nb.csv:3:1"}),
            std::string("a b.csv:3:1: '") + kReplaced + kReplaced + "' is no number [G405]");
}

TEST(CleanText, what_steers_is_escaped_in_json_and_the_document_is_the_same) {
  const nlohmann::json document{{"name", "a\u202eb\u009bc\x7f \u00b5 \u4e2d"}, {"list", {1, "\n"}}};
  const std::string text = escape_steering(document.dump(1));
  EXPECT_EQ(clean_lines(text), text);
  EXPECT_NE(text.find("a\\u202eb\\u009bc\\u007f \u00b5 \u4e2d"), std::string::npos) << text;
  EXPECT_EQ(nlohmann::json::parse(text), document);
}

TEST(StatusLine, is_cut_by_columns) {
  EXPECT_EQ(cut_to("abcdef", 4), "abcd");
  EXPECT_EQ(cut_to("abc", 4), "abc");
  EXPECT_EQ(cut_to("\u00b5\u4e2dx", 2), "\u00b5\u4e2d");
  EXPECT_EQ(cut_to("\x1b[1;31mfault\x1b[0m and more", 3), "\x1b[1;31mfau\x1b[0m");
  EXPECT_EQ(cut_to("\x1b[1", 3), "\x1b[1\x1b[0m");
  EXPECT_EQ(cut_to("", 3), "");
}

TEST(CleanText, of_lines_keeps_their_ends) {
  EXPECT_EQ(clean_lines("a\x1b\nb\tc\n"), "a\xEF\xBF\xBD\nb c\n");
  EXPECT_EQ(clean_lines(""), "");
  EXPECT_EQ(clean_lines("one"), "one");
}

}  // namespace
}  // namespace gantry
