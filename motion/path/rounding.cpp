#include "motion/path/rounding.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace gantry::motion {
namespace {

constexpr double kSamePoint = 1e-9;  ///< mm
constexpr double kSharp = 0.7;       ///< |d2 - d1| from which on a corner is sharp: about 40 degrees
constexpr double kReversal = -0.97;  ///< cosine: sharper than 166 degrees
constexpr double kChainShare = 0.9;  ///< of the tolerance, for a bend among short legs
constexpr double kFits = 0.65;       ///< of the room on a leg that a control point may take
constexpr double kShare = 0.49;      ///< of a leg that a corner at one of its ends may take
constexpr std::uint16_t kCornerCells = 24, kBendCells = 2;
constexpr std::size_t kContext = 14, kBatch = 64;  ///< legs
constexpr int kRounds = 4;                         ///< of fitting bends to the tolerance; each looks two legs farther

AxisVec plus(const AxisVec& a, double x, const AxisVec& b) {
  AxisVec out = a;
  for (std::size_t i = 0; i < kMaxAxes; ++i) out[i] += x * b[i];
  return out;
}

AxisVec minus(const AxisVec& a, const AxisVec& b) { return plus(a, -1, b); }

double dot(const Measure& m, const AxisVec& a, const AxisVec& b) {
  double sum = 0;
  for (std::size_t i = 0; i < m.axes; ++i)
    if (m.along[i]) sum += a[i] * b[i];
  return sum;
}

/// A unit vector square to d: towards `wanted` as far as it is, else along the first two path axes if there are.
AxisVec square_to(const Measure& m, const AxisVec& d, const AxisVec& wanted) {
  AxisVec best{};
  double best_length = 0;
  const auto offer = [&](const AxisVec& x, double enough) {
    AxisVec y{};
    const double on = dot(m, x, d);
    for (std::size_t i = 0; i < m.axes; ++i)
      if (m.along[i]) y[i] = x[i] - on * d[i];
    const double length = along(m, y);
    if (best_length == 0 && length > enough) {
      best_length = length;
      for (std::size_t i = 0; i < m.axes; ++i) best[i] = y[i] / length;
    }
  };
  offer(wanted, 1e-3);
  for (std::size_t i = 0; i < m.axes; ++i) {
    AxisVec e{};
    e[i] = m.along[i] ? 1 : 0;
    offer(e, 0.5);
  }
  return best;
}

enum class Kind : std::uint8_t { Rest, Bend, Sharp };

struct Leg {
  AxisVec direction{};
  double length = 0;
};

struct Corner {
  Kind kind = Kind::Rest;
  double room_mm = 0;   ///< how far the path may leave the corner
  double turn = 0;      ///< |d2 - d1|
  double reach_mm = 0;  ///< Sharp: where the cubic begins and ends; Bend: distance of the next control points
};

struct Control {
  AxisVec q{};
  double at = 0;           ///< knot
  std::size_t corner = 0;  ///< number of the vertex, or kNone
  std::size_t leg = 0;     ///< on which it lies or which it begins
};
constexpr std::size_t kNone = std::numeric_limits<std::size_t>::max();

class Shape {
 public:
  Shape(const Measure& m, std::span<const Vertex> v, double tolerance_mm) : m_(m), v_(v), tolerance_mm_(tolerance_mm) {
    for (std::size_t k = 0; k + 1 < v.size(); ++k) {
      Leg leg{minus(v[k + 1].q, v[k].q), 0};
      leg.length = along(m, leg.direction);
      for (double& x : leg.direction) x /= leg.length;
      legs_.push_back(leg);
    }
    corners_.resize(v.size());
    for (std::size_t k = 1; k + 1 < v.size(); ++k) classify(k);
    for (std::size_t k = 1; k + 1 < v.size(); ++k) limit(k);
    for (int round = 0;; ++round) {
      place_controls();
      if (round == kRounds || !fit()) break;
    }
  }

