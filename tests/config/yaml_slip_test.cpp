// Slips of the hand in a recipe, each with where it is told and what the message says to write; by hand.
#include "config/yaml_slip.hpp"

#include <gtest/gtest.h>

#include "config/yaml.hpp"

namespace gantry::config {
namespace {

struct Slipped {
  const char* name;
  std::string text;
  const char* where;
  const char* says;
};
void PrintTo(const Slipped& slipped, std::ostream* out) { *out << slipped.name; }

class YamlSlip : public testing::TestWithParam<Slipped> {};

TEST_P(YamlSlip, is_told_with_what_to_write) {
  const Slipped& t = GetParam();
  Mistakes mistakes("f.yaml");
  EXPECT_FALSE(read_yaml(t.text, mistakes));
  const auto errors = mistakes.errors();
  ASSERT_EQ(errors.size(), 1u);
  EXPECT_EQ(errors[0].fault, Fault::YamlSyntax);
  EXPECT_EQ(errors[0].where, t.where) << errors[0].message;
  EXPECT_NE(errors[0].message.find(t.says), std::string::npos) << errors[0].message;
}

INSTANTIATE_TEST_SUITE_P(
    Recipes, YamlSlip,
    testing::Values(
        Slipped{"open_brace", "marks:\n  a: {at: 1, d: 2\n  b: {at: 3}\n", "f.yaml:3:4",
                "',' or '}' is missing before this; the '{' stands at 2:6"},
        Slipped{"open_brace_to_the_end", "a: {b: 1\n", "f.yaml:2:1", "'}' is missing; the '{' stands at 1:4"},
        Slipped{"open_bracket", "a: [1, 2\n", "f.yaml:2:1", "']' is missing; the '[' stands at 1:4"},
        Slipped{"no_comma", "a: {from: [1, 2] to: 3}\n", "f.yaml:1:18", "',' or '}' is missing before this"},
        Slipped{"brace_for_a_bracket", "a: {at: [1, 2}\n", "f.yaml:1:14",
                "']' is missing before this; the '[' stands at 1:9"},
        Slipped{"a_brace_too_many", "a: {b: 1}}\n", "f.yaml:1:10", "'}' closes nothing; take it away"},
        Slipped{"brackets_in_quotes_and_comments_count_for_nothing", "a: [1, '[', \"{\"  # ( [\n  }\n", "f.yaml:2:3",
                "the '[' stands at 1:4"},
        Slipped{"no_colon", "board:\n  thickness 12 mm\n  frame: pallet\n", "f.yaml:2:3",
                "'thickness 12 mm' has no ': '"},
        Slipped{"no_blank_behind_the_colon", "board:\n  thickness:12 mm\n  frame: pallet\n", "f.yaml:2:3",
                "'thickness:12 mm' has no ': '"},
        Slipped{"colon_of_another_script", "board:\n  thickness\xEF\xBC\x9A 12 mm\n  frame: pallet\n", "f.yaml:2:3",
                "has no ': '"},
        Slipped{"two_colons", "recipe: two: dots\n", "f.yaml:1:12",
                "a second ': ' in one line; put text with ': ' in it in quotes"},
        Slipped{"deeper_under_a_value", "board:\n  size: 1\n   frame: pallet\n", "f.yaml:3:9",
                "this line begins in column 4, and 'size' on line 2 has a value already; begin it in column 3"},
        Slipped{"deeper_than_its_key", "board:\n  size: [1, 2]\n   frame: pallet\n", "f.yaml:3:4",
                "this line begins in column 4; begin it in column 3, as line 2 does"},
        Slipped{"less_deep_than_its_key", "board:\n   size: [1, 2]\n  frame: pallet\n", "f.yaml:3:3",
                "this line begins in column 3; begin it in column 4, as line 2 does"},
        Slipped{"a_dash_without_a_blank", "features:\n  - dot: {a: 1}\n  -dot: {a: 2}\n", "f.yaml:3:3",
                "a '-' that begins an item wants a blank behind it; write '- dot'"},
        Slipped{"a_key_among_items", "features:\n  - dot: {a: 1}\n  dot: {a: 2}\n", "f.yaml:3:3", "begin it with '- '"},
        Slipped{"at_sign", "frame: @pallet\n", "f.yaml:1:8", "no text begins with '@'; put it in quotes"},
        Slipped{"backslash", "frame: \"pal\\let\"\n", "f.yaml:1:14",
                "in double quotes '\\' begins an escape; use single quotes"}),
    [](const auto& each) { return std::string(each.param.name); });

}  // namespace
}  // namespace gantry::config
