#include "motion/plan/gap.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include "motion/plan/difference.hpp"

namespace gantry::motion {
namespace {

constexpr int kLooks = 120;
constexpr double kMeasured_mm = 1e-9;

/// One end of the part of the motion that holds the minimum.
struct End {
  double t = 0, distance = 0, slope = 0;  ///< slope: of the distance over t
  bool seen = false;
};

/// Where the tangents at both ends meet; every third time, and where they do not, the middle.
double next_look(const End& low, const End& high, int look) {
  const double middle = (low.t + high.t) / 2, bend = high.slope - low.slope;
  if (look % 3 == 2 || !(bend > 0)) return middle;
  const double t = (low.distance - high.distance + high.slope * high.t - low.slope * low.t) / bend;
  return t > low.t && t < high.t ? t : middle;
}

class Search {
 public:
  Search(const Difference& d, Vec3 sweep) : d_(d), sweep_(sweep) {}

  /// `done(gap)` says when enough is known.
  template <class Done>
  Gap run(const Done& done) {
    const double square = dot(sweep_, sweep_);
    End low{0}, high{1};
    double t = square > 0 ? std::clamp(dot(d_.centre, sweep_) / square, 0.0, 1.0) : 0.0;
    for (int look = 0; look < kLooks; ++look) {
      const Away a = away(d_, sweep_ * t);
      if (a.distance < best_.upper) best_.upper = a.distance, best_.fraction = t;
      if (a.direction == Vec3{}) return best_;  // they overlap beyond their rounding
      try_along(a.direction);
      const double slope = -dot(a.direction, sweep_);
      if (look > 0 && look % 2 == 0) try_across(a);
      if (done(best_) || slope == 0 || (slope < 0 && t == 1) || (slope > 0 && t == 0)) return best_;
      (slope < 0 ? low : high) = {t, a.distance, slope, true};
      t = !low.seen ? 0 : !high.seen ? 1 : next_look(low, high, look);
      if (low.seen && high.seen && (t == low.t || t == high.t)) return best_;
    }
    return best_;
  }

 private:
  void try_along(Vec3 unit) {
    const double room = dot(unit, d_.centre) - std::max(0.0, dot(unit, sweep_)) - reach(d_, unit);
    if (room > best_.lower) best_.lower = room, best_.direction = unit;
  }
  void try_both(Vec3 n) {
    const double length = norm(n);
    if (length < 1e-9 * norm(sweep_)) return;
    const Vec3 unit = n * (1 / length);
    try_along(unit * std::copysign(1.0, dot(unit, d_.centre - sweep_ * 0.5)));
  }
  /// Planes that contain the motion: across it and an upright edge, across it and the edge that is nearest, and the one
  /// that is nearest to the direction seen.
  void try_across(const Away& a) {
    try_both(cross({0, 0, 1}, sweep_));
    try_both(cross({-a.towards.y, a.towards.x, 0}, sweep_));
    const Vec3 without = a.direction - sweep_ * (dot(a.direction, sweep_) / dot(sweep_, sweep_));
    if (const double length = norm(without); length > 1e-6) try_along(without * (1 / length));
  }