  /// Leg k from the corner at its start to and with the sharp corner at its end.
  void emit(std::size_t k, std::vector<Curve>& out) const {
    const Leg& leg = legs_[k];
    const Corner &from = corners_[k], &to = corners_[k + 1];
    AxisVec here = from.kind == Kind::Sharp ? plus(v_[k].q, from.reach_mm, leg.direction) : v_[k].q;
    for (std::size_t i = first_of_leg_[k]; i < controls_.size() && controls_[i].leg == k && i + 1 < controls_.size();
         ++i) {
      const bool bent = is_bend(i) || is_bend(i + 1);
      if (!bent) continue;
      const auto b = bezier(i);
      if (!is_bend(i)) line(here, b[0], leg, out);
      append_curve(m_, b, kBendCells, out);
      here = b[3];
    }
    if (to.kind == Kind::Bend) return;
    const double reach = to.kind == Kind::Sharp ? to.reach_mm : 0;
    const AxisVec& p = v_[k + 1].q;
    const AxisVec before = reach > 0 ? plus(p, -reach, leg.direction) : p;
    line(here, before, leg, out);
    if (to.kind == Kind::Sharp)
      append_curve(m_, {before, p, p, plus(p, reach, legs_[k + 1].direction)}, kCornerCells, out);
    else if (!out.empty())
      out.back().rest_after = true;
  }

 private:
  void classify(std::size_t k) {
    Corner& c = corners_[k];
    const AxisVec change = minus(legs_[k].direction, legs_[k - 1].direction);
    c.turn = aside(m_, change);
    c.room_mm = tolerance_mm_ - std::max(v_[k].aside_mm, v_[k + 1].aside_mm);
    const bool back = dot(m_, legs_[k].direction, legs_[k - 1].direction) < kReversal;
    if (v_[k].rest || c.room_mm <= 0 || back)
      c.kind = Kind::Rest;
    else
      c.kind = c.turn > kSharp ? Kind::Sharp : Kind::Bend;
  }

  // A sharp corner of turn t is left by d/8 |d2 - d1|, and the path is d/8 sin t from the nearer leg, which counts up
  // to a right angle; beyond, the corner is left by no more than a right-angled one. A bend with control points at
  // equal distances w by w/6 |d2 - d1|.
  void limit(std::size_t k) {
    Corner& c = corners_[k];
    const double share = std::min(legs_[k - 1].length * share_of(k - 1), legs_[k].length * share_of(k + 1));
    if (c.kind == Kind::Sharp) {
      const double cosine = 1 - c.turn * c.turn / 2, sine = std::sqrt(std::max(0.0, 1 - cosine * cosine));
      c.reach_mm = std::min(share, 8 * c.room_mm / (cosine > 0 ? sine : c.turn / std::numbers::sqrt2));
    }
    if (c.kind == Kind::Bend) {
      // Among legs that are short for it, the vertex itself is a control point between its neighbours. It is a point of
      // the polyline; half way along a leg the path is a quarter as far from the chord, and what was left out counts.
      const double full = 6 * kChainShare * tolerance_mm_ / c.turn;
      const bool chain = corners_[k - 1].kind == Kind::Bend && corners_[k + 1].kind == Kind::Bend;
      if (chain && std::max(legs_[k - 1].length, legs_[k].length) <= 1.4 * full) {
        c.reach_mm = full;
        c.room_mm = kChainShare * tolerance_mm_;
        return;
      }
      c.reach_mm = c.turn > 0 ? 6 * c.room_mm / c.turn : std::numeric_limits<double>::infinity();
      const double before = corners_[k - 1].kind == Kind::Bend ? legs_[k - 1].length : legs_[k - 1].length * kShare;
      const double after = corners_[k + 1].kind == Kind::Bend ? legs_[k].length : legs_[k].length * kShare;
      c.reach_mm = std::min({c.reach_mm, before, after});
    }
  }

  [[nodiscard]] double share_of(std::size_t neighbour) const {
    return corners_[neighbour].kind == Kind::Rest ? 2 * kShare : kShare;
  }

