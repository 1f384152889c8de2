// The speeds that the lookahead allows at the ends of the segments that are known.
#include "motion/rt/lookahead.hpp"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <memory>
#include <vector>

namespace gantry::motion {
namespace {

Segment line(double length, double v_cap, double v_exit, std::uint32_t block = 1) {
  Segment s;
  s.block = block;
  s.geometry.length = length;
  s.geometry.degree = 1;
  s.v_cap = v_cap;
  s.v_max = 300, s.a_max = 4000, s.j_max = 80'000;
  s.v_exit = v_exit;
  return s;
}

struct Ahead {
  std::unique_ptr<SegmentRing> ring = std::make_unique<SegmentRing>();
  Lookahead ahead{*ring};
  explicit Ahead(const std::vector<Segment>& segments, double override_factor = 1) {
    for (const Segment& s : segments) EXPECT_TRUE(ring->push(s));
    ahead.update(1, override_factor);
  }
  [[nodiscard]] double v(std::size_t i) const { return ahead.v_end(i); }
};

TEST(Lookahead, the_end_of_what_is_known_is_a_standstill) {
  EXPECT_EQ(Ahead({}).v(0), 0);
  EXPECT_EQ(Ahead({line(100, 50, 50)}).v(0), 0) << "more may come, but is not there";
  const Ahead two({line(100, 50, 50), line(100, 50, 50)});
  EXPECT_EQ(two.v(0), 50);
  EXPECT_EQ(two.v(1), 0);
  EXPECT_EQ(two.v(2), 0);
}

TEST(Lookahead, another_block_a_dwell_and_a_rest_by_plan_end_what_is_known) {
  EXPECT_EQ(Ahead({line(100, 50, 50), line(100, 50, 50, 2)}).v(0), 0);
  Segment dwell = line(1, 1, 0);
  dwell.kind = SegmentKind::Dwell;
  EXPECT_EQ(Ahead({line(100, 50, 50), dwell, line(100, 50, 50)}).v(0), 0);
  EXPECT_EQ(Ahead({line(100, 50, 0), line(100, 50, 50)}).v(0), 0) << "a corner";
  Segment last = line(100, 50, 50);
  last.ends_block = true;
  EXPECT_EQ(Ahead({last, line(100, 50, 50)}).v(0), 0);
}

TEST(Lookahead, beyond_its_window_the_path_counts_as_unknown) {
  const std::vector<Segment> many(Lookahead::kWindow + 50, line(0.01, 300, 300));
  const Ahead ahead(many);
  EXPECT_EQ(ahead.v(Lookahead::kWindow - 1), 0);
  EXPECT_EQ(ahead.v(Lookahead::kWindow + 3), 0);
  EXPECT_GT(ahead.v(0), 0);
}

TEST(Lookahead, override_raises_up_to_the_axis_limits_and_never_a_touch) {
  EXPECT_EQ(Ahead({line(100, 50, 50), line(100, 50, 50)}, 2).v(0), 100);
  EXPECT_EQ(Ahead({line(100, 200, 200), line(100, 200, 200)}, 2).v(0), 300);
  EXPECT_EQ(Ahead({line(100, 50, 50), line(100, 50, 50)}, 0.5).v(0), 25);
  Segment touch = line(10, 4, 0);
  touch.kind = SegmentKind::UntilProbe;
  EXPECT_EQ(bounds_of(touch, 2).v, 4);
  EXPECT_EQ(bounds_of(touch, 0.5).v, 2);
}

}  // namespace
}  // namespace gantry::motion
