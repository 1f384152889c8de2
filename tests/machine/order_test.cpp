// A whole job in an order with little travel, in virtual time: what the world saw, in the order in which it saw it.
#include <algorithm>
#include <fmt/format.h>

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

/// Dots and lines on a bare board that lies where it should.
recipes::Recipe plain(const std::string& materials, const std::string& features) {
  const std::string text =
      "version: 1\nrecipe: r\nplacement: fixture\norder: shortest\n"
      "board: {size: [120 mm, 80 mm], thickness: 12 mm, frame: pallet}\nmaterials:\n" +
      materials + "features:\n" + features;
  auto recipe = recipes::parse(text, "r.yaml");
  for (const Error& e : recipe ? std::vector<Error>{} : recipe.error()) ADD_FAILURE() << to_text(e);
  return recipe.value_or(recipes::Recipe{});
}
std::string material(const std::string& name, double gap_mm, double lead_ms) {
  return fmt::format(
      "  {}: {{speed: 20 mm/s, gap: {} mm, valve_open_lead: {} ms, valve_close_lead: 6 ms, dot_time: 60 ms, retract: 3 "
      "mm}}\n",
      name, gap_mm, lead_ms);
}

// The valve is told to open before the path has come to the feature: which one is next is the job's to say.
TEST(OrderShortest, a_valve_that_opens_ahead_opens_for_the_next_in_the_order_of_the_job) {
  const recipes::Recipe recipe = plain(material("glue", 0.3, 8),
                                       "  - dot: {name: a, material: glue, at: [20 mm, 40 mm]}\n"
                                       "  - dot: {name: b, material: glue, at: [80 mm, 40 mm]}\n"
                                       "  - dot: {name: c, material: glue, at: [40 mm, 40 mm]}\n");
  ASSERT_EQ(recipe.sequence, (std::vector<std::size_t>{0, 2, 1}));
  test::Rig rig({.placement = "dx=0 mm, dy=0 mm, rot=0 deg, dz=0 mm, tilt_x=0 deg, tilt_y=0 deg"});
  const record::JobResult result = rig.run(recipe);
  EXPECT_EQ(result.features_done, 3u);
  EXPECT_TRUE(result.interrupted.empty());
  EXPECT_EQ(result.board, record::Board::Whole);
}

TEST(OrderShortest, of_two_that_lie_on_each_other_each_has_its_own_deposit) {
  for (const char* kind : {"  - dot: {name: NAME, material: M, at: [50 mm, 40 mm]AFTER}\n",
                           "  - line: {name: NAME, material: M, from: [40 mm, 40 mm], to: [60 mm, 40 mm]AFTER}\n"}) {
    const auto row = [&](std::string text, const std::string& name, const std::string& m, const std::string& after) {
      for (const auto& [key, value] : {std::pair("NAME", name), std::pair("M,", m + ","), std::pair("AFTER", after)})
        text.replace(text.find(key), std::string(key).size(), value);
      return text;
    };
    const recipes::Recipe recipe = plain(material("m1", 0.4, 8) + material("m2", 0.3, 8),
                                         row(kind, "primer", "m1", ", after: glue") + row(kind, "glue", "m2", ""));
    ASSERT_EQ(recipe.sequence, (std::vector<std::size_t>{1, 0}));
    test::Rig rig({.placement = "dx=0 mm, dy=0 mm, rot=0 deg, dz=0 mm, tilt_x=0 deg, tilt_y=0 deg"});
    const record::JobResult result = rig.run(recipe);
    EXPECT_TRUE(result.defects.empty()) << result.defects.front().message;
    ASSERT_EQ(result.deposits.size(), 2u);
    EXPECT_EQ(result.deposits[0].id, "glue");
    EXPECT_NEAR(result.deposits[0].gap_mm, 0.3, 0.05);
    EXPECT_NEAR(result.deposits[1].gap_mm, 0.4, 0.05);
  }
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