  /// Two control points beside each bend on a leg that has room for them.
  void points_on(std::size_t k, std::vector<double>& at) const {
    at.clear();
    const double length = legs_[k].length;
    const auto step = [&](std::size_t corner) {
      return corners_[corner].kind == Kind::Bend ? corners_[corner].reach_mm : 0;
    };
    const double a = step(k), b = step(k + 1);
    double low = 0, high = length;
    std::vector<double> from_end;
    const auto from_begin = [&] {
      if (a > 0 && a < kFits * (high - low)) at.push_back(low += a);
    };
    const auto from_back = [&] {
      if (b > 0 && b < kFits * (high - low)) from_end.push_back(high -= b);
    };
    for (int round = 0; round < 2; ++round) {
      if (a < b)
        from_begin(), from_back();
      else
        from_back(), from_begin();
    }
    at.insert(at.end(), from_end.rbegin(), from_end.rend());
  }

  void place_controls() {
    controls_.clear();
    first_of_leg_.assign(legs_.size(), 0);
    std::vector<double> at;
    double begin = 0;
    for (std::size_t k = 0; k < legs_.size(); ++k) {
      first_of_leg_[k] = controls_.size();
      controls_.push_back({v_[k].q, begin, k, k});
      points_on(k, at);
      for (const double x : at) controls_.push_back({plus(v_[k].q, x, legs_[k].direction), begin + x, kNone, k});
      begin += legs_[k].length;
    }
    controls_.push_back({v_.back().q, begin, v_.size() - 1, legs_.size()});
  }

  [[nodiscard]] bool is_bend(std::size_t i) const {
    return controls_[i].corner != kNone && corners_[controls_[i].corner].kind == Kind::Bend;
  }

  /// Beyond a rest or a sharp corner the control polygon goes straight on.
  [[nodiscard]] bool ends_span(std::size_t i) const { return controls_[i].corner != kNone && !is_bend(i); }

  /// Six controls around the interval from i to i + 1; phantoms where the span ends.
  std::array<Control, 6> around(std::size_t i) const {
    std::array<Control, 6> c;
    c[2] = controls_[i], c[3] = controls_[i + 1];
    const auto beyond = [](const Control& end, const Control& inner) {
      Control p = end;
      p.at += end.at - inner.at;
      p.q = plus(end.q, 1, minus(end.q, inner.q));
      return p;
    };
    bool ended = ends_span(i) || i == 0;
    std::size_t at = i;
    for (std::size_t n = 2; n-- > 0;) {
      if (ended) {
        c[n] = beyond(c[n + 1], c[n + 2]);
      } else {
        c[n] = controls_[--at];
        ended = ends_span(at) || at == 0;
      }
    }
    at = i + 1;
    ended = ends_span(at) || at + 1 == controls_.size();
    for (std::size_t n = 4; n < 6; ++n) {
      if (ended) {
        c[n] = beyond(c[n - 1], c[n - 2]);
      } else {
        c[n] = controls_[++at];
        ended = ends_span(at) || at + 1 == controls_.size();
      }
    }
    return c;
  }

  // The cubic spline between the knots of controls i and i + 1 as Bezier points, by blossoms: control n is
  // f(n-1, n, n+1), the Bezier points are f(i, i, i), f(i, i, i+1), f(i, i+1, i+1), f(i+1, i+1, i+1).
  [[nodiscard]] std::array<AxisVec, 4> bezier(std::size_t i) const {
    const auto c = around(i);
    const auto mix = [](const AxisVec& a, const AxisVec& b, double from, double at, double to) {
      return plus(a, (at - from) / (to - from), minus(b, a));
    };
    const AxisVec b1 = mix(c[2].q, c[3].q, c[1].at, c[2].at, c[4].at);
    const AxisVec b2 = mix(c[2].q, c[3].q, c[1].at, c[3].at, c[4].at);
    const AxisVec left = mix(c[1].q, c[2].q, c[0].at, c[2].at, c[3].at);
    const AxisVec right = mix(c[3].q, c[4].q, c[2].at, c[3].at, c[5].at);
    const AxisVec b0 = mix(left, b1, c[1].at, c[2].at, c[3].at);
    const AxisVec b3 = mix(b2, right, c[2].at, c[3].at, c[4].at);
    return {b0, b1, b2, b3};
  }

