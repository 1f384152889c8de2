#include "motion/path/bead.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <optional>
#include <span>
#include <string>
#include <utility>

#include "motion/path/arch.hpp"
#include "motion/path/moves.hpp"
#include "motion/path/path_planner.hpp"
#include "motion/path/reach.hpp"
#include "motion/path/rejoin.hpp"
#include "motion/path/rounding.hpp"
#include "motion/path/run.hpp"
#include "motion/profile/line_bounds.hpp"
#include "motion/profile/speed_profile.hpp"

namespace gantry::motion {
namespace {

/// So much faster than planned a bead may be played, so that it takes whole ticks: as a share of its time, and in
/// ticks. A board whose slope is 0.02 makes its beads longer by 2e-4; they take the ticks that they take on one that is
/// level.
constexpr double kFaster = 2e-4, kFasterTicks = 0.05;
/// What beads leave of the axis limits: a stop that begins where the plan uses them fully needs some of acceleration
/// and jerk, and what is played faster than planned some of the speed.
constexpr double kUseV = 1 - kFaster, kUseA = 0.97, kUseJ = 0.98;
/// Shares of the tolerance that are tried one after the other where no speed is found, or a curve is not as fast as it
/// is to be: where the tolerance is a large part of its radius, its inside is the narrower way. Without any, corners
/// are rests.
constexpr double kShares[] = {1, 0.7, 0.4, 0.15};
constexpr double kHeld = 0.99;       ///< mean speed of a bead that holds its speed, as a share of it
constexpr double kAtSpeed = 0.99;    ///< share of the length of such a bead that is at ...
constexpr double kNearSpeed = 0.96;  ///< ... so much of its speed
/// A rounded path stays within a tolerance of its polyline; the corner itself is up to sqrt(2) as far from the path.
constexpr double kOfCorner = std::numbers::sqrt2 / 2;
/// What is left of a bead that was cut in a bend is played so much slower, where no run-up leads to it else.
constexpr double kSlower = 1.02, kSlowest = 1.045;
constexpr double kSameHeight_mm = 1e-9;
constexpr double kSteep = 2;  ///< slope of a run-up onto it that comes from far above

/// A straight stretch between two points of the polyline.
struct Leg {
  AxisVec from{}, to{};
  AxisVec direction{};  ///< dq/ds, s along the linear axes
  double length = 0;
};

std::string number(double x) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", x);
  return text;
}

bool straight_on(const Limits& limits, const Leg& a, const Leg& b) {
  for (std::size_t i = 0; i < limits.axes; ++i)
    if (std::abs(b.direction[i] - a.direction[i]) >= 1e-9) return false;
  return true;
}

/// Legs of the polyline; what goes straight on is one.
Result<std::vector<Leg>> legs_of(const Limits& limits, const std::vector<AxisVec>& points) {
  std::vector<Leg> legs;
  AxisVec from = points.empty() ? AxisVec{} : points.front();
  for (std::size_t k = 1; k < points.size(); ++k) {
    Leg leg{from, points[k], {}, 0};
    double linear = 0, rotary = 0;
    for (std::size_t i = 0; i < limits.axes; ++i) {
      const double displacement = leg.to[i] - leg.from[i];
      (limits.linear[i] ? linear : rotary) += displacement * displacement;
    }
    leg.length = std::sqrt(linear);
    if (leg.length < 1e-9) {
      if (rotary > 1e-18)
        return fail(Fault::NoSolution,
                    "point " + std::to_string(k + 1) +
                        " of a bead turns an axis on the spot; spread the turn over some length, or split the bead");
      continue;  // the same point twice
    }
    for (std::size_t i = 0; i < limits.axes; ++i) leg.direction[i] = (leg.to[i] - leg.from[i]) / leg.length;
    from = leg.to;
    if (!legs.empty() && straight_on(limits, legs.back(), leg)) {
      Leg& line = legs.back();
      line.to = leg.to;
      line.length += leg.length;
      for (std::size_t i = 0; i < limits.axes; ++i) line.direction[i] = (line.to[i] - line.from[i]) / line.length;
    } else {
      legs.push_back(leg);
    }
  }
  if (legs.empty()) return fail(Fault::NoSolution, "a bead needs at least two different points");
  return legs;
}

/// One that is sharp, which all of the tolerance makes faster.
bool has_corner(const Limits& limits, const std::vector<Leg>& legs) {
  for (std::size_t k = 1; k < legs.size(); ++k) {
    double turn = 0;
    for (std::size_t i = 0; i < limits.axes; ++i)
      if (limits.linear[i]) turn = std::hypot(turn, legs[k].direction[i] - legs[k - 1].direction[i]);
    if (turn > kSharp) return true;
  }
  return false;
}

Limits with_reserve(Limits limits) {
  for (AxisLimits& axis : limits.axis) axis.v_max *= kUseV, axis.a_max *= kUseA, axis.j_max *= kUseJ;
  return limits;
}

/// Straight legs with a rest in each corner. The first begins, and the last ends, as fast as it can and may.
std::vector<Run> resting_runs(const Limits& limits, const Measure& measure, const std::vector<Leg>& legs, double v_set,
                              double entry_mm_s) {
  constexpr double kFit = 1 - 1e-9;  // the motion between extreme speeds exists beyond rounding
  std::vector<Run> runs;
  for (const Leg& leg : legs) {
    Run& run = runs.emplace_back();
    run.curve = straight_curve(measure, leg.from, leg.to);
    run.curve.rest_after = true;
    Bounds bounds = line_bounds(limits, leg.direction);
    bounds.v = std::min(bounds.v, v_set);
    const double fastest = speed_over_length(0, leg.length * kFit, bounds);
    if (runs.size() == 1) run.v0 = std::min(fastest, entry_mm_s);
    if (runs.size() == legs.size()) run.v1 = fastest, run.curve.rest_after = false;
  }
  speed_up_lines(runs, limits, v_set, entry_mm_s);
  return runs;
}

/// Through these points, and what leads to the first and away from the last where it is bent. Where they begin and end,
/// a curve does: lines that go on through there are cut again.
Result<BeadRuns> planned_runs(const Limits& limits, const Measure& measure, std::span<const AxisVec> points,
                              const PathOptions& options) {
  PathPlanner planner(limits, options);
  for (const AxisVec& p : points)
    if (auto ok = planner.add(p); !ok) return tl::unexpected(ok.error());
  if (auto ok = planner.finish(); !ok) return tl::unexpected(ok.error());
  Stretch all;
  planner.take_all(all);
  const double begin_mm = planner.lead_in_mm(), end_mm = all.length_mm - planner.lead_out_mm();
  return BeadRuns{bent_runs(measure, all, 0, begin_mm), runs_between(measure, all, begin_mm, end_mm),
                  bent_runs(measure, all, end_mm, all.length_mm)};
}

bool all_there(const std::vector<Run>& runs) {
  return !runs.empty() && std::none_of(runs.begin(), runs.end(), [](const Run& r) { return r.phases.empty(); });
}

/// The bead at full speed inside this share of its tolerance, as it comes from a run-up. Not all_there(): no speed was
/// found.
BeadRuns rounded_runs(const Limits& limits, const Measure& measure, const BeadSpec& spec, double share) {
  auto runs = planned_runs(limits, measure, spec.points,
                           {.tolerance_mm = share * kOfCorner * spec.corner_tolerance_mm,
                            .by_vertex = true,
                            .speed_mm_s = spec.speed_mm_s,
                            .whole_ticks = false,
                            .leads = true,
                            .lead_in_mm_s = spec.entry_mm_s})
                  .value_or(BeadRuns{});
  if (all_there(runs.left)) speed_up_lines(runs.left, limits, spec.speed_mm_s, spec.entry_mm_s);
  return runs;
}

double length_of(const std::vector<Run>& runs) {
  double sum = 0;
  for (const Run& run : runs) sum += run.curve.length - run.begin;
  return sum;
}

double mean_speed(const std::vector<Run>& runs) { return length_of(runs) / duration(runs); }

/// Share of their length at no less than kNearSpeed of the set speed, 0..1, phase by phase.
double at_speed(const std::vector<Run>& runs, double v_set) {
  double good_mm = 0;
  for (const Run& run : runs) {
    State x{0, run.v0, run.a0};
    for (const Phase& phase : run.phases) {
      const State y = advanced(x, phase.jerk, phase.duration_s);
      if (std::min(x.v, y.v) >= kNearSpeed * v_set) good_mm += y.p - x.p;
      x = y;
    }
  }
  return good_mm / length_of(runs);
}

/// It moves more axes than the coefficients of a segment are for.
bool is_too_wide(const Run& run) { return !run.curve.straight && 3 * moving_axes(run.curve) > kCoefficients; }

struct Shares {
  std::vector<double> order{std::begin(kShares), std::end(kShares)};
  BeadRuns first;  ///< of the first of them behind a full run-up, where that was planned
};

/// Shares of the tolerance in the order in which they are to be tried. However the bead begins it is laid on one path,
/// so that it can be cut and joined again: speeds are those behind a full run-up.
Shares shares_for(const Limits& limits, const Measure& measure, const std::vector<Leg>& legs, const BeadSpec& spec) {
  Shares out;
  if (has_corner(limits, legs)) return out;
  BeadSpec from_full_speed = spec;
  from_full_speed.entry_mm_s = kNoCap;
  auto best = out.order.begin();
  std::pair<double, double> fastest;  // share at its speed, as far as that matters, and mean speed
  const std::pair enough{kAtSpeed, kHeld * spec.speed_mm_s};
  for (auto share = best; share != out.order.end(); ++share) {
    BeadRuns runs = rounded_runs(limits, measure, from_full_speed, *share);
    if (!all_there(runs.left)) continue;
    const std::pair found{std::min(at_speed(runs.left, spec.speed_mm_s), kAtSpeed), mean_speed(runs.left)};
    if (found <= fastest) continue;
    fastest = found, best = share, out.first = std::move(runs);
    if (found.first >= enough.first && found.second >= enough.second) break;
  }
  std::rotate(out.order.begin(), best, best + 1);
  return out;
}

Result<BeadRuns> runs_of_bead(const Limits& limits, const Measure& measure, const std::vector<Leg>& legs,
                              const BeadSpec& spec) {
  if (legs.size() > 1 && spec.corner_tolerance_mm > 0) {
    Shares shares = shares_for(limits, measure, legs, spec);
    const bool planned = spec.entry_mm_s >= kNoCap && all_there(shares.first.left);
    for (std::size_t k = 0; k < shares.order.size(); ++k) {
      BeadRuns runs =
          planned && k == 0 ? std::move(shares.first) : rounded_runs(limits, measure, spec, shares.order[k]);
      if (!all_there(runs.left)) continue;
      if (std::any_of(runs.left.begin(), runs.left.end(), is_too_wide))
        return fail(Fault::NoSolution, "a bead moves more than " + std::to_string(kCoefficients / 3) +
                                           " axes through a rounded corner; give it no corner tolerance");
      return runs;
    }
  }
  BeadRuns runs{{}, resting_runs(limits, measure, legs, spec.speed_mm_s, spec.entry_mm_s), {}};
  if (!all_there(runs.left)) return fail(Fault::NoSolution, "a leg of a bead is too short to be planned");
  return runs;
}

/// From rest to the state at a bead's start, or from its end to rest; in whole ticks, of which a part is a standstill.
Profile ramp(const State& from, const State& to, Bounds bounds, double tick_s) {
  bounds.a = std::max({bounds.a, std::abs(from.a), std::abs(to.a)});  // of a bead that is a little faster
  Profile p = change_speed(from, to.v, bounds, to.a).profile;
  const double seconds = duration(p), stands = whole_ticks(seconds, tick_s) - seconds;
  if (!(stands > 0)) return p;
  Profile out{from, {}};
  if (from.v == 0) out.phases.push_back({stands, 0});
  for (const Phase& phase : p.phases) out.phases.push_back(phase);
  if (to.v == 0) out.phases.push_back({stands, 0});
  return out;
}

/// What begins or ends at rest takes whole ticks: it stands before it sets out, or when it has come.
void stand_before(std::vector<Run>& run_up, double tick_s) {
  if (run_up.empty()) return;
  const double seconds = duration(run_up), stands = whole_ticks(seconds, tick_s) - seconds;
  std::vector<Phase>& phases = run_up.front().phases;
  if (stands > 0) phases.insert(phases.begin(), {stands, 0});
}
void stand_behind(std::vector<Run>& run_out, double tick_s) {
  const double seconds = duration(run_out), stands = whole_ticks(seconds, tick_s) - seconds;
  if (stands > 0) run_out.back().phases.push_back({stands, 0});
}

Result<std::vector<Run>> run_up_onto(const std::vector<Run>& left, const Limits& limits, const Measure& measure,
                                     const Lift& lift) {
  const Run& first = left.front();
  return run_up_from_above(limits, measure,
                           join_on(measure, jet(first.curve, first.begin, kMaxAxes), first.v0, first.a0), lift);
}

void slow_down(BeadRuns& runs, double factor) {
  for (std::vector<Run>* part : {&runs.run_up, &runs.left, &runs.run_out}) slow_down(*part, factor);
}

/// A little slower, or by kFaster faster, so that what is left takes whole ticks; run-up and run-out stand for a part
/// of one. The factor of time. `before`: the one by which it was slowed already; of kFaster is left what that leaves.
double to_whole_ticks(BeadRuns& runs, double tick_s, double before = 1) {
  const double faster = std::clamp(1 - (1 - kFaster) / before, 0.0, kFaster), seconds = duration(runs.left);
  const double faster_s = std::min(faster * seconds, kFasterTicks * tick_s);
  const double factor = whole_ticks(seconds - faster_s, tick_s) / seconds;
  slow_down(runs, factor);
  return factor;
}

/// What is left of a bead that was cut, and its run-up. `factor`: of its time, by which the runs are slowed already.
Result<BeadRuns> join(const Limits& own, const Limits& limits, const Measure& measure, const BeadSpec& spec,
                      const BeadRuns& runs, double& factor) {
  Lift lift{spec.lift_axis, spec.lift_mm};
  if (spec.fall_mm > lift.mm) lift.mm = spec.fall_mm, lift.slope = kSteep;
  BeadRuns out{{}, runs_from(measure, runs.left, own, spec.speed_mm_s / factor, spec.begin_mm), runs.run_out};
  if (out.left.empty()) return fail(Fault::NoSolution, "nothing of the bead is left");
  if (spec.entry_mm_s < kNoCap) {
    auto slower = join_slower(own, measure, out.left, lift, spec.speed_mm_s, spec.entry_mm_s);
    if (!slower) return slower;
    if (!all_there(slower->left)) return fail(Fault::NoSolution, "what is left of the bead is too short to be planned");
    factor = to_whole_ticks(*slower, limits.tick_s);
    stand_before(slower->run_up, limits.tick_s);
    return slower;
  }
  BeadRuns whole = out;
  double whole_factor = factor * to_whole_ticks(whole, limits.tick_s, factor);
  auto from_above = run_up_onto(whole.left, own, measure, lift);
  if (from_above) {
    factor = whole_factor, whole.run_up = *std::move(from_above);
    return whole;
  }
  // No run-up leads onto it at that speed: it speeds up on the bead, or all of it is a little slower.
  auto speeds_up = join_slower(own, measure, out.left, lift, spec.speed_mm_s, out.left.front().v0 / kSlower);
  for (double slower = kSlower; !from_above && slower <= kSlowest; slower *= kSlower) {
    whole = out;
    slow_down(whole, slower);
    whole_factor = factor * slower;
    whole_factor *= to_whole_ticks(whole, limits.tick_s, whole_factor);
    from_above = run_up_onto(whole.left, own, measure, lift);
  }
  if (!from_above) from_above = run_up_onto(whole.left, limits, measure, lift);
  const auto comes_down = [&](const BeadRuns& r) {  // from as high as is asked for
    const std::size_t z = lift.axis;
    return all_there(r.left) && !r.run_up.empty() &&
           r.run_up.front().curve.c[0][z] - r.left.front().curve.c[0][z] >= lift.mm - kSameHeight_mm;
  };
  if (speeds_up && comes_down(*speeds_up) && (!from_above || mean_speed(speeds_up->left) > mean_speed(whole.left))) {
    factor = to_whole_ticks(*speeds_up, limits.tick_s);
    stand_before(speeds_up->run_up, limits.tick_s);
    return speeds_up;
  }
  if (!from_above) return tl::unexpected(from_above.error());
  factor = whole_factor, whole.run_up = *std::move(from_above);
  return whole;
}

/// The bead itself first, then its run-out: another run-up helps neither.
Result<void> within_limits(const Limits& limits, const BeadMotion& bead) {
  const std::span<const Segment> all = bead.segments;
  if (const auto out = beyond_limits(limits, all.subspan(bead.bead_begin, bead.bead_end - bead.bead_begin)))
    return fail(Fault::OutOfReach, "a bead bends " + number(out->by) + " mm beyond the soft limits of axis " +
                                       limits.name[out->axis].data() +
                                       "; lower its `corner_tolerance`, or move it inwards");
  const auto lead = [&](const char* what, double speed, double mm, std::size_t axis) {
    return std::string("the ") + what + " of a bead at " + number(speed) + " mm/s needs " + number(mm) +
           " mm and leaves the soft limits of axis " + limits.name[axis].data() +
           "; lower the speed or move the bead inwards";
  };
  if (const auto out = beyond_limits(limits, all.subspan(bead.bead_end))) {
    const SpeedProfile& at = all[bead.bead_end - 1].nominal;
    return fail(Fault::OutOfReach, lead("run-out", along(at, duration(at)).x.v, bead.run_out_mm, out->axis));
  }
  if (const auto out = beyond_limits(limits, all.first(bead.bead_begin)))
    return fail(Fault::SpeedNotReachable, lead("run-up", all[bead.bead_begin].nominal.v0, bead.run_up_mm, out->axis));
  return {};
}

/// The run-up that is planned, one segment, made to come down.
Result<std::vector<Segment>> fall(const Limits& limits, const BeadMotion& bead, const BeadSpec& spec) {
  if (bead.segments.size() == 1)
    if (auto out = fall_into(limits, bead.segments.front(), spec.lift_axis, spec.fall_mm); !out.empty()) return out;
  return fail(Fault::NoSolution,
              "a bead that goes up or down as it begins, or begins from rest, is not come to from above");
}

/// It opens `dry_mm` behind the bead's start, where the tool stands first when it begins to, and shuts at the end.
void add_valve(BeadMotion& bead, const BeadSpec& spec) {
  if (spec.valve == 0) return;
  std::size_t opening = bead.bead_begin;
  double at = spec.dry_mm;
  for (; at > bead.segments[opening].geometry.length && opening + 1 < bead.bead_end; ++opening)
    at -= bead.segments[opening].geometry.length;
  bead.segments[opening].events.push_back({at, spec.open_lead_s, spec.valve, spec.valve, true});
  Segment& closing = bead.segments[bead.bead_end - 1];
  closing.events.push_back({closing.geometry.length, spec.close_lead_s, spec.valve, 0, false});
}

}  // namespace

