// Slips of the hand all over the shipped recipes: a line that begins too far in or out, a sign too many or too few, a
// line twice. Each is one message, in the line where the hand slipped or the next one.
#include <cstdlib>
#include <fmt/format.h>
#include <fstream>
#include <functional>
#include <gtest/gtest.h>
#include <sstream>

#include "recipes/points_file.hpp"
#include "recipes/recipe_file.hpp"

namespace gantry::recipes {
namespace {

constexpr std::size_t kEvery = 3;  // line; a slow slip costs 20 ms

using Words = std::optional<std::string>;
struct Slip {
  const char* name;
  std::function<Words(const std::string&)> made;  ///< of a line; none where it can't be
};
const std::vector<Slip> kSlips{
    {"further_in", [](const std::string& l) { return Words("  " + l); }},
    {"a_little_in", [](const std::string& l) { return Words(" " + l); }},
    {"further_out", [](const std::string& l) { return l.starts_with("  ") ? Words(l.substr(2)) : std::nullopt; }},
    {"a_quote", [](const std::string& l) { return l.ends_with('}') ? Words(l + "\"") : std::nullopt; }},
    {"a_bracket", [](const std::string& l) { return Words(l + "]"); }},
    {"no_colon",
     [](const std::string& l) {
       const auto at = l.find(": ");
       return at == std::string::npos ? std::nullopt : Words(l.substr(0, at) + l.substr(at + 1));
     }},
    {"twice", [](const std::string& l) { return l.starts_with("  - ") ? std::nullopt : Words(l + "\n" + l); }},
};

std::vector<std::string> lines_of(const std::string& file) {
  std::ifstream in(file);
  std::vector<std::string> out;
  for (std::string line; std::getline(in, line);) out.push_back(line);
  return out;
}

void expect_one_message(const std::string& file) {
  const std::vector<std::string> lines = lines_of(file);
  ASSERT_GT(lines.size(), 20u);
  for (std::size_t n = 0; n < lines.size(); n += kEvery) {
    const auto first = lines[n].find_first_not_of(' ');
    if (first == std::string::npos || lines[n][first] == '#') continue;
    for (const Slip& slip : kSlips) {
      const auto line = slip.made(lines[n]);
      if (!line) continue;
      std::string text;
      for (std::size_t k = 0; k < lines.size(); ++k) text += (k == n ? *line : lines[k]) + "\n";
      const auto draft = written::draft(text, file, [&](const std::string& name) { return read_beside(file, name); });
      if (draft.mistakes.empty()) continue;  // it says the same, or something else that is right
      const std::string about = fmt::format("{}:{} {}: {}", file, n + 1, slip.name, to_text(draft.mistakes[0]));
      EXPECT_EQ(draft.mistakes.size(), 1u) << about;
      const std::string& where = draft.mistakes[0].where;
      const int told = std::atoi(where.substr(where.find(':') + 1).c_str());
      // Who begins a block too far in has the rest of it told, which is as good a place.
      EXPECT_TRUE(told >= static_cast<int>(n + 1) && told <= static_cast<int>(n + 2)) << about;
    }
  }
}

TEST(Slip, in_the_demo_board_is_one_message_where_it_is) { expect_one_message("recipes/demo-board.yaml"); }
TEST(Slip, in_the_patterns_is_one_message_where_it_is) { expect_one_message("recipes/patterns.yaml"); }

/// A heading that is missing, and one that stands too far in, in words.
struct Told {
  const char* name;
  const char* line;     ///< of the recipe
  const char* instead;  ///< none: left out
  const char* where;
  const char* says;
};
void PrintTo(const Told& told, std::ostream* out) { *out << told.name; }
class ALine : public testing::TestWithParam<Told> {};

TEST_P(ALine, is_told_with_what_to_write) {
  const Told& t = GetParam();
  std::string text;
  for (const std::string& line : lines_of("recipes/demo-board.yaml"))
    if (line.starts_with(t.line))
      text += t.instead == nullptr ? "" : std::string(t.instead) + line.substr(line.find_first_not_of(' ')) + "\n";
    else
      text += line + "\n";
  const auto draft = written::draft(text, "r.yaml", [](const std::string&) { return Result<std::string>(""); });
  ASSERT_EQ(draft.mistakes.size(), 1u);
  EXPECT_EQ(draft.mistakes[0].where, t.where) << draft.mistakes[0].message;
  EXPECT_EQ(draft.mistakes[0].message, t.says);
}

INSTANTIATE_TEST_SUITE_P(
    Recipes, ALine,
    testing::Values(
        Told{"heading_too_far_in", "parts:", "  ", "r.yaml:13:3",
             "this line begins in column 3 and does not fit there; begin it in column 1"},
        Told{"name_too_far_in", "  sealant:", "    ", "r.yaml:45:5",
             "this line begins in column 5 and does not fit there; begin it in column 3, as a part of "
             "'materials'"},
        Told{"key_too_far_out", "    retract: 4 mm", "  ", "r.yaml:52:3",
             "this line begins in column 3 and does not fit there; begin it in column 5, as a part of "
             "'sealant'"},
        Told{"no_heading", "parts:", nullptr, "r.yaml:13:3",
             "a line is missing above this one, which begins in column 1: for example `keep_out:` or `parts:`"},
        Told{"no_name", "  sealant:", nullptr, "r.yaml:45:5",
             "a line is missing above this one, which begins in column 3: the name of what follows, such as "
             "`some_name:`"}),
    [](const auto& row) { return std::string(row.param.name); });

}  // namespace
}  // namespace gantry::recipes
