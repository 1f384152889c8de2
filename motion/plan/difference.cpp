#include "motion/plan/difference.hpp"

#include <algorithm>
#include <cmath>

namespace gantry::motion {
namespace {

/// Corners of the sum of four segments, in the order of their angles (a zonogon).
void set_corners(Difference& d) {
  std::array<Vec2, 4> g = d.generator;
  for (Vec2& v : g)
    if (v.y < 0 || (v.y == 0 && v.x < 0)) v = v * -1;
  std::sort(g.begin(), g.end(), [](Vec2 a, Vec2 b) { return a.x * b.y - a.y * b.x > 0; });
  Vec2 at = (g[0] + g[1] + g[2] + g[3]) * -1;
  for (std::size_t i = 0; i < 4; ++i) {
    d.corner[i] = at, d.corner[i + 4] = at * -1;
    at = at + g[i] * 2;
  }
}

/// Vector from `p` to the nearest point of the eight-cornered figure; 0 inside.
Vec2 to_corners(const Difference& d, Vec2 p) {
  Vec2 best{};
  double best_square = -1;
  for (std::size_t i = 0; i < 8; ++i) {
    const Vec2 a = d.corner[i], edge = d.corner[(i + 1) % 8] - a, q = p - a;
    if (edge.y * q.x - edge.x * q.y <= 0) continue;  // not on the outer side of this edge
    const double t = std::clamp(dot(q, edge) / dot(edge, edge), 0.0, 1.0);
    const Vec2 v = edge * t - q;
    if (const double square = dot(v, v); best_square < 0 || square < best_square) best = v, best_square = square;
  }
  return best;
}

/// Vector from `p` (about the centre) to the figure; 0 inside.
Vec2 to_figure(const Difference& d, Vec2 p) {
  if (d.eight) return to_corners(d, p);
  const double x = d.cos * p.x + d.sin * p.y, y = d.cos * p.y - d.sin * p.x;
  const double vx = std::clamp(x, -d.half.x, d.half.x) - x, vy = std::clamp(y, -d.half.y, d.half.y) - y;
  return {d.cos * vx - d.sin * vy, d.sin * vx + d.cos * vy};
}

}  // namespace

Difference difference(const Solid& moving, const Solid& standing) {
  Difference d;
  d.centre = standing.centre - moving.centre;
  d.half_height = moving.half.z + standing.half.z;
  const bool two = moving.kind == Solid::Kind::Box && standing.kind == Solid::Kind::Box;
  const bool aligned = two && moving.cos == standing.cos && moving.sin == standing.sin;
  std::size_t count = 0;
  for (const Solid* s : {&moving, &standing}) {
    d.disc += s->disc;
    if (s->kind == Solid::Kind::Cylinder) d.disc += s->half.x;
    if (s->kind == Solid::Kind::Capsule) d.ball += s->half.x;
    if (s->kind != Solid::Kind::Box) continue;
    d.cos = s->cos, d.sin = s->sin;
    d.half = d.half + Vec2{s->half.x, s->half.y};
    d.generator[count++] = Vec2{s->cos, s->sin} * s->half.x;
    d.generator[count++] = Vec2{-s->sin, s->cos} * s->half.y;
  }
  d.eight = two && !aligned;
  if (d.eight) set_corners(d);
  return d;
}

Difference in_axes_along(const Difference& d, Vec2 x) {
  const auto turn = [x](Vec2 v) { return Vec2{dot(x, v), cross(x, v)}; };
  Difference out = d;
  const Vec2 centre = turn({d.centre.x, d.centre.y}), along = turn({d.cos, d.sin});
  out.centre = {centre.x, centre.y, d.centre.z};
  out.cos = along.x, out.sin = along.y;
  for (Vec2& v : out.corner) v = turn(v);
  for (Vec2& v : out.generator) v = turn(v);
  return out;
}

double flat_distance(const Difference& d, Vec2 at) {
  const Vec2 v = to_figure(d, at);
  return std::sqrt(dot(v, v));
}

Away away(const Difference& d, Vec3 displacement) {
  Away out;
  const Vec3 p = displacement - d.centre;
  const Vec2 v = to_figure(d, {p.x, p.y});
  const double length = std::sqrt(dot(v, v));
  out.flat = std::max(0.0, length - d.disc), out.up = std::max(0.0, std::abs(p.z) - d.half_height);
  const double apart = std::sqrt(out.flat * out.flat + out.up * out.up);
  out.distance = apart - d.ball;
  if (length > 0) out.towards = v * (1 / length);
  if (apart > 0)
    out.direction = Vec3{out.towards.x * out.flat, out.towards.y * out.flat, std::copysign(out.up, -p.z)} * (1 / apart);
  return out;
}

double reach(const Difference& d, Vec3 n) {
  double sum = d.ball + d.half_height * std::abs(n.z);
  if (d.disc > 0) sum += d.disc * std::sqrt(n.x * n.x + n.y * n.y);
  for (const Vec2 g : d.generator) sum += std::abs(g.x * n.x + g.y * n.y);
  return sum;
}

}  // namespace gantry::motion
