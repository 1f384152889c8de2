// A whole job in an order with little travel, in virtual time: what the world saw, in the order in which it saw it.
#include <algorithm>

#include "recipes/points_file.hpp"
#include "recipes/travel.hpp"
#include "tests/machine/rig.hpp"

namespace gantry {
namespace {

const std::string kPatterns = "recipes/patterns.yaml";

recipes::Recipe patterns(const std::string& order) {
  std::string text = config::read_text_file(kPatterns).value();
  const std::string before = "recipe: patterns\n", waits = "- dot: {name: single, ";
  text.replace(text.find(before), before.size(), before + "order: " + order + "\n");
  if (order == "shortest") text.replace(text.find(waits), waits.size(), waits + "after: [coil, field], ");
  auto recipe = recipes::parse(text, kPatterns, [](const auto& name) { return recipes::read_beside(kPatterns, name); });
  for (const Error& e : recipe ? std::vector<Error>{} : recipe.error()) ADD_FAILURE() << to_text(e);
  return recipe.value_or(recipes::Recipe{});
}

TEST(OrderShortest, a_job_dispenses_all_of_it_with_less_travel_and_keeps_what_comes_first) {
  const recipes::Recipe recipe = patterns("shortest");
  test::Rig rig({.placement = "dx=1.1 mm, dy=-0.6 mm, rot=0.7 deg"}),
      other({.placement = "dx=1.1 mm, dy=-0.6 mm, rot=0.7 deg"});
  const record::JobResult result = rig.run(recipe), in_file = other.run(patterns("file"));
  ASSERT_TRUE(result.errors.empty()) << to_text(result.errors.front());
  EXPECT_EQ(result.features_done, recipe.features.size());
  EXPECT_EQ(result.collisions.size(), 0u);

  std::vector<std::string> seen, meant;
  for (const record::Deposit& d : result.deposits)
    if (record::on_feature(d)) seen.push_back(d.id);
  for (const std::size_t f : recipe.sequence) meant.push_back(id_of(recipe.features[f]));
  EXPECT_EQ(seen, meant);
  const auto place = [&](const std::string& id) { return std::find(seen.begin(), seen.end(), id) - seen.begin(); };
  EXPECT_GT(place("single"), place("coil"));
  for (const std::string& id : seen)
    if (id.rfind("field[", 0) == 0) {
      EXPECT_GT(place("single"), place(id)) << id;
    }

  EXPECT_EQ(result.order, recipes::Order::Shortest);
  EXPECT_LT(result.travel.as_ordered_mm, 0.8 * result.travel.in_file_order_mm);
  EXPECT_NEAR(in_file.travel.as_ordered_mm, result.travel.in_file_order_mm, 1e-9);
  EXPECT_NEAR(in_file.travel.as_ordered_mm, in_file.travel.in_file_order_mm, 0);
  EXPECT_LT(result.actual_s, in_file.actual_s);
}

}  // namespace
}  // namespace gantry
