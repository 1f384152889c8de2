// Motion that is sound, and the same motion with one thing made wrong in it by hand.
#include "motion/path/sound.hpp"

#include <array>
#include <cmath>
#include <functional>
#include <gtest/gtest.h>

#include "motion/path/arch.hpp"
#include "motion/path/bead.hpp"
#include "tests/motion/machine.hpp"
#include "tests/motion/path/a_bead.hpp"
#include "tests/motion/path/sampled.hpp"

namespace gantry::motion {
namespace {

using test::at;
using test::machine;

/// A bead with lines, a sharp corner and a bend.
BeadMotion bead() {
  std::vector<AxisVec> points{at(100, 100), at(140, 100), at(140, 130)};
  for (int i = 1; i <= 20; ++i) points.push_back(at(130 + 10 * std::cos(i * 0.0785), 130 + 10 * std::sin(i * 0.0785)));
  return *plan_bead(machine(), test::spec_of(points, 60, 0.2));
}

TEST(Sound, is_whatever_is_planned) {
  const Limits m = machine();
  const BeadMotion b = bead();
  const auto all = std::span(b.segments);
  EXPECT_EQ(unsound(m, all, all.subspan(b.bead_begin, b.bead_end - b.bead_begin)).value_or(""), "");
  EXPECT_EQ(unsound(m, line_move(m, at(100, 100), at(180, 40))).value_or(""), "");
  EXPECT_EQ(unsound(m, arch(m, {at(100, 100), at(180, 40), 2, -20, 1, 1}).segments).value_or(""), "");
  EXPECT_EQ(unsound(m, std::array{dwell(m, at(1, 2), 0.3)}).value_or(""), "");
  EXPECT_EQ(unsound(m, {}).value_or(""), "");
}

TEST(Sound, is_nothing_that_breaks_a_promise_somewhere_in_its_middle) {
  const Limits m = machine();
  const BeadMotion b = bead();
  struct Wrong {
    const char* words;
    std::function<void(std::vector<Segment>&, std::size_t)> make;
  };
  const std::vector<Wrong> wrong{
      {"from where the one before ends", [](auto& s, auto k) { s[k].geometry.from[1] += 1e-5; }},
      {"another speed", [](auto& s, auto k) { s[k].nominal.v0 *= 1.02; }},
      {"another acceleration", [](auto& s, auto k) { s[k].nominal.a0 += 100; }},
      {"its", [](auto& s, auto k) { s[k].nominal.phases[0].duration_s *= 1.0001; }},
      {"its", [](auto& s, auto k) { s.erase(s.begin() + static_cast<std::ptrdiff_t>(k)); }},
      {"a phase of", [](auto& s, auto k) { s[k].nominal.phases[0].duration_s = NAN; }},
      {"where it is to stand", [](auto& s, auto k) { s[k].rests = true; }},
      {"does not rest", [](auto& s, auto k) { s.resize(k + 1); }},
      {"mm/s are set", [](auto& s, auto k) { s[k].v_cap /= 2; }},
  };
  for (const Wrong& each : wrong) {
    std::vector<Segment> s = b.segments;
    std::size_t k = b.bead_begin + 1;
    while (s[k].rests || s[k + 1].rests || s[k].nominal.v0 < 5 || s[k].geometry.degree != 3) ++k;
    each.make(s, k);
    const auto all = std::span(s);
    const auto why = unsound(m, all, all.subspan(b.bead_begin, std::min(s.size(), b.bead_end) - b.bead_begin));
    ASSERT_TRUE(why) << each.words;
    EXPECT_TRUE(why->find(each.words) != std::string::npos || std::string(each.words) == "its") << *why;
  }
}

/// By differences of its positions, which never show more than there is.
TEST(Sound, is_nothing_that_an_axis_cannot_follow) {
  const Limits m = machine();
  const BeadMotion b = bead();
  const test::Use use = test::limit_use(m, test::sampled(b.segments, 2.5e-4), 2.5e-4);
  for (const auto& [used, limit] :
       {std::pair{use.v, &AxisLimits::v_max}, {use.a, &AxisLimits::a_max}, {use.j, &AxisLimits::j_max}}) {
    Limits lower = m;
    for (AxisLimits& axis : lower.axis) axis.*limit *= 0.99 * used;
    const auto why = unsound(lower, b.segments);
    ASSERT_TRUE(why);
    EXPECT_NE(why->find("of its limits"), std::string::npos) << *why;
  }
}

TEST(Sound, does_not_go_back) {
  const Limits m = machine();
  Segment s = line_move(m, at(100, 100), at(110, 100)).front();
  s.nominal = {0, 0, {}};
  for (const auto& [seconds, jerk] :
       {std::pair{0.1, 1000.0}, {0.2, -1000.0}, {0.1, 1000.0}, {0.1, -1000.0}, {0.2, 1000.0}, {0.1, -1000.0}})
    s.nominal.phases.push_back({seconds, jerk});  // 1 mm on, and back
  const auto why = unsound(m, std::array{s});
  ASSERT_TRUE(why);
  EXPECT_NE(why->find("goes back"), std::string::npos) << *why;
}

}  // namespace
}  // namespace gantry::motion
