#include "recipes/selection.hpp"

#include <gtest/gtest.h>
#include <random>

namespace gantry::recipes {
namespace {

const char* const kRecipe =
    "version: 1\nrecipe: r\nplacement: fixture\nboard: {size: [90 mm, 60 mm], thickness: 8 mm, frame: pallet}\n"
    "materials:\n  a: {speed: 20 mm/s, gap: 0.2 mm, valve_open_lead: 8 ms, valve_close_lead: 6 ms, dot_time: 60 ms, "
    "retract: 3 mm}\nfeatures:\n"
    "  - dot: {name: first, material: a, at: [10 mm, 10 mm]}\n"                                             // 0
    "  - array: {name: dots, material: a, at: [20 mm, 10 mm], rows: 2, columns: 2, pitch: [5 mm, 5 mm]}\n"  // 1 .. 4
    "  - line: {name: dam, material: a, from: [40 mm, 10 mm], to: [40 mm, 30 mm]}\n"                        // 5
    "  - dot: {name: dots_2, material: a, at: [60 mm, 10 mm]}\n";                                           // 6

using Indices = std::vector<std::size_t>;

Recipe recipe() { return parse(kRecipe, "r.yaml").value(); }

Indices chosen(const Selection& selection) {
  const auto found = choose(recipe(), selection);
  EXPECT_TRUE(found) << to_text(found.error());
  return found.value_or(Indices{});
}

TEST(Selection, names_features_arrays_and_elements_in_the_order_of_the_recipe) {
  EXPECT_EQ(chosen({}), (Indices{0, 1, 2, 3, 4, 5, 6}));
  EXPECT_EQ(chosen({.from = "dam"}), (Indices{5, 6}));
  EXPECT_EQ(chosen({.from = "first"}), chosen({}));
  EXPECT_EQ(chosen({.from = "dots"}), (Indices{1, 2, 3, 4, 5, 6}));
  EXPECT_EQ(chosen({.from = "dots[1][1]"}), (Indices{3, 4, 5, 6})) << "to and fro: the second row begins at its end";
  EXPECT_EQ(chosen({.only = {"dam", "first"}}), (Indices{0, 5}));
  EXPECT_EQ(chosen({.only = {"dots"}}), (Indices{1, 2, 3, 4}));
  EXPECT_EQ(chosen({.only = {"dots_2"}}), (Indices{6})) << "no part of the array that begins with the same word";
  EXPECT_EQ(chosen({.only = {"dots[0][1]", "dam", "dots[0][1]", "dam"}}), (Indices{2, 5})) << "named twice is once";
  EXPECT_EQ(chosen({.only = {" dam", "first\t"}}), (Indices{0, 5})) << "blanks beside a comma";
}

TEST(Selection, of_what_the_recipe_does_not_have_names_the_nearest) {
  const auto says = [](const Selection& selection, const char* where, const char* words) {
    const auto found = choose(recipe(), selection);
    ASSERT_FALSE(found);
    EXPECT_EQ(found.error().fault, Fault::Usage);
    EXPECT_EQ(found.error().where, where);
    EXPECT_NE(found.error().message.find(words), std::string::npos) << found.error().message;
  };
  says({.only = {"first", "damn"}}, "--only", "r.yaml has no feature 'damn'; did you mean 'dam'?");
  says({.from = "dots[1][2]"}, "--from",
       "there is no 'dots[1][2]'; the 4 elements of 'dots' are dots[0][0], dots[0][1], dots[1][1], dots[1][0]");
  says({.only = {"dam[0]"}}, "--only", "'dam' is one feature, without elements; write 'dam'");
  says({.from = "a feature"}, "--from", "known: first, dots, dam, dots_2");
  says({.only = {"dam", ""}}, "--only", "missing");
  says({.only = {" "}}, "--only", "missing");
  says({.from = "dam", .only = {"first"}}, "--only", "not given together");
}

TEST(Selection, leaves_marks_touches_and_parking_in_the_job) {
  Job job;
  for (const auto& what : {Block{1, LookAtMark{0}}, Block{2, Touch{0}}, Block{3, PurgeNeedle{}},
                           Block{4, Dispense{{0, 1, 2, 3, 4, 5, 6}}}, Block{5, Park{}}})
    job.blocks.push_back(what);
  const Job some = only(job, {2, 5});
  ASSERT_EQ(some.blocks.size(), 5u);
  for (const std::size_t same : {0u, 1u, 2u, 4u}) EXPECT_EQ(some.blocks[same].what, job.blocks[same].what);
  EXPECT_EQ(dispensed_by(some), (Indices{2, 5}));
  EXPECT_EQ(dispensed_by(job), chosen({}));
}

TEST(Selection, is_told_in_the_words_that_choose_the_same) {
  EXPECT_EQ(to_text(selection_of(recipe(), {5})), "--only dam");
  EXPECT_EQ(to_text(selection_of(recipe(), {5, 6})), "--from dam");
  EXPECT_EQ(to_text(selection_of(recipe(), {1, 2, 3, 4})), "--only dots");
  EXPECT_EQ(to_text(selection_of(recipe(), {0, 1, 2, 4})), "--only 'first,dots[0][0],dots[0][1],dots[1][0]'");
  EXPECT_EQ(to_text(selection_of(recipe(), {4, 5, 6})), "--from 'dots[1][0]'");
  EXPECT_EQ(to_text(selection_of(recipe(), {})), "");
  constexpr unsigned kSeed = 3;
  std::mt19937 random(kSeed);
  for (int round = 0; round < 500; ++round) {
    Indices some;
    for (std::size_t i = 0; i < recipe().features.size(); ++i)
      if (random() % 2 == 0) some.push_back(i);
    if (some.empty()) continue;
    EXPECT_EQ(chosen(selection_of(recipe(), some)), some) << "seed " << kSeed << ", round " << round;
  }
}

}  // namespace
}  // namespace gantry::recipes
