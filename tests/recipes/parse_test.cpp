#include <algorithm>
#include <gtest/gtest.h>

#include "recipes/recipe.hpp"

namespace gantry::recipes {
namespace {

TEST(Recipe, the_demo_board_reads_without_a_mistake) {
  const auto r = load("recipes/demo-board.yaml");
  if (!r)
    for (const Error& e : r.error()) ADD_FAILURE() << to_text(e);
  ASSERT_TRUE(r);
  std::size_t dots = 0, beads = 0;
  for (const Feature& f : r->features) (std::holds_alternative<Dot>(f) ? dots : beads) += 1;
  EXPECT_EQ(dots, 29u);
  EXPECT_EQ(beads, 6u);
}

TEST(Recipe, three_mistakes_are_three_messages_at_their_places) {
  std::string text = *config::read_text_file("recipes/demo-board.yaml");
  const auto swap = [&](const std::string& from, const std::string& to) {
    const auto at = text.find(from);
    ASSERT_NE(at, std::string::npos) << from;
    text.replace(at, from.size(), to);
  };
  const auto place = [&](const std::string& what) {
    const auto at = text.find(what);
    const auto line = 1 + std::count(text.begin(), text.begin() + static_cast<long>(at), '\n');
    const auto start = text.rfind('\n', at) + 1;
    return "board.yaml:" + std::to_string(line) + ":" + std::to_string(at - start + 1);
  };
  swap("speed: 15 mm/s", "sped: 15 mm/s");
  swap("gap: 0.4 mm", "gap: 0.44");
  swap("name: capacitor_l\n      material: sealant", "name: capacitor_l\n      material: sealent");
  const auto r = parse(text, "board.yaml");
  ASSERT_FALSE(r);
  ASSERT_EQ(r.error().size(), 3u) << to_text(r.error().back());
  EXPECT_EQ(r.error()[0].fault, Fault::UnknownKey);
  EXPECT_EQ(r.error()[0].where, place("sped:"));
  EXPECT_NE(r.error()[0].message.find("'speed'"), std::string::npos);
  EXPECT_EQ(r.error()[1].fault, Fault::BadUnit);
  EXPECT_EQ(r.error()[1].where, place("0.44"));
  EXPECT_EQ(r.error()[2].fault, Fault::UnknownReference);
  EXPECT_EQ(r.error()[2].where, place("sealent"));
}

}  // namespace
}  // namespace gantry::recipes