Result<BeadMotion> plan_bead(const Limits& limits, const BeadSpec& spec) {
  if (!(spec.speed_mm_s > 0) || !std::isfinite(spec.speed_mm_s) || !(spec.corner_tolerance_mm >= 0))
    return fail(Fault::NoSolution, "a bead needs a speed above 0 and a corner tolerance of 0 or more");
  for (std::size_t k = 0; k < spec.points.size(); ++k)
    if (!within(limits, spec.points[k]))
      return fail(Fault::OutOfReach, "point " + std::to_string(k + 1) + " of a bead lies outside the soft limits");
  const Result<std::vector<Leg>> legs = legs_of(limits, spec.points);
  if (!legs) return tl::unexpected(legs.error());
  const Measure measure = measure_of(limits, {.tolerance_mm = spec.corner_tolerance_mm});
  const Limits own = with_reserve(limits);
  BeadSpec planned = spec;
  if (spec.begin_mm > 0) planned.entry_mm_s = kNoCap;  // that is where it is joined
  Result<BeadRuns> runs = runs_of_bead(own, measure, *legs, planned);
  if (!runs) return tl::unexpected(runs.error());

  BeadMotion bead;
  double factor = to_whole_ticks(*runs, limits.tick_s);
  if (spec.begin_mm > 0) {
    runs = join(own, limits, measure, spec, *runs, factor);
    if (!runs) return tl::unexpected(runs.error());
  }
  auto& [run_up, left, run_out] = *runs;
  bead.bead_seconds = duration(left);
  bead.bead_length_mm = length_of(left);

  const Run &first = left.front(), &last = left.back();
  const CurveJet begin = jet(first.curve, first.begin, kMaxAxes), end = jet(last.curve, last.curve.length, limits.axes);
  const bool from_rest = run_up.empty() && !(first.v0 > 0), falls = spec.fall_mm > 0 && spec.begin_mm <= 0;
  if (falls && !run_up.empty()) {
    auto falling = run_up_onto(left, own, measure, {spec.lift_axis, spec.fall_mm, kSteep});
    if (!falling) return tl::unexpected(falling.error());
    run_up = *std::move(falling);
  } else if (spec.begin_mm <= 0) {
    stand_before(run_up, limits.tick_s);
  }
  const bool falls_straight = falls && run_up.empty();
  if (run_up.empty() && !from_rest) {
    const Profile up = ramp({0, 0, 0}, {0, first.v0, first.a0}, line_bounds(own, begin.d1), limits.tick_s);
    run_up.push_back(straight_run(measure, begin.q, begin.d1, true, up));
  }
  if (run_out.empty()) {
    const Profile down = ramp({0, last.v1, last.a1}, {0, 0, 0}, line_bounds(own, end.d1), limits.tick_s);
    run_out.push_back(straight_run(measure, end.q, end.d1, false, down));
    run_out.back().curve.rest_after = true;
  } else {
    stand_behind(run_out, limits.tick_s);
  }
  for (const Run& run : run_up) bead.run_up_mm += run.curve.length;
  for (const Run& run : run_out) bead.run_out_mm += run.curve.length;
  bead.start = from_rest ? begin.q : run_up.front().curve.c[0];
  bead.end = jet(run_out.back().curve, run_out.back().curve.length, kMaxAxes).q;

  Segment like;
  like.block = spec.block, like.feature = spec.feature;
  like.v_cap = spec.speed_mm_s / factor;
  for (const Run& run : run_up) append_segments(run, like, bead.segments);
  if (falls_straight) {
    auto falling = fall(own, bead, spec);
    if (!falling) return tl::unexpected(falling.error());
    bead.segments = *std::move(falling);
    bead.start[spec.lift_axis] += spec.fall_mm;
  }
  bead.bead_begin = bead.segments.size();
  if (spec.stand_s > 0 && from_rest) bead.segments.push_back(dwell(limits, bead.start, spec.stand_s));
  for (const Run& run : left) append_segments(run, like, bead.segments);
  bead.bead_end = bead.segments.size();
  for (const Run& run : run_out) append_segments(run, like, bead.segments);
  if (const auto ok = within_limits(limits, bead); !ok) return tl::unexpected(ok.error());
  add_valve(bead, spec);
  return bead;
}

