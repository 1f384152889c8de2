#include "motion/path/bead.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>

#include "motion/path/blend.hpp"
#include "motion/path/moves.hpp"
#include "motion/path/speeds.hpp"

namespace gantry::motion {
namespace {

/// A straight stretch between two points of the polyline.
struct Leg {
  AxisVec from{}, to{};
  AxisVec direction{};  ///< dq/ds, s along the linear axes
  double length = 0;
};

enum class Corner { Straight, Stop, Blend };

/// What turns more than this (|d1 + d2| falls below) is a reversal: a blend would hardly move there.
constexpr double kReversal = 0.5;

std::string number(double x) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", x);
  return text;
}

Result<std::vector<Leg>> legs_of(const Limits& limits, const std::vector<AxisVec>& points) {
  std::vector<Leg> legs;
  for (std::size_t k = 1; k < points.size(); ++k) {
    Leg leg{points[k - 1], points[k], {}, 0};
    if (!legs.empty()) leg.from = legs.back().to;
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
    legs.push_back(leg);
  }
  if (legs.empty()) return fail(Fault::NoSolution, "a bead needs at least two different points");
  return legs;
}

Corner corner_between(const Limits& limits, const Leg& a, const Leg& b, double tolerance_mm) {
  double change = 0, along = 0;
  for (std::size_t i = 0; i < limits.axes; ++i) {
    change = std::max(change, std::abs(b.direction[i] - a.direction[i]));
    const double sum = a.direction[i] + b.direction[i];
    if (limits.linear[i]) along += sum * sum;
  }
  if (change < 1e-9) return Corner::Straight;
  return tolerance_mm > 0 && std::sqrt(along) > kReversal ? Corner::Blend : Corner::Stop;
}

AxisVec along(const AxisVec& q, const AxisVec& direction, double s) {
  AxisVec out = q;
  for (std::size_t i = 0; i < kMaxAxes; ++i) out[i] += direction[i] * s;
  return out;
}

Geometry line(const AxisVec& from, const AxisVec& direction, double length) {
  Geometry g;
  g.length = length;
  g.degree = 1;
  g.c[0] = from;
  for (std::size_t i = 0; i < kMaxAxes; ++i) g.c[1][i] = direction[i] * length;
  return g;
}

/// The polyline with its corners blended or marked as stops.
std::vector<Piece> pieces_of(const Limits& limits, const std::vector<Leg>& legs, const BeadSpec& spec) {
  const std::size_t n = legs.size();
  std::vector<Corner> corner(n, Corner::Stop);  // [k]: at the end of leg k
  for (std::size_t k = 0; k + 1 < n; ++k)
    corner[k] = corner_between(limits, legs[k], legs[k + 1], spec.corner_tolerance_mm);
  const auto blended = [&](std::size_t k) { return k + 1 < n && corner[k] == Corner::Blend; };
  const auto share = [&](std::size_t k) {  // of leg k that one of its corners may take
    return k > 0 && blended(k - 1) && blended(k) ? legs[k].length / 2 : legs[k].length;
  };

  std::vector<Piece> pieces;
  double begin = 0;  // of the current leg: where the last blend has ended
  for (std::size_t k = 0; k < n; ++k) {
    const Leg& leg = legs[k];
    double d = 0;
    if (blended(k))
      d = std::min({blend_reach(limits, leg.direction, legs[k + 1].direction, spec.corner_tolerance_mm), share(k),
                    share(k + 1)});
    const double length = leg.length - d - begin;
    if (length > 1e-12)
      pieces.push_back({line(along(leg.from, leg.direction, begin), leg.direction, length),
                        line_bounds(limits, leg.direction), spec.speed_mm_s, false});
    if (blended(k))
      pieces.push_back({blend(leg.to, leg.direction, legs[k + 1].direction, d),
                        blend_bounds(limits, leg.direction, legs[k + 1].direction, d, spec.speed_mm_s), spec.speed_mm_s,
                        false});
    else if (k + 1 < n && corner[k] == Corner::Stop)
      pieces.back().stop_after = true;
    begin = d;
  }
  return pieces;
}

Segment segment_of(const Piece& piece, const Profile& profile, double v_cap, double v_exit, const BeadSpec& spec) {
  Segment s;
  s.block = spec.block;
  s.feature = spec.feature;
  s.geometry = piece.geometry;
  s.nominal = nominal(profile);
  s.v_cap = v_cap;
  s.v_max = piece.bounds.v, s.a_max = piece.bounds.a, s.j_max = piece.bounds.j;
  s.v_exit = v_exit;
  return s;
}

/// A ramp between rest and v in whole ticks. It is symmetric: its length is v/2 times its duration, whatever it is.
Profile ramp(double v_from, double v_to, const Bounds& bounds, double tick_s) {
  Profile p = change_speed({0, v_from, 0}, v_to, bounds).profile;
  const double seconds = duration(p), factor = whole_ticks(seconds, tick_s) / seconds;
  for (Phase& phase : p.phases) {  // longer at the same speeds: jerk falls with the square
    phase.duration_s *= factor;
    phase.jerk /= factor * factor;
  }
  return p;
}

Result<void> room_for(const Limits& limits, const AxisVec& q, const char* what, double length, double speed) {
  for (std::size_t i = 0; i < limits.axes; ++i) {
    const AxisLimits& a = limits.axis[i];
    if (q[i] >= a.p_min && q[i] <= a.p_max) continue;
    return fail(Fault::SpeedNotReachable, std::string("the ") + what + " of a bead at " + number(speed) +
                                              " mm/s needs " + number(length) +
                                              " mm and leaves the soft limits of axis " + std::to_string(i) +
                                              "; lower the speed or move the bead inwards");
  }
  return {};
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

  const std::vector<Piece> pieces = pieces_of(limits, *legs, spec);
  const std::vector<double> v = boundary_speeds(pieces, kNoCap, kNoCap);
  std::vector<Profile> profiles;
  BeadMotion bead;
  double seconds = 0;
  for (std::size_t k = 0; k < pieces.size(); ++k) {
    profiles.push_back(piece_profile(pieces[k], v[k], v[k + 1]));
    seconds += duration(profiles.back());
    bead.bead_length_mm += pieces[k].geometry.length;
  }
  // A little slower, so that the bead takes whole ticks; run-up and run-out then choose their length so that they do.
  bead.bead_seconds = whole_ticks(seconds, limits.tick_s);
  const double factor = bead.bead_seconds / seconds;
  const double v_cap = spec.speed_mm_s / factor;

  const auto ramp_piece = [&](const Leg& leg, const Profile& p, bool up) {
    const double length = end_state(p).p;
    const AxisVec& from = up ? along(leg.from, leg.direction, -length) : leg.to;
    return Piece{line(from, leg.direction, length), line_bounds(limits, leg.direction), v_cap, !up};
  };
  const Leg &first = legs->front(), &last = legs->back();
  const Profile up = ramp(0, v.front() / factor, line_bounds(limits, first.direction), limits.tick_s);
  const Profile down = ramp(v.back() / factor, 0, line_bounds(limits, last.direction), limits.tick_s);
  const Piece run_up = ramp_piece(first, up, true), run_out = ramp_piece(last, down, false);
  bead.run_up_mm = run_up.geometry.length;
  bead.run_out_mm = run_out.geometry.length;
  bead.start = run_up.geometry.c[0];
  bead.end = along(last.to, last.direction, bead.run_out_mm);
  if (const auto ok = room_for(limits, bead.start, "run-up", bead.run_up_mm, v.front()); !ok)
    return tl::unexpected(ok.error());
  if (const auto ok = room_for(limits, bead.end, "run-out", bead.run_out_mm, v.back()); !ok)
    return tl::unexpected(ok.error());

  bead.outline.push_back(bead.start);
  bead.outline.insert(bead.outline.end(), spec.points.begin(), spec.points.end());
  bead.outline.push_back(bead.end);
  bead.corner_tolerance_mm = spec.corner_tolerance_mm;

  bead.segments.push_back(segment_of(run_up, up, v_cap, v.front() / factor, spec));
  for (std::size_t k = 0; k < pieces.size(); ++k)
    bead.segments.push_back(segment_of(pieces[k], stretched(profiles[k], factor), v_cap, v[k + 1] / factor, spec));
  if (spec.valve != 0) {
    bead.segments[1].events.push_back({0, spec.open_lead_s, spec.valve, spec.valve, true});
    bead.segments.back().events.push_back(
        {bead.segments.back().geometry.length, spec.close_lead_s, spec.valve, 0, false});
  }
  bead.segments.push_back(segment_of(run_out, down, v_cap, 0, spec));
  return bead;
}

}  // namespace gantry::motion
