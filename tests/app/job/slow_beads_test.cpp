// What a bead that is planned too slow is told to change: what it has.
#include "app/job/slow_beads.hpp"

#include <gtest/gtest.h>

namespace gantry::job {
namespace {

recipes::Recipe recipe() {
  return recipes::
      parse("version: 1\nrecipe: r\nplacement: fixture\nboard: {size: [90 mm, 60 mm], thickness: 8 mm, frame: pallet}\n"
            "materials:\n  a: {speed: 100 mm/s, gap: 0.3 mm, valve_open_lead: 8 ms, valve_close_lead: 6 ms, "
            "dot_time: 60 ms, retract: 3 mm}\nfeatures:\n"
            "  - line: {name: straight, material: a, from: [10 mm, 10 mm], to: [14 mm, 13 mm]}\n"
            "  - polyline: {name: zig, material: a, points: [[20 mm, 10 mm], [23 mm, 13 mm], [26 mm, 10 mm]]}\n"
            "  - circle: {name: ring, material: a, centre: [40 mm, 30 mm], radius: 3 mm}\n",
            "r.yaml")
          .value();
}

bool says(const std::string& text, const char* piece) { return text.find(piece) != std::string::npos; }

TEST(SlowBeads, a_straight_line_has_no_corner_to_round) {
  const auto r = recipe();
  const std::string never = in_words({.feature = 0, .asked_mm_s = 100, .fastest_mm_s = 60, .at_speed = 0.2}, r),
                    steady = in_words({.feature = 0, .asked_mm_s = 100, .steady_mm_s = 70.77, .fastest_mm_s = 71}, r);
  for (const std::string& text : {never, steady}) EXPECT_FALSE(says(text, "corner")) << text;
  EXPECT_TRUE(says(never, "the 5 mm of it are too short")) << never;
  EXPECT_TRUE(says(never, "a lower `speed`")) << never;
  EXPECT_TRUE(says(steady, "`speed: 70.7 mm/s`")) << steady;
  EXPECT_TRUE(says(steady, "flow_follows_speed")) << steady;
}

TEST(SlowBeads, corners_and_curves_are_told_what_would_help) {
  const auto r = recipe();
  EXPECT_TRUE(says(in_words({.feature = 1, .asked_mm_s = 100, .at_speed = 0.2}, r), "larger `corner_tolerance`"));
  EXPECT_TRUE(says(in_words({.feature = 1, .asked_mm_s = 100, .steady_mm_s = 60}, r), "larger `corner_tolerance`"));
  EXPECT_TRUE(says(in_words({.feature = 2, .asked_mm_s = 100, .steady_mm_s = 88}, r), "a larger radius"));
  EXPECT_TRUE(says(in_words({.feature = 2, .asked_mm_s = 100, .steady_mm_s = 0.5}, r), "`speed: 0.5 mm/s`"))
      << "never 0";
}

}  // namespace
}  // namespace gantry::job