  /// Brings the control points nearer to bends that leave their corner too far. True when something was changed.
  bool fit() {
    bool changed = false;
    for (std::size_t k = 1; k + 1 < v_.size(); ++k) {
      Corner& c = corners_[k];
      if (c.kind != Kind::Bend) continue;
      const std::size_t i = first_of_leg_[k];
      AxisVec off = minus(bezier(i)[0], v_[k].q);
      AxisVec tangent = plus(legs_[k - 1].direction, 1, legs_[k].direction);
      const double on = dot(m_, off, tangent) / std::max(dot(m_, tangent, tangent), 1e-12);
      off = plus(off, -on, tangent);
      const double excess = aside(m_, off) / c.room_mm;
      if (excess <= 1 + 1e-6) continue;  // ties fall alike in every window
      const double before = controls_[i].at - controls_[i - 1].at, after = controls_[i + 1].at - controls_[i].at;
      c.reach_mm = std::min({c.reach_mm, before, after}) * std::max(0.3, 0.9 / excess);
      changed = true;
    }
    return changed;
  }

  void line(const AxisVec& from, const AxisVec& to, const Leg& leg, std::vector<Curve>& out) const {
    Curve g = straight_curve(m_, from, to);
    if (g.length > 1e-9 * leg.length && g.length > 1e-13) out.push_back(g);
  }

  const Measure& m_;
  std::span<const Vertex> v_;
  double tolerance_mm_;
  std::vector<Leg> legs_;
  std::vector<Corner> corners_;
  std::vector<Control> controls_;
  std::vector<std::size_t> first_of_leg_;
};

}  // namespace

// A reversal P becomes P - e n, P + e n with n square to the leg: two corners of about 90 degrees.
void Rounding::push(const Vertex& v) {
  seen_.push_back(v);
  if (seen_.size() < 3) {
    if (seen_.size() == 1) chain_.push_back(v);
    return;
  }
  const Vertex &a = seen_[0], &p = seen_[1], &b = seen_[2];
  const AxisVec in = minus(p.q, a.q), back = minus(b.q, p.q);
  const double length_in = along(measure_, in), length_back = along(measure_, back);
  const double room = tolerance_mm_ - std::max(p.aside_mm, b.aside_mm);
  if (!p.rest && room > 0 && dot(measure_, in, back) < kReversal * length_in * length_back) {
    AxisVec d = in;
    for (double& x : d) x /= length_in;
    const AxisVec side = square_to(measure_, d, plus(back, length_back, d));
    const double e = std::min({0.25 * room, 0.05 * length_in, 0.05 * length_back});
    Vertex first = p, second = p;
    first.q = plus(p.q, -e, side), second.q = plus(p.q, e, side);
    first.aside_mm += e, second.aside_mm = e;
    if (along(measure_, side) > 0) {
      chain_.push_back(first);
      seen_[2].aside_mm += e;
    }
    chain_.push_back(along(measure_, side) > 0 ? second : p);
  } else {
    chain_.push_back(p);
  }
  seen_.erase(seen_.begin());
}

void Rounding::emit(std::size_t first_leg, std::size_t end_leg, std::vector<Curve>& out) const {
  const Shape shape(measure_, chain_, tolerance_mm_);
  for (std::size_t k = first_leg; k < end_leg; ++k) shape.emit(k, out);
}

void Rounding::add(const Vertex& v, std::vector<Curve>& out) {
  if (!seen_.empty() && along(measure_, minus(v.q, seen_.back().q)) < kSamePoint) {
    seen_.back().aside_mm = std::max(seen_.back().aside_mm, v.aside_mm);
    return;
  }
  push(v);
  if (chain_.size() < done_ + kBatch + kContext) return;
  const std::size_t end = chain_.size() - kContext;
  emit(done_, end, out);
  const std::size_t keep = end > kContext ? end - kContext : 0;
  chain_.erase(chain_.begin(), chain_.begin() + static_cast<std::ptrdiff_t>(keep));
  done_ = end - keep;
}

void Rounding::finish(std::vector<Curve>& out) {
  if (seen_.size() > 1) chain_.push_back(seen_.back());
  if (chain_.size() > 1) emit(done_, chain_.size() - 1, out);
  seen_.clear(), chain_.clear();
  done_ = 0;
}

}  // namespace gantry::motion
