#include "tests/motion/rt/trial.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <memory>
#include <random>
#include <vector>

#include "motion/geometry.hpp"
#include "motion/path/arch.hpp"
#include "motion/path/bead.hpp"
#include "motion/path/moves.hpp"
#include "motion/rt/interpolator.hpp"
#include "tests/motion/machine.hpp"
#include "tests/motion/path/sampled.hpp"

namespace gantry::motion::test {
namespace {

constexpr std::uint32_t kOpen = 1;

class Draw {
 public:
  explicit Draw(std::uint64_t seed) : random_(seed) {}
  double uniform(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random_); }
  double power(double low, double high) { return std::pow(10.0, uniform(low, high)); }
  bool chance(double p) { return uniform(0, 1) < p; }
  std::mt19937_64& engine() { return random_; }

 private:
  std::mt19937_64 random_;
};

/// Besides the polylines of beads: a circle or a wave of short chords.
std::vector<AxisVec> smooth_polyline(Draw& draw) {
  std::vector<AxisVec> out;
  const double r = draw.power(0.5, 1.5), chord = draw.power(-1, 0.3), cx = draw.uniform(200, 400),
               cy = draw.uniform(180, 320);
  const bool wave = draw.chance(0.5);
  const int n = std::clamp(static_cast<int>((wave ? 3 : 4) * r / chord), 8, 400);
  const double turn = draw.uniform(1, 6.3), start = draw.uniform(0, 6.3);
  for (int k = 0; k <= n; ++k) {
    const double t = turn * k / n;
    AxisVec q{};
    q[0] = wave ? cx - 60 + 20 * t : cx + r * std::cos(start + t);
    q[1] = wave ? cy + 0.3 * r * std::sin(3 * t + start) : cy + r * std::sin(start + t);
    q[2] = -50, q[4] = 12;
    out.push_back(q);
  }
  return out;
}

/// Travel as between features: up, across and down as one motion.
std::vector<Segment> over_to(const Limits& m, Draw& draw, const AxisVec& from, const AxisVec& to) {
  ArchSpec spec{.from = from, .to = to, .up = 2, .top = std::max(from[2], to[2]) + draw.power(-0.5, 1)};
  spec.top = std::min(spec.top, m.axis[2].p_max);
  spec.leave_mm = draw.uniform(0.3, 0.8) * (spec.top - from[2]);
  spec.arrive_mm = draw.uniform(0.3, 0.8) * (spec.top - to[2]);
  return arch(m, spec).segments;
}

std::vector<Segment> block_of(const Limits& m, Draw& draw, const AxisVec& from) {
  std::vector<Segment> out;
  AxisVec q = from;
  const auto add = [&](const std::vector<Segment>& more) { out.insert(out.end(), more.begin(), more.end()); };
  const int features = draw.chance(0.7) ? 1 : 2;
  for (int f = 0; f < features; ++f) {
    BeadSpec spec;
    spec.points = draw.chance(0.35) ? smooth_polyline(draw) : random_polyline(draw.engine());
    spec.speed_mm_s = draw.power(0.7, 2.6);
    spec.corner_tolerance_mm = draw.chance(0.15) ? 0 : draw.power(-2, 0);
    spec.valve = kOpen;
    spec.open_lead_s = draw.uniform(0, 0.03), spec.close_lead_s = draw.uniform(0, 0.03);
    spec.feature = static_cast<std::uint32_t>(f);
    const auto bead = plan_bead(m, spec);
    if (!bead) continue;
    add(draw.chance(0.5) ? line_move(m, q, bead->start) : over_to(m, draw, q, bead->start));
    add(bead->segments);
    q = bead->end;
    for (int dots = draw.chance(0.4) ? 3 : 0; dots > 0; --dots) {
      AxisVec dot = q;
      dot[0] += draw.uniform(-1, 1) * draw.power(0, 2), dot[1] += draw.uniform(-1, 1) * draw.power(0, 2);
      dot[2] += draw.uniform(-0.1, 0.1);
      add(over_to(m, draw, q, dot));
      out.push_back(dwell(m, q = dot, 0.02));
    }
  }
  AxisVec up = q;
  up[2] = -5;
  add(line_move(m, q, up));
  for (Segment& s : out) s.block = 1;
  if (!out.empty()) out.back().ends_block = true;
  return out;
}

/// The undisturbed path as a fine polyline, and where on it the tool has come to.
class Undisturbed {
 public:
  explicit Undisturbed(const std::vector<Segment>& block) : q_(sampled(block, 1e-4)) {
    q_.push_back(point(block.back().geometry, block.back().geometry.length));
    q_.erase(std::unique(q_.begin(), q_.end()), q_.end());  // a dwell is one place
  }

