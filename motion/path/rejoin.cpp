#include "motion/path/rejoin.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "motion/path/lead.hpp"
#include "motion/path/moves.hpp"
#include "motion/path/path_planner.hpp"
#include "motion/profile/line_bounds.hpp"
#include "motion/profile/planner.hpp"
#include "motion/profile/speed_profile.hpp"

namespace gantry::motion {
namespace {

constexpr double kFlat_s = 0.5, kSteepest = 20;  // of a run-up from above
constexpr double kCurveShare = 0.3;              // of an axis' limits that the descent may use of itself
/// One of the descents that are tried, of which the shortest is taken: shares of the limits for speeding up, and for
/// the change of acceleration at the join; and over how much of its radius it is bent.
struct Try {
  double speed_up, into, bent;
};
constexpr Try kTries[] = {{0.5, 1, 1}, {0.5, 0.5, 2}, {0.25, 0.25, 1}, {0.25, 0.5, 3}, {0.1, 0.1, 2}, {0.1, 0.05, 4}};
constexpr double kLeastCruise = 0.05;  // of the join's speed
constexpr double kAnySpeed = 1e9;      // of the tool, mm/s; the axes have limits of their own
constexpr double kBentShare = 0.3;     // a bead that is bent so much is come to at its speed

/// Time into a phase at which p has been travelled.
double time_into(const State& from, const Phase& phase, double p) {
  SpeedProfile alone{from.v, from.a, {}};
  alone.phases.push_back(phase);
  return time_at(alone, p - from.p);
}

/// The run without its first `cut_mm`. A curve stays whole and is entered later.
Run shortened(const Measure& measure, const Run& run, double cut_mm) {
  Run out = run;
  State x{run.begin, run.v0, run.a0};
  const double at = run.begin + cut_mm;
  std::size_t k = 0;
  for (; k < run.phases.size(); ++k) {
    const State end = advanced(x, run.phases[k].jerk, run.phases[k].duration_s);
    if (end.p > at) break;
    x = end;
  }
  out.phases.assign(run.phases.begin() + static_cast<std::ptrdiff_t>(std::min(k, run.phases.size())), run.phases.end());
  if (!out.phases.empty()) {
    Phase& first = out.phases.front();
    const double t = time_into(x, first, at);
    x = advanced(x, first.jerk, t);
    first.duration_s -= t;
  }
  out.v0 = x.v, out.a0 = x.a;
  if (run.curve.straight) {
    const CurveJet from = jet(run.curve, at, kMaxAxes), to = jet(run.curve, run.curve.length, kMaxAxes);
    out.curve = straight_curve(measure, from.q, to.q);
    out.curve.rest_after = run.curve.rest_after;
    out.begin = 0;
  } else {
    out.begin = at;
  }
  return out;
}

/// So long that the lift alone uses a small part of its axis' limits at this speed, and stays flat, unless that takes
/// more than `kFlat_s`: a bead of 0.1 mm/s would set in its minute.
double gentle_mm(const AxisLimits& axis, const Lift& lift, double v, double a) {
  if (lift.mm <= 0) return 0;
  const double bend = 6 * lift.mm;  // of the third power, by the square of the length
  const double flat = std::clamp(v * kFlat_s, 3 * lift.mm / std::max(kSteepest, lift.slope), 3 * lift.mm / lift.slope);
  return std::max({flat, std::sqrt(bend * v * v / (kCurveShare * axis.a_max)),
                   std::cbrt(bend * v * v * v / (kCurveShare * axis.j_max)),
                   std::sqrt(3 * bend * v * a / (kCurveShare * axis.j_max))});
}

/// One run for each curve, of a motion over all of them.
std::vector<Run> runs_of(const std::vector<Curve>& curves, const Profile& motion) {
  std::vector<Run> out;
  State x = motion.from;
  double end = 0;
  std::size_t k = 0;
  double gone_s = 0;  // of phase k
  for (std::size_t c = 0; c < curves.size(); ++c) {
    end += curves[c].length;
    const bool last = c + 1 == curves.size();
    Run run;
    run.curve = curves[c];
    run.v0 = x.v, run.a0 = x.a;
    for (; k < motion.phases.size(); ++k, gone_s = 0) {
      const Phase& phase = motion.phases[k];
      const double left_s = phase.duration_s - gone_s;
      const State after = advanced(x, phase.jerk, left_s);
      if (!last && after.p > end) {
        const double t = time_into(x, {left_s, phase.jerk}, end);
        if (t > 0) run.phases.push_back({t, phase.jerk});
        x = advanced(x, phase.jerk, t);
        gone_s += t;
        break;
      }
      run.phases.push_back({left_s, phase.jerk});
      x = after;
    }
    run.v1 = x.v, run.a1 = x.a;
    out.push_back(std::move(run));
  }
  return out;
}

void append(Profile& out, const Profile& more) {
  for (const Phase& phase : more.phases)
    if (phase.duration_s > 0) out.phases.push_back(phase);
}

Stretch stretch_of(const std::vector<Run>& runs) {
  Stretch out;
  State x{0, runs.front().v0, runs.front().a0};
  for (const Run& run : runs) {
    out.curves.push_back(run.curve);
    out.length_mm += run.curve.length;
    for (const Phase& phase : run.phases) {
      out.pieces.push_back({phase.duration_s, x.p, x.v, x.a, phase.jerk});
      x = advanced(x, phase.jerk, phase.duration_s);
      out.duration_s += phase.duration_s;
    }
  }
  return out;
}

}  // namespace

std::vector<Run> runs_from(const Measure& measure, const std::vector<Run>& runs, const Limits& limits, double v_set,
                           double begin_mm) {
  constexpr double kLeast_mm = 1e-6;
  std::vector<Run> out;
  double before = 0;
  for (const Run& run : runs) {
    const double length = run.curve.length - run.begin, cut = begin_mm - before;
    before += length;
    if (cut >= length - kLeast_mm) continue;
    out.push_back(cut > 0 ? shortened(measure, run, cut) : run);
  }
  if (!out.empty() && out.front().curve.straight) {
    std::vector<Run> first{out.front()};
    // Alone it would also end as fast as it can: what comes next holds it to what it had.
    if (out.size() > 1) first.push_back(out[1]);
    speed_up_lines(first, limits, v_set);
    out.front() = first.front();
  }
  return out;
}

// With g = |q'| = dl/ds: q_l = q'/g, q_ll = (q'' - q_l g')/g^2, l' = v g, l'' = a g + v^2 g'.
Join join_on(const Measure& measure, const CurveJet& at, double v, double a) {
  const double g = along(measure, at.d1);
  double slope = 0;
  for (std::size_t i = 0; i < measure.axes; ++i)
    if (measure.along[i]) slope += at.d1[i] * at.d2[i] / g;
  Join out{at, v * g, a * g + v * v * slope};
  for (std::size_t i = 0; i < kMaxAxes; ++i) {
    out.at.d1[i] = at.d1[i] / g;
    out.at.d2[i] = (at.d2[i] - out.at.d1[i] * slope) / (g * g);
  }
  return out;
}

Result<std::vector<Run>> run_up_from_above(const Limits& limits, const Measure& measure, const Join& join,
                                           const Lift& lift) {
  const Bounds there = line_bounds(limits, join.at.d1);
  const double bend = bend_of(measure, join.at);
  std::vector<Run> best;
  double best_mm = std::numeric_limits<double>::infinity();
  std::string reason = "the bead speeds up from rest there, which no run-up can follow";
  for (const Try& t : kTries) {
    // From the cruising speed the join's is reached, with its acceleration, by a single jerk. A bead that is played
    // faster, by what makes it take whole ticks, may use more than the planner's limits.
    const Bounds into_bounds{there.v, std::max(there.a, std::abs(join.a)), there.j * t.into};
    const double cruise_mm_s = join.v - join.a * std::abs(join.a) / (2 * into_bounds.j);
    if (!(cruise_mm_s > kLeastCruise * join.v)) continue;
    const Profile into = change_speed({0, cruise_mm_s, 0}, join.v, into_bounds, join.a).profile;
    AxisVec start = join.at.d1;  // how it goes where it is bent no more
    for (std::size_t i = 0; i < limits.axes; ++i) start[i] -= join.at.d2[i] * (bend > 0 ? t.bent / bend / 2 : 0);
    const Bounds far = line_bounds(limits, start);
    const Bounds eased{there.v, std::min(there.a, far.a) * t.speed_up, std::min(there.j, far.j) * t.speed_up};
    const Profile up = change_speed({0, 0, 0}, cruise_mm_s, eased).profile;
    const double ramps_mm = end_state(up).p + end_state(into).p,
                 gentle = gentle_mm(limits.axis[lift.axis], lift, std::max(join.v, cruise_mm_s), eased.a);
    double length_mm = std::max(ramps_mm, gentle);
    if (join.v * join.v * bend > kBentShare * there.a) length_mm += bent_over_mm(bend, t.bent, length_mm);
    const std::vector<Curve> curves = lead_in(measure, join.at, length_mm, bent_over_mm(bend, t.bent, length_mm), lift);
    const double cruise_s = (length_of(curves) - ramps_mm) / cruise_mm_s;
    if (!(cruise_s >= 0)) continue;
    const double seconds = duration(up) + cruise_s + duration(into);
    Profile motion{{0, 0, 0}, {}};
    if (const double stands = whole_ticks(seconds, limits.tick_s) - seconds; stands > 0)
      motion.phases.push_back({stands, 0});
    append(motion, up);
    if (cruise_s > 0) motion.phases.push_back({cruise_s, 0});
    append(motion, into);
    std::vector<Run> runs = runs_of(curves, motion);
    const Inspection seen = inspect(stretch_of(runs), limits, kAnySpeed, {0, 0, 0});
    if (!seen.sound) {
      reason = seen.reason;
    } else if (const double mm = length_of(curves); mm < best_mm) {
      best_mm = mm, best = std::move(runs);
    }
  }
  if (!best.empty()) return best;
  return fail(Fault::NoSolution, "no path down onto the bead is within the axes' limits: " + reason);
}

Result<BeadRuns> join_slower(const Limits& limits, const Measure& measure, const std::vector<Run>& left,
                             const Lift& lift, double v_set, double entry_mm_s) {
  const Run& first = left.front();
  const Join join{jet(first.curve, first.begin, kMaxAxes)};
  std::vector<Curve> curves;
  if (entry_mm_s > 0) {
    const Bounds there = line_bounds(limits, join.at.d1);
    const double length_mm = change_length(0, std::min(entry_mm_s, there.v), there.a, there.j);
    const Lift over{lift.axis, std::min(lift.mm, lift.slope * length_mm / 3)};
    curves = lead_in(measure, join.at, length_mm, bent_over_mm(bend_of(measure, join.at), 1, length_mm), over);
  }
  const double run_up_mm = length_of(curves);
  for (const Run& run : left)
    curves.push_back(run.begin > 0 ? part_of(run.curve, run.begin, run.curve.length) : run.curve);

  PathPlanner planner(limits, {.speed_mm_s = v_set, .whole_ticks = false, .leads = true, .lead_in_mm_s = 0});
  if (auto ok = planner.follow(std::move(curves)); !ok) return tl::unexpected(ok.error());
  Stretch all;
  planner.take_all(all);
  const double end_mm = all.length_mm - planner.lead_out_mm();
  std::vector<Run> runs = runs_between(measure, all, 0, run_up_mm);
  const auto of_run_up = static_cast<std::ptrdiff_t>(runs.size());
  const std::vector<Run> more = runs_between(measure, all, run_up_mm, end_mm);
  runs.insert(runs.end(), more.begin(), more.end());
  speed_up_lines(runs, limits, v_set, 0);
  BeadRuns out;
  out.run_up.assign(runs.begin(), runs.begin() + of_run_up);
  out.left.assign(runs.begin() + of_run_up, runs.end());
  out.run_out = bent_runs(measure, all, end_mm, all.length_mm);
  return out;
}

}  // namespace gantry::motion
