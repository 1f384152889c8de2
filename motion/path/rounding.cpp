#include "motion/path/rounding.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>

namespace gantry::motion {
namespace {

constexpr double kSamePoint = 1e-9;       ///< mm
constexpr double kStraightOn = 1e-10;     ///< |d2 - d1|
constexpr double kReversal = -0.97;       ///< cosine: sharper than 166 degrees
constexpr double kStraightBack = -0.985;  ///< cosine of a reversal that has no side; one that is none, with a
                                          ///< neighbour moved aside by 1/20 of the leg, is 3 degrees sharper at most
constexpr double kOfRadius = 0.5;         ///< of the radius on which legs turn that the path may leave them
constexpr double kShare = 0.49;           ///< of a leg that a corner at one of its ends may take
constexpr std::uint16_t kCornerCells = 48, kBendCells = 2;
constexpr std::size_t kBesideHard = 2;  ///< vertices before a sharp corner: how far it reaches depends on them
constexpr std::size_t kUncertain = 8;   ///< vertices at the end of a window: bends beyond may still reach there

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
  double room_mm = 0;  ///< how far the path may leave it
};

struct Corner {
  Kind kind = Kind::Rest;
  double room_mm = 0;   ///< how far the path may leave the corner
  double turn = 0;      ///< |d2 - d1|
  double reach_mm = 0;  ///< Sharp: where the cubic begins and ends; Bend: how far along the legs it may bend the path
  double step_mm = 0;   ///< distance of knots there
};

}  // namespace

/// A stretch of the chain on which the path is bent.
struct Rounding::Bent {
  double begin = 0, end = 0;
};

/// The chain of a window: legs, corners and what is bent.
class Rounding::Shape {
 public:
  Shape(const Measure& m, std::span<const Vertex> v, double tolerance_mm, bool by_vertex)
      : m_(m), v_(v), by_vertex_(by_vertex) {
    at_.push_back(0);
    for (std::size_t k = 0; k + 1 < v.size(); ++k) {
      Leg leg{minus(v[k + 1].q, v[k].q), 0, tolerance_mm - v[k + 1].aside_mm};
      leg.length = along(m, leg.direction);
      for (double& x : leg.direction) x /= leg.length;
      legs_.push_back(leg);
      at_.push_back(at_.back() + leg.length);
    }
    corners_.resize(v.size());
    keep_radii();
    for (std::size_t k = 1; k + 1 < v.size(); ++k) classify(k);
    for (std::size_t k = 1; k + 1 < v.size(); ++k) limit(k);
    even_steps();
  }

  [[nodiscard]] double at(std::size_t vertex) const { return at_[vertex]; }
  [[nodiscard]] const Corner& corner(std::size_t vertex) const { return corners_[vertex]; }
  [[nodiscard]] std::size_t leg_at(double s) const {
    const auto after = std::upper_bound(at_.begin(), at_.end(), s);
    return std::clamp<std::size_t>(static_cast<std::size_t>(after - at_.begin()), 1, legs_.size()) - 1;
  }
  [[nodiscard]] AxisVec point(std::size_t leg, double s) const {
    return plus(v_[leg].q, s - at_[leg], legs_[leg].direction);
  }

  /// Vertex at which the tool stands or a sharp corner is, or the chain ends, after vertex k.
  [[nodiscard]] std::size_t next_hard(std::size_t k) const {
    for (++k; k + 1 < v_.size() && corners_[k].kind == Kind::Bend;) ++k;
    return k;
  }

  /// What is bent between two hard vertices, in order.
  [[nodiscard]] std::vector<Bent> bent(std::size_t first, std::size_t last) const {
    std::vector<Bent> out;
    const double low = at_[first] + reach_of(first), high = at_[last] - reach_of(last);
    for (std::size_t k = first + 1; k < last; ++k) {
      const double reach = corners_[k].reach_mm;
      if (!(reach > 0)) continue;
      const double least = at_[k > kFarthest ? k - kFarthest : 0], most = at_[std::min(k + kFarthest, v_.size() - 1)];
      Bent b{std::max({low, least, at_[k] - reach}), std::min({high, most, at_[k] + reach})};
      while (!out.empty() && b.begin <= out.back().end + corners_[k].step_mm) {
        b.begin = std::min(b.begin, out.back().begin), b.end = std::max(b.end, out.back().end);
        out.pop_back();
      }
      out.push_back(b);
    }
    return out;
  }

