// Stops on curves: how soon they begin, and how far they go.
#include <cmath>
#include <gtest/gtest.h>
#include <numbers>
#include <stdexcept>
#include <tuple>
#include <utility>

#include "tests/motion/rt/play.hpp"

namespace gantry::motion {
namespace {

using test::expect_within;
using test::kValve;
using test::machine;
using test::Player;

/// Round (300, y), in so many chords.
std::vector<AxisVec> circle(double radius_mm, double y, int chords) {
  std::vector<AxisVec> points;
  for (int k = 0; k <= chords; ++k) {
    const double turn = 2 * std::numbers::pi * k / chords;
    points.push_back({300 + radius_mm * std::cos(turn), y + radius_mm * std::sin(turn), -40, 0, 12});
  }
  return points;
}

/// As block 1.
BeadMotion planned(const Limits& m, std::vector<AxisVec> points, double speed_mm_s, double tolerance_mm) {
  BeadSpec spec;
  spec.points = std::move(points);
  spec.speed_mm_s = speed_mm_s, spec.corner_tolerance_mm = tolerance_mm, spec.valve = kValve, spec.block = 1;
  auto bead = plan_bead(m, spec);
  if (!bead) throw std::runtime_error(to_text(bead.error()));
  bead->segments.back().ends_block = true;
  return *std::move(bead);
}

/// Plays a bead from its start for so many ticks, and then as one steps it.
class Played : public Player {
 public:
  Played(const Limits& limits, const BeadMotion& bead, int ticks) : Player(limits, bead.start), bead_(bead) {
    feed();
    play.begin_block(1);
    for (int k = 0; k < ticks; ++k) step();
  }
  void step() { Player::step(), feed(); }

 private:
  void feed() {
    while (fed_ < bead_.segments.size() && ring->push(bead_.segments[fed_])) path.push_back(bead_.segments[fed_++]);
  }

