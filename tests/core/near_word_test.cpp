#include "core/near_word.hpp"

#include <gtest/gtest.h>

namespace gantry {
namespace {

TEST(Nearest, names_what_was_meant_and_nothing_far_off) {
  const std::vector<std::string_view> known{"speed", "gap", "valve_open_lead", "retract"};
  EXPECT_EQ(nearest("sped", known), "speed");
  EXPECT_EQ(nearest("valve_openlead", known), "valve_open_lead");
  EXPECT_EQ(nearest("foo", {"jog", "down"}), "");
  EXPECT_EQ(nearest("gpa", known), "gap");
  EXPECT_EQ(nearest("colour", known), "");
  EXPECT_EQ(nearest("xyz", known), "");
  EXPECT_EQ(nearest("", known), "");
}

TEST(Nearest, is_told_in_one_choice_of_words) {
  EXPECT_EQ(did_you_mean("sped", {"gap", "speed"}), "did you mean 'speed'?");
  EXPECT_EQ(did_you_mean("colour", {"gap", "speed"}), "known: gap, speed");
  EXPECT_EQ(did_you_mean("colour", {}), "there are none");
}

TEST(Nearest, a_long_list_is_cut) {
  const std::vector<std::string> names(100000, "feature");
  const std::string said = did_you_mean("x", {names.begin(), names.end()});
  EXPECT_TRUE(said.ends_with("feature, ..."));
  EXPECT_LT(said.size(), 300u);
}

}  // namespace
}  // namespace gantry