  [[nodiscard]] double reach_of(std::size_t hard) const {
    return corners_[hard].kind == Kind::Sharp ? corners_[hard].reach_mm : 0;
  }

  [[nodiscard]] Guide guide(double begin, double end) const {
    Guide g;
    const std::size_t first = leg_at(begin + kSamePoint), last = leg_at(end - kSamePoint);
    g.at = {begin}, g.q = {point(first, begin)}, g.room_mm = {legs_[first].room_mm};
    for (std::size_t k = first + 1; k <= last; ++k)
      g.at.push_back(at_[k]), g.q.push_back(v_[k].q), g.room_mm.push_back(legs_[k].room_mm);
    g.at.push_back(end), g.q.push_back(point(last, end)), g.room_mm.push_back(legs_[last].room_mm);
    return g;
  }

  /// Knots from begin to end, as far apart as bends let them.
  [[nodiscard]] std::vector<double> knots(double begin, double end) const {
    constexpr double kFewest = 6;
    std::vector<double> steps;
    double s = begin, sum = 0;
    while (s < end) {
      const std::size_t leg = leg_at(s);
      const double h = std::min(corners_[leg].step_mm + kGrowth * (s - at_[leg]),
                                corners_[leg + 1].step_mm + kGrowth * std::max(0.0, at_[leg + 1] - s));
      steps.push_back(std::clamp(h, (end - begin) * 1e-4, (end - begin) / kFewest));
      sum += steps.back(), s += steps.back();
    }
    std::vector<double> out{begin};
    s = 0;
    for (const double h : steps) out.push_back(begin + (end - begin) * ((s += h) / sum));
    out.back() = end;
    return out;
  }

  void line(double from, double to, std::vector<Curve>& out) const {
    while (to - from > kSamePoint) {
      const std::size_t leg = leg_at(from + kSamePoint);
      const double until = leg + 1 < legs_.size() && at_[leg + 1] < to - kSamePoint ? at_[leg + 1] : to;
      out.push_back(straight_curve(m_, point(leg, from), point(leg, until)));
      from = until;
    }
  }

  void sharp(std::size_t k, std::vector<Curve>& out) const {
    const double reach = corners_[k].reach_mm;
    const AxisVec& p = v_[k].q;
    append_curve(m_, {plus(p, -reach, legs_[k - 1].direction), p, p, plus(p, reach, legs_[k].direction)}, kCornerCells,
                 out);
  }

 private:
  static constexpr std::size_t kFarthest = 4;  ///< vertices over which a bend may reach
  static constexpr double kGrowth = 0.3;       ///< of the distance of knots, for a distance from a vertex

  // Where the tolerance is as large as the radius on which legs turn, the fairest way within it is none: it folds.
  // Legs that come and go between two directions, as noise lets them, turn nowhere.
  void keep_radii() {
    constexpr double kTurned = 1;  ///< |d2 - d1|: about 60 degrees
    for (std::size_t k = 1; k + 1 < v_.size(); ++k)
      corners_[k].turn = aside(m_, minus(legs_[k].direction, legs_[k - 1].direction));
    const auto middle = [&](std::size_t leg) { return (at_[leg] + at_[leg + 1]) / 2; };
    for (std::size_t i = 0; i < legs_.size(); ++i) {
      const double far = kTurned * legs_[i].room_mm / kOfRadius;  // a turn over more of the way binds nothing
      for (std::size_t j = i + 1; j < legs_.size() && corners_[j].turn <= kSharp && middle(j) - middle(i) < far; ++j) {
        const double turn = aside(m_, minus(legs_[j].direction, legs_[i].direction));
        if (turn < kTurned) continue;
        const double most = kOfRadius * (middle(j) - middle(i)) / turn;
        for (std::size_t leg = i; leg <= j; ++leg) legs_[leg].room_mm = std::min(legs_[leg].room_mm, most);
        break;
      }
    }
  }

  void classify(std::size_t k) {
    Corner& c = corners_[k];
    c.room_mm = std::min(legs_[k - 1].room_mm, legs_[k].room_mm);
    const bool back = dot(m_, legs_[k].direction, legs_[k - 1].direction) < kStraightBack;
    if (v_[k].rest || c.room_mm <= 0 || back)
      c.kind = Kind::Rest;
    else
      c.kind = c.turn > kSharp ? Kind::Sharp : Kind::Bend;
  }