  /// Distance of q to the path; goes on along it as long as it comes nearer. A step back is told.
  double follow(const AxisVec& q, bool& back) {
    std::size_t best = at_;
    double on = 0, least = off(q, at_, on);
    const double before = on_;
    std::size_t tried = 0;
    for (std::size_t k = at_ + 1; k + 1 < q_.size() && tried < 120; ++k) {
      double there = 0;
      const double d = off(q, k, there);
      tried = d < least - 1e-12 ? 0 : tried + 1;
      if (d < least - 1e-12) least = d, best = k, on = there;
    }
    back = best == at_ && on < before - 1e-7;
    for (std::size_t k = at_ + 1; back && k + 1 < std::min(q_.size(), at_ + 120); ++k)  // the path itself comes back
      if (off(q, k, on) < 1e-10) best = k, back = false;
    at_ = best, on_ = on;
    return least;
  }

  /// How far the path goes on straight from here in the direction `d` (X Y Z); looks no farther than `enough`.
  [[nodiscard]] double straight_ahead(const AxisVec& q, const AxisVec& d, double enough) const {
    double reached = 0;
    for (std::size_t k = at_ + 1; k < q_.size() && reached < enough; ++k) {
      double on = 0, aside = 0;
      for (std::size_t i = 0; i < 3; ++i) on += (q_[k][i] - q[i]) * d[i];
      for (std::size_t i = 0; i < 5; ++i) aside = std::max(aside, std::abs(q_[k][i] - q[i] - on * d[i]));
      // A gentle curve is as near to a line over some hundredths of a mm as 1e-8, at an inflection as 1e-10; a line is
      // but for rounding.
      if (aside > 2e-12 || on < reached - 1e-9) break;
      reached = on;
    }
    return reached;
  }

 private:
  double off(const AxisVec& q, std::size_t k, double& on) const {
    double ab = 0, aq = 0, sum = 0;
    for (std::size_t i = 0; i < 5; ++i) {
      const double x = q_[k + 1][i] - q_[k][i];
      ab += x * x, aq += (q[i] - q_[k][i]) * x;
    }
    const double t = ab > 0 ? std::clamp(aq / ab, 0.0, 1.0) : 0;
    for (std::size_t i = 0; i < 5; ++i) sum += std::pow(q[i] - q_[k][i] - t * (q_[k + 1][i] - q_[k][i]), 2);
    on = t * std::sqrt(ab);
    return std::sqrt(sum);
  }

  std::vector<AxisVec> q_;
  std::size_t at_ = 0;
  double on_ = 0;
};

/// The textbook's shortest stop from speed v and acceleration a: the acceleration to 0, then an S-curve; what has been
/// braked already is its beginning.
double ideal_stop(double v, double a, double a_max, double j) {
  const double peak = v + a * std::abs(a) / (2 * j) * (a > 0 ? 1 : -1);  // speed of the S-curve's beginning
  const double t = peak * j <= a_max * a_max ? 2 * std::sqrt(peak / j) : peak / a_max + a_max / j;
  const double whole = peak / 2 * t, t0 = std::abs(a) / j;
  if (a > 0) return v * t0 + a * t0 * t0 / 3 + whole;
  return whole - (peak * t0 - j * t0 * t0 * t0 / 6);
}

double cpu_us() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return 1e6 * static_cast<double>(t.tv_sec) + 1e-3 * static_cast<double>(t.tv_nsec);
}

/// Limits of the path's direction d.
double along(const Limits& m, const AxisVec& d, double AxisLimits::*limit) {
  double least = HUGE_VAL;
  for (std::size_t i = 0; i < m.axes; ++i)
    if (std::abs(d[i]) > 1e-9) least = std::min(least, m.axis[i].*limit / std::abs(d[i]));
  return least;
}

}  // namespace

