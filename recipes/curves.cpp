#include "recipes/curves.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <numbers>

namespace gantry::recipes {
namespace {

using std::numbers::pi;

constexpr double kMostTurn = pi / 12;
constexpr double kSame_mm = 1e-3;  // points nearer to each other, or to one line, give no arc

/// Angle of a chord that sags by `sag_mm`: a curve p(t) is off the chord over a step by at most |p''| step^2 / 8.
double step_rad(double bend_mm, double sag_mm) { return std::min(kMostTurn, std::sqrt(8 * sag_mm / bend_mm)); }

tl::unexpected<Error> too_many(std::size_t most) {
  return fail(Fault::TooManySteps,
              fmt::format("this curve needs more than {} points; make it shorter, or 'corner_tolerance' larger", most));
}

Vec3 at(const Arc& arc, double t) { return arc.centre + arc.ahead * std::cos(t) + arc.aside * std::sin(t); }

/// Integral of sqrt(r^2 + b^2) dr / b from 0: length of a spiral of b mm a rad, from its centre to radius r.
double spiral_length(double r, double b) { return (r * std::hypot(r, b) + b * b * std::asinh(r / b)) / (2 * b); }

}  // namespace

Result<Arc> arc_through(Vec3 from, Vec3 through, Vec3 to) {
  const Vec3 a = through - from, b = to - from;
  if (norm(b) < kSame_mm)
    return fail(Fault::Inconsistent, "the arc ends where it starts; write a 'circle' with its centre and radius");
  if (norm(a) < kSame_mm || norm(to - through) < kSame_mm)
    return fail(Fault::Inconsistent, "'through' is an end of the arc; give a point between 'from' and 'to'");
  const Vec3 n = cross(a, b);
  // Height of the triangle over its longest side.
  if (norm(n) < kSame_mm * std::max({norm(a), norm(b), norm(to - through)}))
    return fail(Fault::Inconsistent,
                "'from', 'through' and 'to' lie on one line; write a 'line', or move 'through' off it");
  // Centre of the circle through three points, seen from the first of them.
  const Vec3 to_centre = (cross(n, a) * dot(b, b) + cross(b, n) * dot(a, a)) * (1 / (2 * dot(n, n)));
  Arc arc{from + to_centre, to_centre * -1, {}, 0, from, to};
  arc.aside = cross(n * (1 / norm(n)), arc.ahead);
  const Vec3 last = to - arc.centre;
  const double angle = std::atan2(dot(last, arc.aside), dot(last, arc.ahead));
  arc.angle_rad = angle > 0 ? angle : angle + 2 * pi;
  return arc;
}

Result<Arc> arc_about(Vec2 centre, Vec3 from, double angle_rad) {
  const Vec2 ahead{from.x - centre.x, from.y - centre.y};
  if (norm(ahead) < kSame_mm)
    return fail(Fault::Inconsistent, "the arc starts at its centre and has no radius; move 'from' or 'centre'");
  if (std::abs(angle_rad) < 1e-6) return fail(Fault::Inconsistent, "an arc of 0 deg has no length; give its angle");
  const double side = angle_rad > 0 ? 1 : -1;
  Arc arc{{centre.x, centre.y, from.z}, {ahead.x, ahead.y, 0}, {-side * ahead.y, side * ahead.x, 0}, 0, from, from};
  arc.angle_rad = std::abs(angle_rad);
  if (arc.angle_rad < 2 * pi * (1 - 1e-12)) arc.to = at(arc, arc.angle_rad);
  return arc;
}

Result<Curve> sample(const Arc& arc, double sag_mm, std::size_t most) {
  const double radius = norm(arc.ahead);
  const double chords = std::ceil(arc.angle_rad / step_rad(radius, sag_mm));
  if (!(chords < static_cast<double>(most))) return too_many(most);
  Curve out;
  const auto n = static_cast<std::size_t>(std::max(chords, 2.0));
  for (std::size_t i = 0; i < n; ++i)
    out.points.push_back(at(arc, arc.angle_rad * static_cast<double>(i) / static_cast<double>(n)));
  out.points.front() = arc.from;
  out.points.push_back(arc.to);
  out.length_mm = radius * arc.angle_rad;
  return out;
}

Result<Curve> sample(const Spiral& spiral, double sag_mm, std::size_t most) {
  const double b = spiral.pitch_mm / (2 * pi);  // mm a rad
  const bool inwards = spiral.to_radius_mm < spiral.from_radius_mm;
  const double all = std::abs(spiral.to_radius_mm - spiral.from_radius_mm) / b;
  const double turn = spiral.clockwise ? -1 : 1;
  const auto radius = [&](double t) { return spiral.from_radius_mm + (inwards ? -b : b) * t; };
  const auto point = [&](double t) {
    const double angle = spiral.start_rad + turn * t;
    return spiral.centre + Vec3{std::cos(angle), std::sin(angle), 0} * radius(t);
  };
  Curve out;
  for (double t = 0; t < all;) {
    if (out.points.size() + 1 >= most) return too_many(most);
    out.points.push_back(point(t));
    // |p''| = hypot(r, 2 b), and r is at most this within the step. The path turns by 1 + b^2 / (r^2 + b^2) times its
    // angle: twice in the centre.
    const double r = radius(t), nearest = inwards ? std::max(0.0, r - b * kMostTurn) : r;
    double step = std::min(step_rad(std::hypot(r + b * kMostTurn, 2 * b), sag_mm),
                           kMostTurn / (1 + b * b / (nearest * nearest + b * b)));
    if (const double left = all - t; left < 2 * step) step = left > step ? left / 2 : left;
    t = t + step >= all * (1 - 1e-12) ? all : t + step;
  }
  out.points.push_back(point(all));
  out.length_mm = std::abs(spiral_length(spiral.to_radius_mm, b) - spiral_length(spiral.from_radius_mm, b));
  return out;
}

}  // namespace gantry::recipes