  // A sharp corner of turn t is left by d/8 |d2 - d1|, and the path is d/8 sin t from the nearer leg, which counts up
  // to a right angle; beyond, the corner is left by no more than a right-angled one.
  // A bend alone, of even third derivative over a length w before and after its vertex, leaves it by w/6 |d2 - d1|. At
  // the end of a chain of legs c with turns t, the transition from the line to the radius c/t takes sqrt(12 c room/t).
  void limit(std::size_t k) {
    Corner& c = corners_[k];
    const double share = std::min(legs_[k - 1].length * share_of(k - 1), legs_[k].length * share_of(k + 1));
    if (c.kind == Kind::Sharp) {
      const double cosine = 1 - c.turn * c.turn / 2, sine = std::sqrt(std::max(0.0, 1 - cosine * cosine));
      c.reach_mm = std::min(share, 8 * c.room_mm / (cosine > 0 && !by_vertex_ ? sine : c.turn / std::numbers::sqrt2));
    }
    if (c.kind == Kind::Bend && c.turn > kStraightOn) {
      constexpr double kAlone = 3, kReach = 2;
      const double alone = kAlone * c.room_mm / c.turn;
      const double leg = std::min(alone, std::max(legs_[k - 1].length, legs_[k].length));
      c.reach_mm = kReach * std::sqrt(12 * c.room_mm * leg / c.turn);
    }
  }

  [[nodiscard]] double share_of(std::size_t neighbour) const {
    return corners_[neighbour].kind == Kind::Rest ? 2 * kShare : kShare;
  }

  // A spline over knots at distance h follows a turn t within about h t/6: h times the turn that falls in it stays in
  // the room, for any vertices that lie together.
  void even_steps() {
    constexpr double kStep = 2;
    constexpr std::size_t kTogether = 6;
    for (std::size_t k = 0; k < corners_.size(); ++k) {
      Corner& c = corners_[k];
      c.step_mm = at_.back();
      double turn = 0;
      for (std::size_t j = k; j < std::min(corners_.size(), k + kTogether) && corners_[j].kind == Kind::Bend; ++j) {
        turn += corners_[j].turn;
        if (!(turn > kStraightOn)) continue;
        const double extent = at_[j] - at_[k], all = kStep * c.room_mm / turn;
        c.step_mm = std::min(c.step_mm, all >= extent ? all : std::sqrt(all * extent));
      }
    }
    for (std::size_t k = 1; k < corners_.size(); ++k)
      corners_[k].step_mm = std::min(corners_[k].step_mm, corners_[k - 1].step_mm + kGrowth * legs_[k - 1].length);
    for (std::size_t k = corners_.size() - 1; k-- > 0;)
      corners_[k].step_mm = std::min(corners_[k].step_mm, corners_[k + 1].step_mm + kGrowth * legs_[k].length);
  }

  const Measure& m_;
  std::span<const Vertex> v_;
  bool by_vertex_;
  std::vector<double> at_;
  std::vector<Leg> legs_;
  std::vector<Corner> corners_;
};

// From where the path has been laid to where it is certain.
bool Rounding::lay(bool last, std::vector<Curve>& out) {
  const Shape shape(measure_, chain_, tolerance_mm_, by_vertex_);
  const std::size_t n = chain_.size();
  const double safe = shape.at(last ? n - 1 : n - kUncertain), until = shape.at(last ? n - 1 : n - kContext);
  while (hard_ + 1 < n) {
    const std::size_t next = shape.next_hard(hard_);
    for (Bent b : shape.bent(hard_, next)) {
      if (b.end <= laid_ + kSamePoint) continue;
      b.begin = open_ ? laid_ : std::max(b.begin, laid_);
      const bool whole = b.end <= safe;
      if (!whole && b.begin >= until) return true;
      shape.line(laid_, b.begin, out);
      laid_ = b.begin;
      if (!bend(shape, next, b, whole ? b.end : until, safe, out)) return !open_ && rest_in(shape, b) && lay(last, out);
      if (!whole) return true;
    }
    if (shape.at(next) > safe) return true;
    shape.line(laid_, shape.at(next) - shape.reach_of(next), out);
    laid_ = shape.at(next) + shape.reach_of(next);
    if (next + 1 < n && shape.corner(next).kind == Kind::Sharp)
      shape.sharp(next, out);
    else if (next + 1 < n && !out.empty())
      out.back().rest_after = true;
    hard_ = next;
  }
  return true;
}