  const BeadMotion& bead_;
  std::size_t fed_ = 0;
};

// While a run-up bends into its bead there are moments from which only a weak stop is possible: a harder one is taken
// up as soon as there is one. The judge: the stop of a line from the same speed, speeding up as hard as it may.
TEST(Stop, a_stop_in_a_run_up_that_bends_goes_no_farther_than_twice_that_of_a_line) {
  const Limits m = machine();
  const Bounds weaker{m.axis[1].v_max, m.axis[1].a_max, m.axis[1].j_max};
  double farthest = 0;
  for (const double speed : {40.0, 60.0, 90.0, 130.0}) {
    // The jerk of a circle leaves room to brake.
    const double radius = std::max(5.0, 1.5 * std::sqrt(speed * speed * speed / weaker.j));
    const BeadMotion bead = planned(m, circle(radius, 200, 128), speed, 0.02);
    const int ticks = static_cast<int>(duration(bead.segments) / m.tick_s);
    for (int at = 3; at < ticks; ++at) {
      Played p(m, bead, at);
      const auto gone_mm = [&](std::size_t ago) {
        const AxisVec &x = p.stream[p.stream.size() - ago - 1], &y = p.stream[p.stream.size() - ago - 2];
        return std::hypot(x[0] - y[0], x[1] - y[1]);
      };
      const double v = gone_mm(0) / m.tick_s, a = (gone_mm(0) - gone_mm(1)) / m.tick_s / m.tick_s;
      if (v < 5) continue;
      const double line_mm = end_state(stop({0, v, std::clamp(a, 0.0, weaker.a)}, weaker).profile).p;
      p.play.hold();
      double mm = 0;
      for (int n = 0; n < 2000 && !p.play.at_rest(); ++n) p.step(), mm += gone_mm(0);
      ASSERT_TRUE(p.play.at_rest());
      farthest = std::max(farthest, mm / line_mm);
      ASSERT_LE(mm, 2 * line_mm) << speed << " mm/s, tick " << at;
    }
  }
  EXPECT_GT(farthest, 1);
}

// Where the plan brakes into a corner that its tolerance rounds there is little room to brake otherwise. Who orders a
// stop earlier has it earlier.
TEST(Stop, a_stop_before_a_corner_does_not_wait_until_it_is_passed) {
  const Limits m = machine();
  for (const auto& [speed, tolerance] :
       {std::pair{60.0, 0.1}, {90.0, 0.3}, {140.0, 0.05}, {140.0, 0.3}, {190.0, 0.5}}) {
    std::vector<AxisVec> points;
    for (const auto& [x, y] : {std::pair{220.0, 220.0}, {255.0, 222.0}, {254.0, 255.0}, {295.0, 260.0}})
      points.push_back({x, y, -40, 0, 12});
    const BeadMotion bead = planned(m, points, speed, tolerance);
    const int ticks = static_cast<int>(duration(bead.segments) / m.tick_s);
    std::vector<int> rests;
    for (int at = 3; at < ticks; ++at) {
      Played p(m, bead, at);
      p.play.hold();
      int k = at;
      for (; k < at + 2000 && !p.play.at_rest(); ++k) p.step();
      ASSERT_TRUE(p.play.at_rest());
      rests.push_back(k);
    }
    int soonest = rests.back();
    for (std::size_t n = rests.size(); n-- > 0;) {
      EXPECT_LE(rests[n] - soonest, 15) << speed << " mm/s, " << tolerance << " mm, tick " << n + 3;
      soonest = std::min(soonest, rests[n]);
    }
  }
}

// Axes so slow, or cycles so short, that a stop takes many of them: at 80 mm/s/s longer than a change that is played
// ahead may be.
TEST(Stop, a_stop_that_takes_long_begins_at_once_too) {
  for (const auto& [a, j, speed, tick_s, allowed] : {std::tuple{250.0, 2500.0, 90.0, 0.001, 1.5},
                                                     {80.0, 800.0, 80.0, 0.001, 2.0},
                                                     {2500.0, 40000.0, 300.0, 0.00025, 1.5}}) {
    Limits m = machine();
    m.tick_s = tick_s;
    for (std::size_t i : {0u, 1u}) m.axis[i].a_max = a, m.axis[i].j_max = j;
    const BeadMotion bead = planned(m, circle(1.1 * speed * speed / a, 250, 256), speed, 0.02);
    const Bounds b{1e3, a, j};
    const double line_s = duration(stop({0, speed, 0}, b).profile);
    const int ticks = static_cast<int>(duration(bead.segments) / m.tick_s);
    for (int at = ticks / 3; at < ticks / 2; at += ticks / 10) {
      Played p(m, bead, at);
      p.play.hold();
      int n = 0;
      while (!p.play.at_rest() && n < 20000) p.step(), ++n;
      EXPECT_LE(n * m.tick_s, allowed * line_s) << a << " mm/s^2, tick " << at;
      expect_within(p.use(), "");
    }
  }
}

// Where no stop can begin, as where one takes more than the cycles that are played ahead, the rate is lowered first, by
// whichever way is possible there.
TEST(Stop, where_none_can_begin_the_rate_is_lowered_by_whichever_way_is_possible) {
  for (const auto& [a, j, speed, tick_s] :
       {std::tuple{80.0, 400.0, 80.0, 0.001}, {20.0, 200.0, 40.0, 0.001}, {1500.0, 20000.0, 400.0, 0.00025}}) {
    Limits m = machine();
    m.tick_s = tick_s;
    for (std::size_t i : {0u, 1u}) m.axis[i].a_max = a, m.axis[i].j_max = j;
    const std::vector<AxisVec> sharp{{220, 220, -40, 0, 12}, {420, 222, -40, 0, 12}, {419, 380, -40, 0, 12}};
    for (const auto& points : {circle(1.02 * speed * speed / a, 250, 256), sharp}) {
      const BeadMotion bead = planned(m, points, speed, 0.3);
      const double line_s = duration(stop({0, speed, 0}, {1e3, a, j}).profile);
      const int ticks = static_cast<int>(duration(bead.segments) / m.tick_s);
      for (int at = 20; at < ticks; at += ticks / 7) {
        Played p(m, bead, at);
        p.play.hold();
        int n = 0;
        while (!p.play.at_rest() && n < 40000) p.step(), ++n;
        EXPECT_LE(n * m.tick_s, 2.6 * line_s) << a << " mm/s^2, " << points.size() << " points, tick " << at;
        expect_within(p.use(), "");
      }
    }
  }
}

// A path that comes too slowly is braked on, while what a stop needs is still known: on slow axes that is more.
TEST(Stop, a_path_that_runs_dry_is_braked_on_by_slow_axes_too) {
  for (const auto& [a, j, speed] : {std::tuple{250.0, 2500.0, 90.0}, {80.0, 400.0, 80.0}, {20.0, 200.0, 40.0}}) {
    Limits m = machine();
    for (std::size_t i : {0u, 1u}) m.axis[i].a_max = a, m.axis[i].j_max = j;
    BeadMotion bead = planned(m, circle(1.3 * speed * speed / a, 250, 256), speed, 0.02);
    bead.segments.resize(bead.segments.size() * 3 / 4);
    Played p(m, bead, 1);
    for (int n = 0; n < 40000 && !(p.play.at_rest() && p.play.starving() && n > 10); ++n) {
      p.step();
      ASSERT_FALSE(p.last.off_path) << a << " mm/s^2, tick " << n;
    }
    EXPECT_TRUE(p.play.starving());
    p.expect_on_path("");
    expect_within(p.use(), "");
  }
}

}  // namespace
}  // namespace gantry::motion
