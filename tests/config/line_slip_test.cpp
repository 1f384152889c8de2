// One line that is wrong: told where it is, and never so that what is done as told leaves something of the file unread.
#include "config/line_slip.hpp"

#include <gtest/gtest.h>

#include "config/fields.hpp"

namespace gantry::config {
namespace {

struct SlipPart {
  std::string name;
  double size = 0;
  std::string note;
};
struct SlipFile {
  std::string manual, title;
  double watchdog = 0;
  std::vector<SlipPart> parts;
};
const Fields<SlipFile>& file_fields() {
  static const Fields<SlipPart> kPart{name_of("name", &SlipPart::name, kRequired, "its name"),
                                      number("size", &SlipPart::size, Dimension::Length, kAny, kRequired, "its edge"),
                                      text("note", &SlipPart::note, kOptional, "what a reader may want to know")};
  static const Fields<SlipFile> kFile{
      text("manual", &SlipFile::manual, kOptional, "where that is told"),
      text("title", &SlipFile::title, kOptional, "its title"),
      number("watchdog", &SlipFile::watchdog, Dimension::Time, kAny, kOptional, "its time"),
      list("parts", &SlipFile::parts, kPart, {0, 20000}, kRequired, "what it is made of")};
  return kFile;
}

struct SlippedFile {
  const char* name;
  const char* text;
  std::vector<std::string> told;  ///< "line:column: message", its begin
};
void PrintTo(const SlippedFile& wrong, std::ostream* out) { *out << wrong.name; }
class LineSlipIn : public testing::TestWithParam<SlippedFile> {};

TEST_P(LineSlipIn, is_told_with_what_is_wrong_besides) {
  const SlippedFile& w = GetParam();
  Mistakes mistakes("f");
  read_fields(w.text, file_fields(), mistakes);
  const auto errors = mistakes.errors();
  ASSERT_EQ(errors.size(), w.told.size()) << (errors.empty() ? "" : to_text(errors[0]));
  for (std::size_t i = 0; i < errors.size(); ++i)
    EXPECT_EQ(to_text(errors[i]).substr(2, w.told[i].size()), w.told[i]) << to_text(errors[i]);
}

INSTANTIATE_TEST_SUITE_P(
    Texts, LineSlipIn,
    testing::Values(
        // Below a text of several lines it would be a part of that, and nobody would miss it.
        SlippedFile{"a_misspelt_key_below_a_text",
                    "manual: >\n  STD402EC\nwatchdg: 100 ms\nparts: []\n",
                    {"3:1: unknown key 'watchdg'; did you mean 'watchdog'?"}},
        SlippedFile{"a_wrong_value_below_a_text",
                    "manual: >\n  STD402EC\nwatchdog: 100 mm\nparts: []\ntitel: x\n",
                    {"3:11: ", "5:1: unknown key 'titel'"}},
        // Taking the next quote away would make a text of the next row.
        SlippedFile{"a_quote_that_never_ends",
                    "parts:\n  - {name: a, size: 1 mm, note: \"10.1}\n  - {name: b, size: 1 mm, note: \"10.2\"}\n",
                    {"2:33: this \" never ends; close it"}},
        SlippedFile{"a_quote_too_many",
                    "parts:\n  - {name: a, size: 1 mm}\"\n  - {name: b, size: 1 mm}\n",
                    {"2:26: a quote that never ends, or one too many: close it, or take this \" away"}},
        SlippedFile{"a_bracket_too_many",
                    "parts:\n  - {name: a, size: 1 mm, note: di }gital}\n  - {name: b, size: 1 mm}\n",
                    {"2:36: this } is one too many; take it away"}},
        SlippedFile{"no_bracket_at_the_end",
                    "parts:\n  - {name: a, size: 1 mm  # the first\n  - {name: b, size: 1 mm}\n",
                    {"2:25: '}' is missing at the end of this line"}},
        // What is beneath a key that nobody knows is not looked at.
        SlippedFile{"two_misspelt_keys_in_a_row",
                    "titel:\nmanul: x\nparts: []\n",
                    {"1:1: unknown key 'titel'", "2:1: unknown key 'manul'"}},
        SlippedFile{
            "a_line_too_far_in_that_hides_a_mistake",
            "title: x\n  parts:\n  - {name: a, size: 1 mm}\n  - {name: b, size: 1 kg}\n",
            {"2:8: this line begins in column 3, and 'title' on line 1 has a value already; begin it in column 1"}},
        SlippedFile{"no_heading",
                    "title: x\n  - {name: a, size: 1 mm}\n  - {name: b, size: 1 mm}\n",
                    {"2:3: a line is missing above this one, which begins in column 1: for example `parts:`"}},
        SlippedFile{"a_file_that_begins_in_two_columns",
                    "  title: x\nparts: []\nwatchdg: 1 s\n",
                    {"2:1: this line stands further left than what is above, and begins another document"}}),
    [](const auto& row) { return std::string(row.param.name); });

// Each sign of it was a copy of the line until now: 3.8 GB.
TEST(LineSlip, in_a_line_of_ten_thousand_brackets_is_found) {
  std::string text = "parts: [";
  for (int i = 0; i < 10000; ++i) text += "{name: a, size: 1 mm}, ";
  Mistakes mistakes("f");
  read_fields(text + "\ntitle: x\n", file_fields(), mistakes);
  EXPECT_EQ(mistakes.errors().size(), 1u);
}

}  // namespace
}  // namespace gantry::config