// Where no spline stays within the tolerance, the tool stands in the vertices instead.
bool Rounding::rest_in(const Shape& shape, const Bent& b) {
  bool any = false;
  for (std::size_t k = 1; k + 1 < chain_.size(); ++k)
    if (shape.at(k) > b.begin - kSamePoint && shape.at(k) < b.end + kSamePoint && !chain_[k].rest)
      chain_[k].rest = any = true, ++rests_;
  return any;
}

// The fairest spline over what is bent; of one that goes on beyond what is known, what lies before `until`.
bool Rounding::bend(const Shape& shape, std::size_t next, const Bent& b, double until, double safe,
                    std::vector<Curve>& out) {
  const auto kind = [&](double s, std::size_t vertex) {
    return std::abs(s - shape.at(vertex)) > kSamePoint ? FairEnd::OnLeg : FairEnd::Free;
  };
  const bool whole = until >= b.end;
  const double end = whole ? b.end : shape.at(next);
  const FairEnd end_kind = whole ? kind(b.end, next) : FairEnd::Free;
  FairEnd begin_kind = FairEnd::Given;
  FairSpline spline;
  std::vector<double> knots;
  if (open_) {
    spline = *open_;
    knots = shape.knots(spline.knots.back(), end);
    knots.erase(knots.begin());
  } else {
    begin_kind = kind(b.begin, hard_);
    knots = shape.knots(b.begin, end);
  }
  if (!fair(measure_, shape.guide(b.begin, end), begin_kind, end_kind, std::move(knots), spline)) return false;
  std::size_t count = spline.intervals();
  if (!whole)
    while (count > 0 && (spline.begin_of(count) > until || spline.knots[count + 4] > safe)) --count;
  if (count == 0) return true;
  for (std::size_t i = 0; i < count; ++i) append_curve(measure_, spline.bezier(i), kBendCells, out);
  laid_ = whole ? b.end : spline.begin_of(count);
  open_.reset();
  if (!whole) {
    const auto at = static_cast<std::ptrdiff_t>(count);
    open_ = FairSpline{{spline.knots.begin() + at, spline.knots.begin() + at + 5},
                       {spline.controls.begin() + at, spline.controls.begin() + at + 3}};
  }
  return true;
}

// A reversal P becomes P - e n, P + e n with n square to the leg: two corners of about 90 degrees.
void Rounding::push(const Vertex& v) {
  seen_.push_back(v);
  if (seen_.size() < 3) {
    if (seen_.size() == 1) chain_.push_back(v);
    return;
  }
  const Vertex &p = seen_[1], &b = seen_[2];
  const AxisVec in = minus(p.q, chain_.back().q), back = minus(b.q, p.q);
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

// What lies behind is forgotten, but for what still counts: the last hard vertex with its neighbours, or else bends
// that may reach over where the path has been laid to.
void Rounding::forget() {
  const Shape shape(measure_, chain_, tolerance_mm_, by_vertex_);
  std::size_t keep = hard_ > kBesideHard ? hard_ - kBesideHard : 0;
  if (const std::size_t leg = shape.leg_at(laid_); open_ && leg > hard_ + kKept) keep = leg - kKept;
  if (keep == 0) return;
  const double gone = shape.at(keep);
  chain_.erase(chain_.begin(), chain_.begin() + static_cast<std::ptrdiff_t>(keep));
  hard_ = hard_ > keep ? hard_ - keep : 0;
  laid_ -= gone;
  if (open_)
    for (double& t : open_->knots) t -= gone;
}

bool Rounding::add(const Vertex& v, std::vector<Curve>& out) {
  if (!seen_.empty() && along(measure_, minus(v.q, seen_.back().q)) < kSamePoint) {
    seen_.back().aside_mm = std::max(seen_.back().aside_mm, v.aside_mm);
    return true;
  }
  push(v);
  if (chain_.size() < next_) return true;
  if (!lay(false, out)) return false;
  forget();
  next_ = chain_.size() + kBatch;
  return true;
}

bool Rounding::finish(std::vector<Curve>& out) {
  if (seen_.size() > 1) chain_.push_back(seen_.back());
  const bool laid = chain_.size() < 2 || lay(true, out);
  const std::size_t rests = rests_;
  *this = Rounding(measure_, tolerance_mm_, by_vertex_);
  rests_ = rests;
  return laid;
}

}  // namespace gantry::motion
