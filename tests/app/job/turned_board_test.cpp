// Whether a board that lies the wrong way round would be noticed.
#include "app/job/turned_board.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <initializer_list>
#include <utility>

namespace gantry::job {
namespace {

config::Machine dispenser() { return *config::load_machine("config/machines/dispenser.yaml"); }

recipes::Recipe board(const std::string& size, const std::string& marks, const std::string& rules = "") {
  const auto r = recipes::parse(
      fmt::format("version: 1\nrecipe: r\nboard: {{size: {}, thickness: 8 mm, frame: pallet}}\nmarks:\n{}mark_rules: "
                  "{{max_shift: 3 mm, max_rotation: 2 deg{}}}\nmaterials:\n  a: {{speed: 20 mm/s, gap: 0.2 mm, "
                  "valve_open_lead: 8 ms, valve_close_lead: 6 ms, dot_time: 60 ms, retract: 3 mm}}\nfeatures:\n"
                  "  - dot: {{name: d, material: a, at: [30 mm, 20 mm]}}\n",
                  size, marks, rules),
      "r.yaml");
  EXPECT_TRUE(r) << to_text(r.error().front());
  return r.value();
}

constexpr const char* kOblong = "[60 mm, 40 mm]";
constexpr const char* kSquare = "[40 mm, 40 mm]";
constexpr const char* kTwo = "  a: {at: [5 mm, 5 mm], diameter: 1.5 mm}\n  b: {at: [55 mm, 35 mm], diameter: 1.5 mm}\n";

TEST(TurnedBoard, marks_that_come_to_lie_on_marks_are_a_mistake_at_the_first_of_them) {
  const auto r = fits_one_way(board(kOblong, kTwo), dispenser());
  ASSERT_FALSE(r);
  EXPECT_EQ(r.error().fault, Fault::Inconsistent);
  EXPECT_EQ(r.error().where, "r.yaml:5:3");
  EXPECT_NE(r.error().message.find("180 deg"), std::string::npos) << r.error().message;
  EXPECT_NE(r.error().message.find("symmetric: allowed"), std::string::npos) << r.error().message;
}

TEST(TurnedBoard, is_let_pass_where_the_recipe_allows_it) {
  EXPECT_TRUE(fits_one_way(board(kOblong, kTwo, ", symmetric: allowed"), dispenser()));
}

TEST(TurnedBoard, another_diameter_brightness_or_position_tells_it) {
  const auto other = [](const char* b) {
    return fits_one_way(board(kOblong, std::string("  a: {at: [5 mm, 5 mm], diameter: 1.5 mm}\n  b: ") + b + "\n"),
                        dispenser())
        .has_value();
  };
  EXPECT_TRUE(other("{at: [55 mm, 35 mm], diameter: 2.5 mm}"));
  EXPECT_TRUE(other("{at: [55 mm, 35 mm], diameter: 1.5 mm, bright: false}"));
  EXPECT_TRUE(other("{at: [55 mm, 25 mm], diameter: 1.5 mm}"));
  EXPECT_FALSE(other("{at: [55 mm, 33 mm], diameter: 1.5 mm}")) << "2 mm off, which a loose seat makes up for";
}

TEST(TurnedBoard, a_square_board_is_turned_by_a_quarter_too) {
  const std::string two = "  a: {at: [5 mm, 5 mm], diameter: 1.5 mm}\n  b: {at: [35 mm, 5 mm], diameter: 1.5 mm}\n";
  EXPECT_TRUE(fits_one_way(board(kSquare, two + "  c: {at: [28 mm, 35 mm], diameter: 1.5 mm}\n"), dispenser()));
  const std::string all =
      two + "  c: {at: [35 mm, 35 mm], diameter: 1.5 mm}\n" + "  d: {at: [5 mm, 35 mm], diameter: 1.5 mm}\n";
  EXPECT_FALSE(fits_one_way(board(kSquare, all), dispenser()));
  EXPECT_FALSE(fits_one_way(board("[40 mm, 60 mm]",
                                  "  a: {at: [5 mm, 5 mm], diameter: 1.5 mm}\n"
                                  "  b: {at: [35 mm, 55 mm], diameter: 1.5 mm}\n"),
                            dispenser()));
}

/// What is told of the marks at these positions, all alike; "" where the board is accepted.
std::string told_of(const std::string& size, std::initializer_list<std::pair<int, int>> marks) {
  std::string text;
  for (const auto& [x, y] : marks)
    text += fmt::format("  m{}_{}: {{at: [{} mm, {} mm], diameter: 1.5 mm}}\n", x, y, x, y);
  const auto r = fits_one_way(board(size, text), dispenser());
  return r ? "" : r.error().message;
}

TEST(TurnedBoard, a_board_turned_over_is_told_by_the_direction_about_which) {
  // An auditor's board: no half turn brings these marks to lie on each other, turning it over end to end does.
  EXPECT_NE(told_of("[120 mm, 80 mm]", {{5, 5}, {115, 5}, {5, 60}, {115, 60}})
                .find("turned over, its bottom up, about its Y"),
            std::string::npos);
  EXPECT_NE(
      told_of("[120 mm, 80 mm]", {{5, 5}, {5, 75}, {90, 5}, {90, 75}}).find("turned over, its bottom up, about its X"),
      std::string::npos);
  EXPECT_EQ(told_of("[120 mm, 80 mm]", {{5, 5}, {115, 5}, {5, 60}, {115, 75}}), "") << "one of them is out of line";
}

TEST(TurnedBoard, a_square_board_is_turned_over_about_its_diagonals_too) {
  EXPECT_NE(
      told_of("[80 mm, 80 mm]", {{5, 5}, {75, 75}, {30, 5}, {5, 30}}).find("about the diagonal through its origin"),
      std::string::npos);
  EXPECT_NE(
      told_of("[80 mm, 80 mm]", {{75, 5}, {5, 75}, {30, 5}, {75, 50}}).find("about the diagonal beside its origin"),
      std::string::npos);
  EXPECT_EQ(told_of("[80 mm, 60 mm]", {{5, 5}, {55, 55}, {30, 5}, {5, 30}}), "") << "an oblong one does not fit so";
}

TEST(TurnedBoard, the_demo_board_fits_one_way) {
  const auto demo = recipes::load("recipes/demo-board.yaml");
  ASSERT_TRUE(demo);
  const auto one_way = fits_one_way(*demo, dispenser());
  EXPECT_TRUE(one_way) << to_text(one_way.error());
}

}  // namespace
}  // namespace gantry::job