  const Difference& d_;
  Vec3 sweep_;
  Gap best_;
};

}  // namespace

Gap gap(const Solid& moving, Vec3 sweep, const Solid& standing, double decide_at) {
  const Difference d = difference(moving, standing);
  return Search(d, sweep).run([decide_at](const Gap& g) { return g.lower > decide_at || g.upper <= decide_at; });
}

Gap measure_gap(const Solid& moving, Vec3 sweep, const Solid& standing) {
  const Difference d = difference(moving, standing);
  return Search(d, sweep).run([](const Gap& g) { return g.upper - g.lower <= kMeasured_mm; });
}

Gap gap_below(const Solid& moving, Vec3 sweep, const Solid& standing, double known) {
  const Difference d = difference(moving, standing);
  Gap g = Search(d, sweep).run(
      [known](const Gap& seen) { return seen.lower >= known || seen.upper - seen.lower <= kMeasured_mm; });
  if (g.lower >= known) g.upper = std::max(g.upper, known);
  return g;
}

double first_contact(const Solid& moving, Vec3 sweep, const Solid& standing, double margin) {
  const Difference d = difference(moving, standing);
  const auto near = [&](double t) { return away(d, sweep * t).distance <= margin; };
  if (near(0)) return 0;
  const Gap g = Search(d, sweep).run([margin](const Gap& seen) { return seen.upper <= margin; });
  if (g.upper > margin) return 1;
  double free = 0, hit = g.fraction;  // convex: before the contact the distance only falls
  while (hit - free > 1e-15 * hit && (free + hit) / 2 > free && (free + hit) / 2 < hit) {
    const double middle = (free + hit) / 2;
    (near(middle) ? hit : free) = middle;
  }
  return hit;
}

namespace {

/// The point of a body's figure (rectangle or disc, without a capsule's rounding) that is nearest to `p`.
Vec2 nearest_in(const Solid& s, Vec2 p) {
  const Vec2 c = flat(s.centre), d = p - c;
  if (s.kind == Solid::Kind::Box) {
    const Vec2 q{s.cos * d.x + s.sin * d.y, s.cos * d.y - s.sin * d.x};
    const Vec2 in{std::clamp(q.x, -s.half.x, s.half.x), std::clamp(q.y, -s.half.y, s.half.y)};
    return c + Vec2{s.cos * in.x - s.sin * in.y, s.sin * in.x + s.cos * in.y};
  }
  const double radius = s.kind == Solid::Kind::Cylinder ? s.half.x : 0.0, length = norm(d);
  return length <= radius ? p : c + d * (radius / length);
}

/// Counter-clockwise.
std::array<Vec2, 4> corners(const Solid& s) {
  std::array<Vec2, 4> out;
  for (std::size_t i = 0; i < 4; ++i) {
    const double x = i == 0 || i == 3 ? s.half.x : -s.half.x, y = i < 2 ? s.half.y : -s.half.y;
    out[i] = flat(s.centre) + Vec2{s.cos * x - s.sin * y, s.sin * x + s.cos * y};
  }
  return out;
}

/// The middle of the corners of what two rectangles share: one is cut by the sides of the other, one after the other
/// (Sutherland, Hodgman 1974).
std::optional<Vec2> middle_of_shared(const Solid& a, const Solid& b) {
  const auto of_a = corners(a), sides = corners(b);
  std::vector<Vec2> left(of_a.begin(), of_a.end()), cut;
  for (std::size_t i = 0; i < 4 && !left.empty(); ++i) {
    const Vec2 from = sides[i], along = sides[(i + 1) % 4] - from;
    const auto inner = [&](Vec2 p) { return along.x * (p.y - from.y) - along.y * (p.x - from.x); };
    cut.clear();
    for (std::size_t k = 0; k < left.size(); ++k) {
      const Vec2 p = left[k], q = left[(k + 1) % left.size()];
      const double at_p = inner(p), at_q = inner(q);
      if (at_p >= 0) cut.push_back(p);
      if ((at_p < 0) != (at_q < 0)) cut.push_back(p + (q - p) * (at_p / (at_p - at_q)));
    }
    left.swap(cut);
  }
  if (left.empty()) return std::nullopt;
  Vec2 sum;
  for (const Vec2 p : left) sum = sum + p;
  return sum * (1.0 / static_cast<double>(left.size()));
}

/// A point of b's figure that is nearest to a's; where they overlap, of both. Of two rectangles that are apart one of
/// the nearest points is a corner.
Vec2 nearest_of_figures(const Solid& a, const Solid& b) {
  if (a.kind != Solid::Kind::Box) return nearest_in(b, flat(a.centre));
  if (b.kind != Solid::Kind::Box) return nearest_in(b, nearest_in(a, flat(b.centre)));
  if (const auto shared = middle_of_shared(a, b)) return *shared;
  Vec2 best = flat(b.centre);
  double best_square = std::numeric_limits<double>::infinity();
  const auto take = [&](Vec2 on_a, Vec2 on_b) {
    const Vec2 v = on_a - on_b;
    if (dot(v, v) < best_square) best_square = dot(v, v), best = on_b;
  };
  for (const Vec2 p : corners(a)) take(p, nearest_in(b, p));
  for (const Vec2 p : corners(b)) take(nearest_in(a, p), p);
  return best;
}

}  // namespace

Vec3 nearest_point(const Solid& a, const Solid& b) {
  const Vec2 on_b = nearest_of_figures(a, b), on_a = nearest_in(a, on_b);
  const double low = std::max(a.centre.z - a.half.z, b.centre.z - b.half.z);
  const double high = std::min(a.centre.z + a.half.z, b.centre.z + b.half.z);
  // Of both bodies without their rounding; where their heights overlap, in the middle.
  Vec3 p{on_b.x, on_b.y, (low + high) / 2}, q{on_a.x, on_a.y, p.z};
  if (low > high) {
    const double up = std::copysign(1.0, b.centre.z - a.centre.z);
    p.z = b.centre.z - up * b.half.z, q.z = a.centre.z + up * a.half.z;
  }
  if (b.kind != Solid::Kind::Capsule) return p;
  const double apart = norm(q - p);
  return apart <= b.half.x ? q : p + (q - p) * (b.half.x / apart);
}

}  // namespace gantry::motion
