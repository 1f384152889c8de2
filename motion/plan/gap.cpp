#include "motion/plan/gap.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace gantry::motion {
namespace {

constexpr int kIterations = 128;
constexpr double kMeasured_mm = 1e-7;

constexpr Vec3 cross(Vec3 a, Vec3 b) { return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x}; }

/// A point of the difference standing - swept, and the two points that it comes from.
struct Vertex {
  Vec3 w, moving, standing;
};

struct Simplex {
  std::array<Vertex, 4> at;
  std::array<double, 4> share{};  // barycentric coordinates of the point nearest to the origin
  int size = 0;
};

/// Each nearest_* leaves the smallest part of the simplex that holds the point nearest to the origin, with its shares
/// (Ericson, Real-Time Collision Detection, 5.1).
void keep(Simplex& s, std::initializer_list<std::pair<int, double>> part) {
  Simplex out;
  for (const auto& [i, share] : part) {
    out.at[static_cast<std::size_t>(out.size)] = s.at[static_cast<std::size_t>(i)];
    out.share[static_cast<std::size_t>(out.size++)] = share;
  }
  s = out;
}

void nearest_on_segment(Simplex& s) {
  const Vec3 a = s.at[0].w, ab = s.at[1].w - a;
  const double length = dot(ab, ab), t = length > 0 ? -dot(a, ab) / length : 0.0;
  if (t <= 0) return keep(s, {{0, 1.0}});
  if (t >= 1) return keep(s, {{1, 1.0}});
  keep(s, {{0, 1 - t}, {1, t}});
}

void nearest_on_triangle(Simplex& s) {
  const Vec3 a = s.at[0].w, b = s.at[1].w, c = s.at[2].w, ab = b - a, ac = c - a;
  const double d1 = -dot(ab, a), d2 = -dot(ac, a);
  if (d1 <= 0 && d2 <= 0) return keep(s, {{0, 1.0}});
  const double d3 = -dot(ab, b), d4 = -dot(ac, b);
  if (d3 >= 0 && d4 <= d3) return keep(s, {{1, 1.0}});
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return keep(s, {{0, 1 - d1 / (d1 - d3)}, {1, d1 / (d1 - d3)}});
  const double d5 = -dot(ab, c), d6 = -dot(ac, c);
  if (d6 >= 0 && d5 <= d6) return keep(s, {{2, 1.0}});
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return keep(s, {{0, 1 - d2 / (d2 - d6)}, {2, d2 / (d2 - d6)}});
  const double va = d3 * d6 - d5 * d4, on_bc = (d4 - d3) + (d5 - d6);
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) return keep(s, {{1, 1 - (d4 - d3) / on_bc}, {2, (d4 - d3) / on_bc}});
  const double sum = va + vb + vc;
  keep(s, {{0, va / sum}, {1, vb / sum}, {2, vc / sum}});
}

Vec3 combine(const Simplex& s, Vec3 Vertex::*of) {
  Vec3 sum;
  for (int i = 0; i < s.size; ++i) {
    const auto k = static_cast<std::size_t>(i);
    sum = sum + s.at[k].*of * s.share[k];
  }
  return sum;
}

/// The nearest of the faces that have the origin on their outer side; the whole when there is none: the origin is in.
void nearest_on_tetrahedron(Simplex& s) {
  constexpr std::array<std::array<std::size_t, 4>, 4> kFaces{{{0, 1, 2, 3}, {0, 2, 3, 1}, {0, 3, 1, 2}, {1, 3, 2, 0}}};
  Simplex best;
  double best_square = std::numeric_limits<double>::infinity();
  for (const auto& f : kFaces) {
    const Vec3 a = s.at[f[0]].w, n = cross(s.at[f[1]].w - a, s.at[f[2]].w - a);
    const double origin = -dot(n, a), opposite = dot(n, s.at[f[3]].w - a);
    if (origin * opposite > 0) continue;  // a flat tetrahedron has opposite == 0 and is searched on all faces
    Simplex face;
    face.size = 3;
    face.at[0] = s.at[f[0]], face.at[1] = s.at[f[1]], face.at[2] = s.at[f[2]];
    nearest_on_triangle(face);
    const Vec3 p = combine(face, &Vertex::w);
    if (dot(p, p) < best_square) best = face, best_square = dot(p, p);
  }
  if (best.size > 0) s = best;
}

/// The search itself; `done(lower, upper)` says when enough is known.
template <class Done>
Gap search(const Solid& moving, Vec3 sweep, const Solid& standing, const Done& done) {
  const double round = rounding(moving) + rounding(standing);
  const auto vertex = [&](Vec3 direction) {  // of the difference, furthest along `direction`
    Vertex v;
    v.standing = core_support(standing, direction);
    v.moving = core_support(moving, direction * -1);
    if (dot(direction, sweep) < 0) v.moving = v.moving + sweep;
    v.w = v.standing - v.moving;
    return v;
  };

  Gap best;
  Simplex s;
  Vec3 v = standing.centre - (moving.centre + sweep * 0.5);
  if (dot(v, v) == 0) v = {0, 0, 1};
  double v_square = std::numeric_limits<double>::infinity();
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    const Vertex next = vertex(v * -1);
    const double length = norm(v), lower = dot(v, next.w) / length - round;
    if (lower > best.lower) best.lower = lower, best.direction = v * (1 / length);
    if (done(best)) return best;
    for (int i = 0; i < s.size; ++i)
      if (s.at[static_cast<std::size_t>(i)].w == next.w) return best;  // no nearer point exists
    s.at[static_cast<std::size_t>(s.size++)] = next;
    switch (s.size) {
      case 1: s.share[0] = 1; break;
      case 2: nearest_on_segment(s); break;
      case 3: nearest_on_triangle(s); break;
      default: nearest_on_tetrahedron(s); break;
    }
    v = combine(s, &Vertex::w);
    const double square = dot(v, v);
    if (s.size == 4 || square < 1e-24) {  // the cores meet
      best.upper = -round;
      return best;
    }
    const double upper = std::sqrt(square) - round;
    if (upper < best.upper) {
      best.upper = upper;
      const Vec3 unit = v * (1 / std::sqrt(square));
      best.on_moving = combine(s, &Vertex::moving) + unit * rounding(moving);
      best.on_standing = combine(s, &Vertex::standing) - unit * rounding(standing);
    }
    if (done(best) || square >= v_square) return best;  // rounding stops progress: what is proved so far stands
    v_square = square;
  }
  return best;
}

}  // namespace

Gap gap(const Solid& moving, Vec3 sweep, const Solid& standing, double decide_at) {
  return search(moving, sweep, standing,
                [decide_at](const Gap& g) { return g.lower > decide_at || g.upper <= decide_at; });
}

Gap measure_gap(const Solid& moving, Vec3 sweep, const Solid& standing) {
  return search(moving, sweep, standing, [](const Gap& g) { return g.upper - g.lower <= kMeasured_mm; });
}

}  // namespace gantry::motion
