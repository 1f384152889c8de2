// `order` and `after` as a recipe says them.
#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <numeric>
#include <random>

#include "recipes/job.hpp"
#include "recipes/selection.hpp"
#include "recipes/travel.hpp"

namespace gantry::recipes {
namespace {

using Indices = std::vector<std::size_t>;

std::string with(const std::string& order, const std::string& features) {
  return "version: 1\nrecipe: r\nplacement: fixture\n" + (order.empty() ? "" : "order: " + order + "\n") +
         "board: {size: [100 mm, 60 mm], thickness: 12 mm, frame: pallet}\n"
         "materials:\n"
         "  glue: {speed: 10 mm/s, gap: 0.2 mm, valve_open_lead: 8 ms, valve_close_lead: 6 ms, dot_time: 50 ms, "
         "retract: 3 mm}\n"
         "  paste: {speed: 10 mm/s, gap: 0.2 mm, valve_open_lead: 8 ms, valve_close_lead: 6 ms, dot_time: 50 ms, "
         "retract: 3 mm, back_track: 2 mm, tail_lift: 1 mm}\n"
         "features:\n" +
         features;
}

std::string dot(const std::string& name, double x_mm, const std::string& more = "",
                const std::string& material = "glue") {
  return "  - dot: {name: " + name + ", material: " + material + ", at: [" + std::to_string(x_mm) + " mm, 10 mm]" +
         more + "}\n";
}

Recipe read(const std::string& text) {
  auto r = parse(text, "r.yaml");
  if (!r)
    for (const Error& e : r.error()) ADD_FAILURE() << to_text(e);
  return r ? *r : Recipe{};
}

std::string names(const Recipe& r) {
  std::string out;
  for (const std::size_t f : sequence_of(r)) out += (out.empty() ? "" : " ") + id_of(r.features[f]);
  return out;
}

const std::string kZigzag = dot("a", 10) + dot("b", 90) + dot("c", 30) + dot("d", 70) + dot("e", 50);

TEST(Order, is_that_of_the_file_until_the_recipe_asks_for_the_shortest) {
  EXPECT_EQ(names(read(with("", kZigzag))), "a b c d e");
  EXPECT_EQ(names(read(with("file", kZigzag))), "a b c d e");
  EXPECT_EQ(names(read(with("shortest", kZigzag))), "a c e d b");
}

TEST(Order, what_a_feature_waits_for_comes_before_it) {
  const auto after = [](const std::string& who) { return ", after: " + who; };
  EXPECT_EQ(names(read(with("shortest", dot("a", 10) + dot("b", 90) + dot("c", 30, after("b"))))), "b c a");
  const Recipe two = read(with("shortest", dot("a", 10, after("[c, b]")) + dot("b", 90) + dot("c", 30)));
  EXPECT_EQ(names(two), "b c a") << "the file need not have them in that order";
  const std::string array =
      "  - array: {name: dots, material: glue, at: [20 mm, 10 mm], rows: 1, columns: 3, pitch: [5 mm, 1 mm]}\n";
  EXPECT_EQ(names(read(with("shortest", array + dot("a", 26, after("dots"))))), "dots[0][0] dots[0][1] dots[0][2] a")
      << "of an array it waits for every dot";
}

TEST(Order, mistakes_in_after_are_told_where_they_stand) {
  const auto says = [](const std::string& text, int line, const std::string& words) {
    const auto r = parse(text, "r.yaml");
    ASSERT_FALSE(r);
    bool found = false;
    std::string all;
    for (const Error& e : r.error()) {
      all += to_text(e) + "\n";
      found |=
          e.where.rfind("r.yaml:" + std::to_string(line) + ":", 0) == 0 && e.message.find(words) != std::string::npos;
    }
    EXPECT_TRUE(found) << all << "has no '" << words << "' on line " << line;
  };
  constexpr int kFirst = 10;  // line of the first feature, with an `order`
  const auto after = [](const std::string& who) { return ", after: " + who; };
  says(with("shortest", dot("a", 10) + dot("b", 90, after("c"))), kFirst + 1, "there is no feature 'c'");
  says(with("shortest", dot("seam", 10) + dot("b", 90, after("sean"))), kFirst + 1, "did you mean 'seam'?");
  says(with("shortest", dot("a", 10, after("a"))), kFirst, "cannot come after itself");
  says(with("shortest", dot("a", 10, after("b")) + dot("b", 20, after("c")) + dot("c", 30, after("a"))), kFirst + 2,
       "these wait for one another: 'a' after 'b', 'b' after 'c' and 'c' after 'a'; take one");
  says(with("file", dot("a", 10, after("b")) + dot("b", 20)), kFirst, "write `order: shortest`");
  says(with("file", dot("a", 10) + dot("b", 20, after("[a, a b]"))), kFirst + 1, "name");
  EXPECT_EQ(names(read(with("file", dot("a", 10) + dot("b", 20, after("a"))))), "a b");
}

TEST(Order, a_deposit_of_another_material_keeps_what_it_may_lie_on) {
  // The dot of paste lies on the bead's end; alone it would come first.
  const std::string bead = "  - line: {name: bead, material: glue, from: [60 mm, 10 mm], to: [40 mm, 10 mm]}\n";
  EXPECT_EQ(names(read(with("shortest", dot("a", 20) + bead + dot("on_it", 59, "", "paste")))), "bead on_it a");
  EXPECT_EQ(names(read(with("shortest", dot("a", 20) + bead + dot("on_it", 59)))), "on_it bead a")
      << "its own material";
  EXPECT_EQ(names(read(with("shortest", dot("a", 20) + bead + dot("beside", 62, "", "paste")))), "beside bead a");
  EXPECT_EQ(names(read(with("shortest", dot("a", 20) + bead.substr(0, bead.size() - 2) + ", after: on_it}\n" +
                                            dot("on_it", 59, "", "paste")))),
            "on_it bead a")
      << "`after` turns it round";
}

TEST(Order, what_comes_later_for_another_reason_still_lies_under_what_lay_on_it) {
  // A waits for C alone; B lies on A.
  EXPECT_EQ(names(read(with("shortest", dot("A", 60, ", after: C") + dot("B", 60.5, "", "paste") + dot("C", 20)))),
            "C A B");
}

/// The judge: all orders. Where one keeps every layer of the file and `after`, so does the answer.
TEST(Order, keeps_all_layers_where_that_can_be) {
  std::mt19937 random(11);
  const auto draw = [&](std::size_t n) { return static_cast<std::size_t>(random()) % n; };
  int judged = 0;
  for (int n = 0; n < 150; ++n) {
    constexpr std::size_t count = 6, none = count;
    std::vector<std::size_t> x(count), paste(count), after(count, none);
    std::string text;
    for (std::size_t f = 0; f < count; ++f) {
      x[f] = 10 + 2 * draw(3) + 30 * draw(2), paste[f] = draw(2);
      if (draw(2) == 0) after[f] = (f + 1 + draw(count - 1)) % count;
    }
    for (std::size_t f = 0; f < count; ++f)  // 0.1 mm apart: none is a twin
      text += dot("f" + std::to_string(f), static_cast<double>(x[f]) + 0.1 * static_cast<double>(f),
                  after[f] == none ? "" : ", after: f" + std::to_string(after[f]), paste[f] != 0 ? "paste" : "glue");
    const auto r = parse(with("shortest", text), "r.yaml");
    if (!r) continue;  // a circle
    const auto keeps = [&](const Indices& place, bool layers) {
      for (std::size_t f = 0; f < count; ++f) {
        if (after[f] != none && place[after[f]] > place[f]) return false;
        for (std::size_t g = 0; g < f && layers; ++g)
          if (x[f] == x[g] && paste[f] != paste[g] && place[g] > place[f]) return false;
      }
      return true;
    };
    Indices place(count);
    std::iota(place.begin(), place.end(), 0u);
    bool possible = false;
    do possible = keeps(place, true);
    while (!possible && std::next_permutation(place.begin(), place.end()));
    for (std::size_t k = 0; k < count; ++k) place[r->sequence[k]] = k;
    EXPECT_TRUE(keeps(place, possible)) << text << names(*r);
    judged += possible ? 1 : 0;
  }
  EXPECT_GT(judged, 50);
}

TEST(Order, a_bead_keeps_its_direction) {
  const std::string back = "  - line: {name: back, material: glue, from: [90 mm, 10 mm], to: [12 mm, 10 mm]}\n";
  const Recipe r = read(with("shortest", dot("a", 10) + back + dot("b", 92)));
  EXPECT_EQ(names(r), "b back a");
  EXPECT_EQ(std::get<Bead>(r.features[1]).points.front().x, 90);
}

TEST(Travel, is_what_lies_between_features_lifted_and_after_what_ends_a_bead) {
  const Recipe r = read(
      with("file", dot("a", 10) + "  - line: {name: b, material: paste, from: [13 mm, 14 mm], to: [23 mm, 14 mm]}\n" +
                       dot("c", 21)));
  // From (10, 10) to (13, 14): 5 mm. The bead is left 2 mm before its end, 1 mm higher: from (21, 14) to (21, 10).
  EXPECT_NEAR(travel_of(r, Indices{0, 1, 2}).as_ordered_mm, 5 + std::sqrt(16.0 + 1), 1e-9);
  EXPECT_NEAR(travel_of(r, Indices{0, 2}).as_ordered_mm, 11, 1e-9);
  const Travel turned = travel_of(r, Indices{2, 0});
  EXPECT_NEAR(turned.in_file_order_mm, turned.as_ordered_mm, 1e-9);
}

// ---- selections ----

const std::string kArray =
    "  - dot: {name: first, material: glue, at: [10 mm, 10 mm]}\n"
    "  - dot: {name: far, material: glue, at: [90 mm, 10 mm]}\n"
    "  - array: {name: dots, material: glue, at: [20 mm, 10 mm], rows: 1, columns: 3, pitch: [5 mm, 5 mm]}\n"
    "  - dot: {name: near, material: glue, at: [27 mm, 12 mm]}\n";

TEST(Order, from_means_from_there_on_in_the_order_in_which_it_is_done) {
  const Recipe r = read(with("shortest", kArray));
  ASSERT_EQ(names(r), "first dots[0][0] dots[0][1] near dots[0][2] far");
  const auto chosen = [&](const Selection& selection) { return choose(r, selection).value_or(Indices{}); };
  EXPECT_EQ(chosen({.from = "near"}), (Indices{1, 4, 5}));
  EXPECT_EQ(chosen({.from = "dots"}), (Indices{1, 2, 3, 4, 5})) << "from the first of its dots that is done";
  EXPECT_EQ(chosen({.from = "dots[0][2]"}), (Indices{1, 4}));
  EXPECT_EQ(chosen({.from = "far"}), (Indices{1}));
  EXPECT_EQ(chosen({.only = {"dots"}}), (Indices{2, 3, 4})) << "though another one is done between them";
  Job job;
  job.blocks.push_back({1, Dispense{sequence_of(r)}});
  EXPECT_EQ(dispensed_by(only(job, chosen({.from = "near"}))), (Indices{5, 4, 1})) << "in the order of the job";
  EXPECT_EQ(to_text(selection_of(r, {1, 4, 5})), "--from near");
  EXPECT_EQ(to_text(selection_of(r, {1, 2, 3, 4, 5})), "--from dots");
  EXPECT_EQ(to_text(selection_of(r, {1, 3, 4, 5})), "--from 'dots[0][1]'");
  EXPECT_EQ(to_text(selection_of(r, {2, 3, 4})), "--only dots");
  EXPECT_EQ(to_text(selection_of(r, {1, 5})), "--only far,near") << "no others are done behind them, but one between";
}

TEST(Order, a_selection_is_told_in_words_that_choose_the_same) {
  const Recipe r = read(with("shortest", kArray));
  for (std::size_t some = 1; some < 64; ++some) {
    Indices chosen;
    for (std::size_t f = 0; f < 6; ++f)
      if ((some >> f & 1u) != 0) chosen.push_back(f);
    EXPECT_EQ(choose(r, selection_of(r, chosen)).value_or(Indices{}), chosen) << to_text(selection_of(r, chosen));
  }
}

}  // namespace
}  // namespace gantry::recipes
