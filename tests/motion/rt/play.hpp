// A player for interpolator tests: feeds segments, steps, keeps the stream, and judges it.
#pragma once
#include <gtest/gtest.h>
#include <memory>
#include <vector>

#include "motion/geometry.hpp"
#include "motion/path/arch.hpp"
#include "motion/path/bead.hpp"
#include "motion/path/moves.hpp"
#include "motion/rt/interpolator.hpp"
#include "tests/motion/machine.hpp"
#include "tests/motion/path/sampled.hpp"

namespace gantry::motion::test {

inline constexpr std::uint32_t kValve = 1, kLamp = 2;

/// Segments of a block as a job has them: to the bead, the bead, a lift, a dot with a dwell.
inline std::vector<Segment> random_block(const Limits& m, std::mt19937_64& random, AxisVec& q, std::uint32_t number) {
  const auto uniform = [&](double lo, double hi) { return std::uniform_real_distribution<double>(lo, hi)(random); };
  std::vector<Segment> out;
  const auto add = [&](const std::vector<Segment>& more) { out.insert(out.end(), more.begin(), more.end()); };
  const int features = 1 + static_cast<int>(uniform(0, 2.99));
  for (int f = 0; f < features; ++f) {
    if (uniform(0, 1) < 0.3) {  // a dot
      AxisVec dot = q;
      dot[0] = uniform(100, 500), dot[1] = uniform(100, 400), dot[2] = -40;
      if (uniform(0, 1) < 0.5) {
        add(line_move(m, q, dot));
      } else {  // as between features
        const double top = std::max(q[2], dot[2]) + uniform(0.5, 4);
        add(arch(m, {q, dot, 2, top, 0.5 * (top - q[2]), 0.5 * (top - dot[2])}).segments);
      }
      const double t = std::ceil(uniform(0.01, 0.05) / m.tick_s) * m.tick_s;
      const OutputEvent events[] = {{0.005, 0.002, kValve, kValve, true}, {t, 0.001, kValve, 0, false}};
      out.push_back(dwell(m, dot, t, events));
      q = dot;
      continue;
    }
    BeadSpec spec;
    spec.points = random_polyline(random);
    spec.speed_mm_s = std::pow(10.0, uniform(1, 2.3));
    spec.corner_tolerance_mm = uniform(0, 1) < 0.25 ? 0 : std::pow(10.0, uniform(-2, 0.3));
    spec.valve = kValve;
    spec.open_lead_s = uniform(0, 0.03);
    spec.close_lead_s = uniform(0, 0.03);
    spec.feature = static_cast<std::uint32_t>(f);
    const auto bead = plan_bead(m, spec);
    if (!bead) continue;
    add(line_move(m, q, bead->start));
    add(bead->segments);
    q = bead->end;
  }
  AxisVec up = q;
  up[2] = -5;
  add(line_move(m, q, up));
  q = up;
  if (out.empty()) return random_block(m, random, q, number);
  for (Segment& s : out) s.block = number;
  out.back().ends_block = true;
  return out;
}

/// The n-th of a pool of such blocks, all from `home`; q becomes where it ends. Planning them anew for each case would
/// take longer than playing them.
inline std::vector<Segment> pooled_block(const Limits& m, const AxisVec& home, int n, AxisVec& q,
                                         std::uint32_t number) {
  constexpr std::size_t kPool = 120;
  struct Block {
    std::vector<Segment> segments;
    AxisVec end{};
  };
  static std::vector<Block> pool;
  static std::mt19937_64 random(41);
  const std::size_t k = static_cast<std::size_t>(n) % kPool;
  while (pool.size() <= k) {
    AxisVec end = home;
    std::vector<Segment> segments = random_block(m, random, end, 1);
    pool.push_back({std::move(segments), end});
  }
  std::vector<Segment> out = pool[k].segments;
  for (Segment& s : out) s.block = number;
  q = pool[k].end;
  return out;
}

class Player {
 public:
  explicit Player(const Limits& limits, const AxisVec& q)
      : m(limits), ring(std::make_unique<SegmentRing>()), play(*ring, limits, kValve) {
    play.start(q);
    stream.assign(4, q);
  }

  void push(const std::vector<Segment>& more) {
    for (const Segment& s : more) push(s);
  }
  void push(const Segment& s) {
    ASSERT_TRUE(ring->push(s));
    path.push_back(s);
  }
  Setpoint step(double override_factor = 1) {
    last = play.step(override_factor);
    stream.push_back(last.q);
    return last;
  }

  /// Every axis within its limits over all that was played. 1 = at the limit.
  [[nodiscard]] Use use() const { return limit_use(m, stream, m.tick_s); }

  /// The tool is where the path is at the reported s, on a segment not before the last one.
  void expect_on_path(const std::string& what) {
    for (std::size_t k = on; k < path.size(); ++k) {
      if (last.s > path[k].geometry.length + 1e-9) continue;
      const AxisVec q = point(path[k].geometry, last.s);
      double off = 0;
      for (std::size_t i = 0; i < m.axes; ++i) off = std::max(off, std::abs(q[i] - last.q[i]));
      if (off < 1e-9) {
        on = k;
        return;
      }
    }
    FAIL() << "off the path at tick " << last.tick_in_block << what;
  }

  Limits m;
  std::unique_ptr<SegmentRing> ring;
  Interpolator play;
  std::vector<AxisVec> stream;
  std::vector<Segment> path;
  std::size_t on = 0;
  Setpoint last;
};

/// Plans keep 1.001 (docs/motion/path.md). Round a corner that nearly turns back, the acceleration between the nodes of
/// the plan is up to 2e-5 more than at them.
inline void expect_within(const Use& use, const std::string& what) {
  ASSERT_LE(use.v, 1 + 1e-6) << what;
  ASSERT_LE(use.a, 1 + 1e-4) << what;
  ASSERT_LE(use.j, 1 + 1e-4) << what;
}

}  // namespace gantry::motion::test
