#include "motion/path/run.hpp"

#include <algorithm>
#include <cmath>

#include "motion/geometry.hpp"
#include "motion/profile/line_bounds.hpp"

namespace gantry::motion {
namespace {

AxisVec direction_of(const Curve& line) {
  AxisVec d = line.c[1];
  for (double& x : d) x /= line.length;
  return d;
}

bool goes_on(const Curve& a, const Curve& b) {
  if (!a.straight || !b.straight || a.rest_after) return false;
  const AxisVec x = direction_of(a), y = direction_of(b);
  for (std::size_t i = 0; i < kMaxAxes; ++i)
    if (std::abs(x[i] - y[i]) > 1e-9) return false;
  return true;
}

/// A cubic that runs along its chord, as a spline does between bends, as the line that it is; s stays what it was.
Curve line_if_straight(const Curve& curve) {
  constexpr double kBend = 1e-8;  // of the chord's square: a curvature that no axis shows
  if (curve.straight) return curve;
  AxisVec chord{};
  double square = 0;
  for (std::size_t i = 0; i < kMaxAxes; ++i) {
    chord[i] = curve.c[1][i] + curve.c[2][i] + curve.c[3][i];
    square += chord[i] * chord[i];
  }
  for (std::size_t k = 1; k <= 3; ++k) {
    double on = 0;
    for (std::size_t i = 0; i < kMaxAxes; ++i) on += curve.c[k][i] * chord[i] / square;
    for (std::size_t i = 0; i < kMaxAxes; ++i)
      if (std::abs(curve.c[k][i] - on * chord[i]) > kBend * square) return curve;
  }
  Curve line = curve;
  line.straight = true;
  line.c[1] = chord, line.c[2] = line.c[3] = AxisVec{};
  line.u = {0, 1, 0, 0, 0, 0};
  return line;
}

/// The speed never falls below 0 and never rises above v, but for rounding.
bool between(const Profile& profile, double v) {
  State x = profile.from;
  const double slack = 1e-9 * v;
  const auto fits = [&](double speed) { return speed >= -slack && speed <= v + slack; };
  for (const Phase& phase : profile.phases) {
    const double turn = phase.jerk != 0 ? -x.a / phase.jerk : 0;  // where the speed is highest or lowest
    if (turn > 0 && turn < phase.duration_s && !fits(advanced(x, phase.jerk, turn).v)) return false;
    x = advanced(x, phase.jerk, phase.duration_s);
    if (!fits(x.v)) return false;
  }
  return true;
}

/// From (v0, a0) to (v1, a1) over the run; false, and nothing changed, where that is not a motion forward.
bool shortest(Run& run, const State& from, const State& to, const Bounds& bounds) {
  const Plan plan = move({0, from.v, from.a}, {run.curve.length, to.v, to.a}, bounds);
  if (!plan || std::abs(end_state(plan.profile).p - run.curve.length) > 1e-9 || !between(plan.profile, bounds.v))
    return false;
  run.v0 = from.v, run.a0 = from.a, run.v1 = to.v, run.a1 = to.a;
  run.phases.assign(plan.profile.phases.begin(), plan.profile.phases.end());
  return true;
}

Geometry geometry_of(const Curve& curve, double begin, double length) {
  if (curve.straight) {
    AxisVec from = curve.c[0], displacement = curve.c[1];
    for (std::size_t i = 0; i < kMaxAxes; ++i) {
      from[i] += displacement[i] * (begin / curve.length);
      displacement[i] *= length / curve.length;
    }
    return straight(from, displacement, length);
  }
  Geometry g;
  g.length = length, g.begin = begin, g.whole = curve.length;
  g.degree = 3;
  g.from = curve.c[0];
  std::copy(curve.u.begin() + 1, curve.u.end(), g.u.begin());
  std::size_t n = 0;
  for (std::size_t i = 0; i < kMaxAxes; ++i) {
    if (curve.c[1][i] == 0 && curve.c[2][i] == 0 && curve.c[3][i] == 0) continue;
    g.moving = static_cast<std::uint16_t>(g.moving | 1u << i);
    for (std::size_t k = 1; k <= 3; ++k) g.c[n++] = curve.c[k][i];
  }
  return g;
}

}  // namespace

double duration(std::span<const Run> runs) {
  double sum = 0;
  for (const Run& run : runs)
    for (const Phase& phase : run.phases) sum += phase.duration_s;
  return sum;
}

std::vector<Run> runs_between(const Measure& measure, const Stretch& stretch, double from_mm, double to_mm) {
  std::vector<Run> out;
  double begin = 0;
  std::size_t piece = 0;
  for (const Curve& curve : stretch.curves) {
    Run run{line_if_straight(curve), 0, 0, {}, 0, 0};
    const double end = begin + curve.length, middle = begin + curve.length / 2;
    for (; piece < stretch.pieces.size(); ++piece) {
      const TimePiece& p = stretch.pieces[piece];
      if (after(p, p.duration_s / 2).p > end) break;
      if (run.phases.empty()) run.v0 = p.v, run.a0 = p.a;
      run.phases.push_back({p.duration_s, p.j});
      const State x = after(p, p.duration_s);
      run.v1 = x.v, run.a1 = x.a;
    }
    begin = end;
    if (middle < from_mm || middle > to_mm) continue;
    if (!out.empty() && goes_on(out.back().curve, run.curve)) {
      Run& line = out.back();
      AxisVec to = run.curve.c[0];
      for (std::size_t i = 0; i < kMaxAxes; ++i) to[i] += run.curve.c[1][i];
      const double length = line.curve.length + run.curve.length;
      line.curve = straight_curve(measure, line.curve.c[0], to);
      line.curve.length = length;
      line.curve.rest_after = curve.rest_after;
      line.phases.insert(line.phases.end(), run.phases.begin(), run.phases.end());
      line.v1 = run.v1, line.a1 = run.a1;
    } else {
      out.push_back(std::move(run));
    }
  }
  for (Run& run : out)
    if (run.curve.rest_after) run.v1 = run.a1 = 0;
  return out;
}

std::vector<Run> bent_runs(const Measure& measure, const Stretch& stretch, double from_mm, double to_mm) {
  std::vector<Run> runs = runs_between(measure, stretch, from_mm, to_mm);
  if (std::all_of(runs.begin(), runs.end(), [](const Run& r) { return r.curve.straight; })) runs.clear();
  return runs;
}

void speed_up_lines(std::vector<Run>& runs, const Limits& limits, double v_set, double entry_mm_s) {
  for (std::size_t k = 0; k < runs.size(); ++k) {
    Run& run = runs[k];
    if (!run.curve.straight) continue;
    Bounds bounds = line_bounds(limits, direction_of(run.curve));
    bounds.v = std::min(bounds.v, v_set);
    const State from{0, run.v0, run.a0}, to{0, run.v1, run.a1}, at_speed{0, bounds.v, 0};
    const State at_entry{0, std::min(bounds.v, entry_mm_s), 0};
    const bool first = k == 0, last = k + 1 == runs.size();
    if (first && last && shortest(run, at_entry, at_speed, bounds)) continue;
    if (first && shortest(run, at_entry, to, bounds)) continue;
    if (last && shortest(run, from, at_speed, bounds)) continue;
    shortest(run, from, to, bounds);
  }
}

void slow_down(std::span<Run> runs, double factor) {
  for (Run& run : runs) {
    run.v0 /= factor, run.v1 /= factor;
    run.a0 /= factor * factor, run.a1 /= factor * factor;
    for (Phase& phase : run.phases) phase.duration_s *= factor, phase.jerk /= factor * factor * factor;
  }
}

Run straight_run(const Measure& measure, const AxisVec& from, const AxisVec& direction, bool backwards,
                 const Profile& motion) {
  const State end = end_state(motion);
  AxisVec to = from;
  for (std::size_t i = 0; i < kMaxAxes; ++i) to[i] += (backwards ? -1 : 1) * end.p * direction[i];
  Run run;
  run.curve = backwards ? straight_curve(measure, to, from) : straight_curve(measure, from, to);
  run.v0 = motion.from.v, run.a0 = motion.from.a, run.v1 = end.v, run.a1 = end.a;
  run.phases.assign(motion.phases.begin(), motion.phases.end());
  return run;
}

std::size_t moving_axes(const Curve& curve) {
  std::size_t n = 0;
  for (std::size_t i = 0; i < kMaxAxes; ++i) n += curve.c[1][i] != 0 || curve.c[2][i] != 0 || curve.c[3][i] != 0;
  return n;
}

void append_segments(const Run& run, const Segment& like, std::vector<Segment>& out) {
  State x{run.begin, run.v0, run.a0};
  // In even parts: none is the standstill alone with which a run may end.
  const std::size_t count = run.phases.size(), parts = (count + kSegmentPhases - 1) / kSegmentPhases;
  for (std::size_t k = 0, part = 1; part <= parts; ++part) {
    Segment s = like;
    s.kind = SegmentKind::Piece;
    s.events.clear();
    s.nominal = {x.v, x.a, {}};
    const double begin = x.p;
    for (; k < count * part / parts && s.nominal.phases.push_back(run.phases[k]); ++k)
      x = advanced(x, run.phases[k].jerk, run.phases[k].duration_s);
    const bool last = part == parts;
    s.geometry = geometry_of(run.curve, begin, (last ? run.curve.length : x.p) - begin);
    s.rests = last && run.curve.rest_after;
    out.push_back(s);
  }
}

}  // namespace gantry::motion
