// Homing that cannot be right is refused. Which way a method goes is IEC 61800-7-201, 10.4 (AMD530B manual 9.1 tells
// the same); the shipped X has 0 .. 500 mm, its switches at -2 and 505 mm, Z has -80 .. 0 mm and switches at -84 and 1
// mm.
#include <algorithm>
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "changed.hpp"

namespace gantry::config {
namespace {

constexpr const char* kX =
    "    homing: {order: 1, method: 17, fast: 60 mm/s, slow: 5 mm/s, acceleration: 1000 mm/s^2, position: -2 mm}\n";
constexpr const char* kZ =
    "    homing: {order: 0, method: 18, fast: 30 mm/s, slow: 3 mm/s, acceleration: 500 mm/s^2, position: 1 mm}\n";
constexpr const char* kC =
    "    homing: {order: 1, method: 21, fast: 90 deg/s, slow: 9 deg/s, acceleration: 720 deg/s^2, position: -185 "
    "deg}\n";
constexpr const char* kU =
    "    homing: {order: 1, method: 21, fast: 20 mm/s, slow: 2 mm/s, acceleration: 200 mm/s^2, position: -1 mm}\n";

class Homings : public testing::TestWithParam<Wrong> {};
TEST_P(Homings, that_cannot_be_right_are_one_mistake_at_its_place) { expect_one_mistake(GetParam()); }

INSTANTIATE_TEST_SUITE_P(
    Machine, Homings,
    testing::Values(
        // An axis without a reference.
        Wrong{kX, "", "X:\n    drives", Fault::MissingKey, "'homing' is missing here: axis X"},
        Wrong{kZ, "", "Z:\n    drives", Fault::MissingKey, "'homing' is missing here: axis Z"},
        Wrong{kC, "", "C:\n    drives", Fault::MissingKey, "order: 1, method: 17, fast: 36 deg/s"},
        Wrong{kU, "", "U:\n    drives", Fault::MissingKey,
              "write for example homing: {order: 1, method: 17, fast: 6 mm/s"},
        Wrong{"order: 1, method: 17", "order: 1, method: 35", "35", Fault::Inconsistent, "where the axis stands"},
        Wrong{"order: 0, method: 18", "order: 0, method: 34", "34", Fault::Inconsistent, "of whichever revolution"},
        // Down, into the board.
        Wrong{"drives: [{station: z}]", "drives: [{station: z, invert: true}]", "18", Fault::Inconsistent,
              "method 18 on an inverted drive looks for its switch downwards (Z is up positive): axis Z would go down "
              "towards the board, while nothing is known of where it stands; write method 17"},
        Wrong{"order: 0, method: 18", "order: 0, method: 17", "17", Fault::Inconsistent, "write method 18"},
        Wrong{"order: 0, method: 18", "order: 0, method: 21", "21", Fault::Inconsistent, "write method 19"},
        Wrong{"order: 0, method: 18", "order: 0, method: 28", "28", Fault::Inconsistent, "write method 24"},
        Wrong{"slot: 1}]", "slot: 1, invert: true}]", "21", Fault::Inconsistent, "where the lift is low"},
        // Sides that part.
        Wrong{"{station: y2}]", "{station: y2, invert: true}]", "{station: y2", Fault::Inconsistent,
              "opposite directions"},
        // Another end than the one that is found.
        Wrong{"order: 1, method: 17", "order: 1, method: 18", "-2 mm", Fault::Inconsistent,
              "finds the limit switch at the upper end of axis X, above its travel (0 mm .. 500 mm), and -2 mm is not "
              "there; write the coordinate of that switch, or method 17"},
        Wrong{"position: -2 mm", "position: 250 mm", "250 mm", Fault::Inconsistent, "or method 18"},
        Wrong{"position: -2 mm", "position: 505 mm", "505 mm", Fault::Inconsistent, "lower end"},
        Wrong{"drives: [{station: x}]", "drives: [{station: x, invert: true}]", "-2 mm", Fault::Inconsistent,
              "method 17 on an inverted drive finds the limit switch at the upper end"},
        // The right end, and the whole travel beside the machine.
        Wrong{"position: -2 mm", "position: -1000 mm", "-1000 mm", Fault::Inconsistent,
              "by `sim` this switch of axis X stands at -2 mm; called -1000 mm, the travel of X would be at 998 mm .. "
              "1498 mm, beyond the limit switches (-2 mm .. 505 mm); write position: -2 mm"},
        Wrong{"position: 1 mm", "position: 9 mm", "9 mm", Fault::Inconsistent, "-88 mm .. -8 mm"},
        Wrong{"position: -1 mm", "position: 20 mm", "20 mm", Fault::Inconsistent, "-21 mm .. 19 mm"},
        Wrong{"position: -185 deg", "position: 175 deg", "175 deg", Fault::Inconsistent, "-540 deg .. -180 deg"},
        // Faster than the axis.
        Wrong{"fast: 60 mm/s", "fast: 5000 mm/s", "5000", Fault::OutOfRange, "more than v_max of the axis, 500 mm/s"},
        Wrong{"slow: 5 mm/s", "slow: 61 mm/s", "61", Fault::Inconsistent, "faster than 60 mm/s towards it"},
        Wrong{"acceleration: 1000 mm/s^2", "acceleration: 4001 mm/s^2", "4001", Fault::OutOfRange,
              "more than a_max of the axis, 4000 mm/s^2"},
        // 60^2 / (2 * 50) = 36 mm past the switch; from 500 mm/s with 4000 mm/s^2 it would be 31.25 mm.
        Wrong{"acceleration: 1000 mm/s^2", "acceleration: 50 mm/s^2", "50 mm", Fault::Inconsistent,
              "stands 36 mm past the limit switch: farther than from v_max with a_max, and than one revolution (31.25 "
              "mm); write at least 57.6 "
              "mm"},
        // Less than the drive counts in: the STD402EC's 6099h is in rpm, 6 deg/s of C.
        Wrong{"slow: 9 deg/s", "slow: 0.1 deg/s", "0.1", Fault::OutOfRange, "STD402EC takes 0.6 deg/s"}));

TEST(Homing, each_right_one_of_an_axis_is_taken) {
  struct Right {
    const char *from, *to;
  };
  for (const Right& r :
       {Right{"order: 0, method: 18", "order: 0, method: 23"},
        // The upper switch, and the coordinate that it has there.
        Right{"1, method: 17, fast: 60 mm/s, slow: 5 mm/s, acceleration: 1000 mm/s^2, position: -2 mm",
              "1, method: 18, fast: 60 mm/s, slow: 5 mm/s, acceleration: 1000 mm/s^2, position: 505 mm"},
        Right{"fast: 60 mm/s", "fast: 250 mm/s"}, Right{"slow: 5 mm/s", "slow: 60 mm/s"},
        // A travel that leaves out a part of the axis.
        Right{"travel: [0 mm, 500 mm]", "travel: [0 mm, 250 mm]"},
        Right{"travel: [0 mm, 500 mm]", "travel: [20 mm, 500 mm]"}, Right{"position: -2 mm", "position: -1.9 mm"}}) {
    Changed file;
    file.swap(r.from, r.to, "x");
    const auto m = file.load();
    EXPECT_TRUE(m) << r.to << ": " << to_text(m.error().front());
  }
}

TEST(Homing, the_example_that_an_error_gives_is_taken) {
  for (const bool inverted : {false, true})
    for (const auto& [row, drive] :
         {std::pair{kX, "{station: x"}, {kZ, "{station: z"}, {kC, "slot: 0"}, {kU, "slot: 1"}}) {
      Changed file;
      if (inverted) file.swap(drive, std::string(drive) + ", invert: true", "x");
      file.swap(row, "    # its homing\n", "x");
      const auto without = file.load();
      ASSERT_FALSE(without);
      const std::string& says = without.error().front().message;
      const auto from = says.find("homing: {order");
      ASSERT_NE(from, std::string::npos) << says;
      file.swap("# its homing", says.substr(from), "x");
      const auto m = file.load();
      EXPECT_TRUE(m) << says << "\n" << to_text(m.error().front());
    }
}

TEST(Homing, an_inverted_axis_homes_by_the_other_method) {
  Changed file;
  file.swap("drives: [{station: z}]", "drives: [{station: z, invert: true}]", "x");
  file.swap("order: 0, method: 18", "order: 0, method: 17", "x");
  const auto m = file.load();
  EXPECT_TRUE(m) << to_text(m.error().front());
}

TEST(Homing, check_warns_of_what_surprises) {
  struct Case {
    const char *from, *to, *says;
  };
  for (const Case& c :
       {Case{"position: -2 mm", "position: -1.9 mm",
             "axis X calls its home edge -1.9 mm, and sim: axes: X has it at -2"},
        Case{"fast: 60 mm/s", "fast: 6 mm/s", "axis X takes 83 s to look for its switch"},
        Case{"slow: 5 mm/s", "slow: 0.03 mm/s", "axis X takes 68 s to look for its switch"},
        Case{"1, method: 21, fast: 90", "1, method: 35, fast: 90", "axis C homes without a switch (method 35)"},
        Case{"home_switch: -1 mm, ", "home_switch: -1 mm, home_active: above, ", "state home_active: below"},
        Case{"    v_max: 100 mm/s\n",
             "    v_max: 100 mm/s\n    homing: {order: 1, method: 17, fast: 20 mm/s, slow: 2 mm/s, acceleration: 200 "
             "mm/s^2, position: -1010 mm}\n",
             "axis F positions by itself, and the program does not home it"}}) {
    Changed file;
    file.swap(c.from, c.to, "x");
    const auto m = file.load();
    ASSERT_TRUE(m) << c.to << ": " << to_text(m.error().front());
    EXPECT_TRUE(warns(m, c.says)) << c.to;
  }
}

}  // namespace
}  // namespace gantry::config