Verdict trial(std::uint64_t seed) {
  Verdict out;
  Draw draw(seed);
  const Limits m = machine();
  const AxisVec home{200, 200, -5, 0, 12};
  const std::vector<Segment> block = block_of(m, draw, home);
  if (block.empty()) return out;
  Undisturbed path(block);
  auto ring = std::make_unique<SegmentRing>();
  auto play = std::make_unique<Interpolator>(*ring, m, kOpen);
  play->start(home);
  play->begin_block(1);
  std::size_t pushed = 0;
  std::vector<AxisVec> stream(4, home);
  const double restless = draw.power(-3.3, -1.3);
  const bool aborts = draw.chance(0.15);
  double factor = draw.chance(0.7) ? 1 : draw.uniform(0.1, 2);
  bool held = false, back = false;
  std::size_t stop_began = 0, wait = 0;
  double ideal = 0;  // of a stop on a line that is under way
  AxisVec stop_from{};
  std::string stop_text;
  Setpoint x;
  const auto tell = [&](const std::string& what) {
    if (out.wrong.empty()) out.wrong = what + " at tick " + std::to_string(stream.size() - 4);
  };
  const auto stop = [&](bool abort) {
    if (!held) {
      ++out.stops;
      stop_began = stream.size();
      stop_from = x.q;
      double v = 0, a = 0;
      AxisVec d{};
      for (std::size_t i = 0; i < 3; ++i) v += x.v[i] * x.v[i];
      v = std::sqrt(v);
      ideal = 0;
      if (v > 1e-3) {
        for (std::size_t i = 0; i < m.axes; ++i) d[i] = x.v[i] / v;
        for (std::size_t i = 0; i < 3; ++i) a += x.a[i] * d[i];
        const double braking = ideal_stop(v, a, along(m, d, &AxisLimits::a_max), along(m, d, &AxisLimits::j_max));
        stop_text = " from " + std::to_string(v) + " mm/s, " + std::to_string(a) + " mm/s2";
        // The beginning of a curve looks straight over a short distance.
        const double enough = 1.1 * braking + 0.05;
        if (braking > 0 && path.straight_ahead(x.q, d, enough) >= enough) ideal = braking;
      }
    }
    held = true;
    abort ? play->abort() : play->hold();
  };
  while (!play->idle() && stream.size() < 200000) {
    while (pushed < block.size() && ring->push(block[pushed])) ++pushed;
    if (!held && draw.chance(restless)) {
      if (draw.chance(0.5))
        stop(aborts && draw.chance(0.3));
      else
        factor = draw.chance(0.3) ? 1 : draw.power(-2, 0.3), ++out.changes;
    } else if (held && x.block != 0 && !x.moving && ++wait > 3 && draw.chance(0.05)) {
      play->resume();
      held = false, wait = 0;
      ++out.changes;
    } else if (held && draw.chance(0.2 * restless)) {
      play->resume();  // in the middle of braking
      held = play->held();
      ideal = 0;
    }
    const double begin = cpu_us();
    x = play->step(factor);
    out.worst_tick_us = std::max(out.worst_tick_us, cpu_us() - begin);
    stream.push_back(x.q);
    if (x.off_path) tell("the path was lost");
    const double off = path.follow(x.q, back);
    out.off_mm = std::max(out.off_mm, off);
    if (off > 1e-3) tell("off the path by " + std::to_string(off));
    if (back) tell("backwards");
    if (held && (x.outputs & kOpen) != 0) tell("open while held");
    if (held && !x.moving && stop_began != 0) {
      out.stop_s = std::max(out.stop_s, static_cast<double>(stream.size() - stop_began) * m.tick_s);
      if (ideal > 1e-3) {
        double braked = 0;
        for (std::size_t i = 0; i < 3; ++i) braked += std::pow(x.q[i] - stop_from[i], 2);
        braked = std::sqrt(braked);
        ++out.line_stops;
        out.stop_share = std::max(out.stop_share, braked / ideal);
        if (braked > 1.02 * ideal + 1e-6)
          tell("a stop of " + std::to_string(braked) + " mm instead of " + std::to_string(ideal) + stop_text);
      }
      stop_began = 0, ideal = 0;
    }
  }
  if (!play->idle()) tell("never ended");
  stream.insert(stream.end(), 4, stream.back());
  out.ticks = stream.size();
  const Use use = limit_use(m, stream, m.tick_s);
  out.v = use.v, out.a = use.a, out.j = use.j;
  char text[120];
  std::snprintf(text, sizeof text, "limits: v %.4f a %.4f j %.4f", use.v, use.a, use.j);
  if (std::max({use.v, use.a, use.j}) > 1.001) tell(text);
  return out;
}

}  // namespace gantry::motion::test