Result<std::vector<Segment>> plan_dry(const Limits& limits, std::span<const AxisVec> points, double speed_mm_s,
                                      double tolerance_mm) {
  for (const AxisVec& p : points)
    if (!within(limits, p)) return fail(Fault::OutOfReach, "a point of a path lies outside the soft limits");
  const Limits own = with_reserve(limits);
  Error why{Fault::NoSolution, "a path needs at least two different points", {}};
  for (const double tolerance : {tolerance_mm, 0.0}) {
    const PathOptions options{.tolerance_mm = tolerance, .speed_mm_s = speed_mm_s};
    auto runs = planned_runs(own, measure_of(own, options), points, options);
    if (!runs) {
      why = runs.error();
      continue;
    }
    std::vector<Run>& all = runs->left;
    if (!all_there(all) || std::any_of(all.begin(), all.end(), is_too_wide)) continue;
    all.back().curve.rest_after = true;
    Segment like;
    like.feature = kTravel, like.v_cap = speed_mm_s;
    std::vector<Segment> out;
    for (const Run& run : all) append_segments(run, like, out);
    if (!beyond_limits(limits, out)) return out;
    why = {Fault::OutOfReach, "a path bends beyond the soft limits", {}};
  }
  return tl::unexpected(why);
}

}  // namespace gantry::motion
