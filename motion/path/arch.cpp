#include "motion/path/arch.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "motion/geometry.hpp"
#include "motion/path/gauss.hpp"
#include "motion/path/moves.hpp"
#include "motion/profile/line_bounds.hpp"
#include "motion/profile/speed_profile.hpp"

namespace gantry::motion {
namespace {

constexpr double kSame_s = 1e-8;  // moments that rounding has made two of

/// One of the three motions and when it begins.
struct Stroke {
  std::optional<Segment> line;
  double lasts_s = 0, begin_s = 0;
  [[nodiscard]] double end_s() const { return begin_s + lasts_s; }
};

Stroke stroke(const Limits& limits, const AxisVec& from, const AxisVec& to) {
  Stroke out;
  const std::vector<Segment> move = line_move(limits, from, to);
  if (!move.empty()) out.line = move.front(), out.lasts_s = duration(move.front().nominal);
  return out;
}

double down_to_ticks(double seconds, double tick_s) { return std::floor(seconds / tick_s + 1e-9) * tick_s; }

/// Time that is left of the motion up when it has gone so far.
double left_of(const Stroke& up, double gone_mm, double tick_s) {
  if (!up.line || gone_mm >= up.line->geometry.length) return 0;
  return down_to_ticks(up.lasts_s - time_at(up.line->nominal, std::max(gone_mm, 0.0)), tick_s);
}

/// q = from + v T u + a T^2/2 u^2 + j T^3/6 u^3 of each axis, u = t/T.
using Coefficients = std::array<std::array<double, 3>, kMaxAxes>;

/// What a motion along `direction` adds from `begin_s` on, over a time in which its jerk is constant.
void add(Coefficients& c, const AxisVec& direction, const SpeedProfile& motion, double begin_s, double T) {
  const State now = along(motion, begin_s).x;
  const double jerk = along(motion, begin_s + T / 2).jerk;
  for (std::size_t i = 0; i < kMaxAxes; ++i) {
    const std::array more{direction[i] * now.v * T, direction[i] * now.a * T * T / 2,
                          direction[i] * jerk * T * T * T / 6};
    for (std::size_t k = 0; k < more.size(); ++k) c[i][k] += more[k];
  }
}

/// Path length over u from 0 to 1.
double length_of(const Limits& limits, const Coefficients& c) {
  return integral([&](double u) {
    double square = 0;
    for (std::size_t i = 0; i < limits.axes; ++i)
      if (limits.linear[i]) square += std::pow(c[i][0] + u * (2 * c[i][1] + u * 3 * c[i][2]), 2);
    return std::sqrt(square);
  });
}

/// A piece that is a cubic in time.
Segment cubic(const Limits& limits, const AxisVec& from, const Coefficients& c, double T) {
  Segment s;
  s.feature = kTravel;
  s.kind = SegmentKind::Piece;
  s.rests = false;
  Geometry& g = s.geometry;
  g.from = from;
  g.degree = 3;
  g.u = {1, 0, 0, 0, 0};
  std::size_t n = 0;
  for (std::size_t i = 0; i < kMaxAxes; ++i) {
    if (c[i] == std::array<double, 3>{}) continue;
    g.moving = static_cast<std::uint16_t>(g.moving | 1u << i);
    for (const double x : c[i]) g.c[n++] = x;
  }
  g.length = g.whole = length_of(limits, c);
  if (n == 0) g = straight(from, {}, 0);
  s.nominal.v0 = g.length / T;
  s.nominal.phases.push_back({T, 0});
  return s;
}

/// What rounding has made two of is one moment; the last one stays as it is.
void sort_moments(std::vector<double>& moments) {
  std::sort(moments.begin(), moments.end());
  const double end = moments.empty() ? 0 : moments.back();
  const auto same = [](double a, double b) { return b - a < kSame_s; };
  moments.erase(std::unique(moments.begin(), moments.end(), same), moments.end());
  if (!moments.empty()) moments.back() = end;
}

void add_moments(std::vector<double>& moments, const SpeedProfile& motion, double begin_s) {
  moments.push_back(begin_s);
  for (const Phase& phase : motion.phases) moments.push_back(begin_s += phase.duration_s);
}

/// The three together.
class Together {
 public:
  Together(const Limits& limits, const AxisVec& from, const std::array<Stroke, 3>& strokes)
      : limits_(limits), from_(from), strokes_(strokes) {
    for (const Stroke& stroke : strokes_)
      if (stroke.line) add_moments(moments_, stroke.line->nominal, stroke.begin_s);
    sort_moments(moments_);
  }

  Arch arch() {
    Arch out;
    const Stroke* alone = nullptr;
    for (std::size_t n = 0; n + 1 < moments_.size(); ++n) {
      const double begin = moments_[n], end = moments_[n + 1];
      const auto now = under_way((begin + end) / 2);
      if (now[1] != nullptr) {
        out.segments.push_back(curve(begin, end));
        alone = nullptr;
        continue;
      }
      if (now[0] != alone || !extend(out.segments.back(), *alone, begin, end)) {
        alone = now[0];
        out.segments.push_back(line(*alone, begin));
        extend(out.segments.back(), *alone, begin, end);
      }
      if (alone == &strokes_[0]) out.up = out.segments.size();
      if (alone == &strokes_[2] && out.down == 0) out.down = out.segments.size();
    }
    if (out.down > 0) out.down = out.segments.size() - out.down + 1;
    if (!out.segments.empty()) out.segments.back().rests = true;
    return out;
  }

 private:
  [[nodiscard]] std::array<const Stroke*, 2> under_way(double t) const {
    std::array<const Stroke*, 2> out{};
    std::size_t n = 0;
    for (const Stroke& stroke : strokes_)
      if (stroke.line && t > stroke.begin_s && t < stroke.end_s() && n < out.size()) out[n++] = &stroke;
    return out;
  }

  [[nodiscard]] AxisVec at(double t) const {
    AxisVec q = from_;
    for (const Stroke& stroke : strokes_) {
      if (!stroke.line || t <= stroke.begin_s) continue;
      const Geometry& g = stroke.line->geometry;
      const AxisVec on = point(g, t >= stroke.end_s() ? g.length : along(stroke.line->nominal, t - stroke.begin_s).x.p);
      for (std::size_t i = 0; i < kMaxAxes; ++i)
        if ((g.moving >> i & 1u) != 0) q[i] = on[i];
    }
    return q;
  }

  /// A part of one of the motions that begins there; its phases are added.
  [[nodiscard]] Segment line(const Stroke& stroke, double begin) const {
    Segment s = *stroke.line;
    s.kind = SegmentKind::Piece;
    s.rests = false;
    const State x = along(stroke.line->nominal, begin - stroke.begin_s).x;
    s.nominal = {x.v, x.a, {}};
    s.geometry = straight(at(begin), {}, 0);
    return s;
  }
  /// False: it has as many phases as it can have.
  bool extend(Segment& s, const Stroke& stroke, double begin, double end) const {
    const Geometry& whole = stroke.line->geometry;
    const double jerk = along(stroke.line->nominal, (begin + end) / 2 - stroke.begin_s).jerk;
    if (!s.nominal.phases.push_back({end - begin, jerk})) return false;
    const double length = along(s.nominal, duration(s.nominal)).x.p;
    AxisVec displacement = derivative<1>(whole, 0);
    for (double& d : displacement) d *= length;
    s.geometry = straight(s.geometry.from, displacement, length);
    return true;
  }

  /// Two motions at once, each at constant jerk.
  [[nodiscard]] Segment curve(double begin, double end) const {
    Coefficients c{};
    double v_cap = 0;
    for (const Stroke* stroke : under_way((begin + end) / 2)) {
      add(c, derivative<1>(stroke->line->geometry, 0), stroke->line->nominal, begin - stroke->begin_s, end - begin);
      v_cap = std::max(v_cap, stroke->line->v_cap);
    }
    Segment s = cubic(limits_, at(begin), c, end - begin);
    s.v_cap = v_cap;
    return s;
  }

  const Limits& limits_;
  AxisVec from_;
  const std::array<Stroke, 3>& strokes_;
  std::vector<double> moments_;
};

bool only_up(const AxisVec& a, const AxisVec& b, std::size_t up) {
  for (std::size_t i = 0; i < kMaxAxes; ++i)
    if (i != up && a[i] != b[i]) return false;
  return true;
}

AxisVec at_height(AxisVec q, std::size_t up, double height) {
  q[up] = height;
  return q;
}

}  // namespace

std::optional<ArchSpec> arch_over(std::span<const AxisVec> polyline, std::size_t up) {
  std::optional<std::size_t> across;
  for (std::size_t i = 0; i + 1 < polyline.size(); ++i) {
    const AxisVec &a = polyline[i], &b = polyline[i + 1];
    if (!only_up(a, b, up)) {
      if (across) return std::nullopt;
      across = i;
    } else if (across ? b[up] > a[up] : b[up] < a[up]) {
      return std::nullopt;
    }
  }
  if (!across) return std::nullopt;
  ArchSpec out{polyline.front(), polyline.back(), up, std::max(polyline[*across][up], polyline[*across + 1][up])};
  if (out.top <= out.from[up] && out.top <= out.to[up]) return std::nullopt;
  return out;
}

Arch arch(const Limits& limits, const ArchSpec& spec) {
  const AxisVec over_from = at_height(spec.from, spec.up, spec.top), over_to = at_height(spec.to, spec.up, spec.top);
  std::array<Stroke, 3> strokes{stroke(limits, spec.from, over_from), stroke(limits, over_from, over_to),
                                stroke(limits, over_to, spec.to)};
  auto& [up, across, down] = strokes;
  // Down, backwards, is up: a motion from rest to rest is its own mirror image.
  double early = left_of(up, spec.leave_mm, limits.tick_s), late = left_of(down, spec.arrive_mm, limits.tick_s);
  if (early + late > across.lasts_s) {
    const double half = down_to_ticks(across.lasts_s / 2, limits.tick_s);
    early = std::min(early, std::max(half, across.lasts_s - late));
    late = std::min(late, across.lasts_s - early);
  }
  across.begin_s = up.lasts_s - early;
  down.begin_s = across.end_s() - late;
  return Together(limits, spec.from, strokes).arch();
}

std::vector<Segment> fall_into(const Limits& limits, const Segment& run_up, std::size_t up, double fall_mm) {
  const AxisVec forward = derivative<1>(run_up.geometry, 0);
  AxisVec downward{};
  downward[up] = -1;
  // What the run-up leaves of the axis, where it goes up or down itself.
  const Bounds along_it = line_bounds(limits, forward), alone = line_bounds(limits, downward);
  const double used = std::abs(forward[up]);
  const double v_end = along(run_up.nominal, duration(run_up.nominal)).x.v;
  const Bounds left{alone.v - used * v_end, alone.a - used * along_it.a, alone.j - used * along_it.j};
  const Plan down = move({0, 0, 0}, {fall_mm, 0, 0}, left);
  if (!down) return {};
  const double shortest_s = duration(down.profile), fall_s = whole_ticks(shortest_s, limits.tick_s);
  SpeedProfile fall;
  for (const Phase& phase : stretched(down.profile, fall_s / shortest_s).phases) fall.phases.push_back(phase);

  const double run_up_s = duration(run_up.nominal), end_s = std::max(fall_s, run_up_s);
  const double falls_at = end_s - fall_s, goes_at = end_s - run_up_s;
  std::vector<double> moments;
  add_moments(moments, fall, falls_at);
  add_moments(moments, run_up.nominal, goes_at);
  sort_moments(moments);
  std::vector<Segment> out;
  for (std::size_t n = 0; n + 1 < moments.size(); ++n) {
    const double begin = moments[n], T = moments[n + 1] - begin, middle = begin + T / 2;
    AxisVec from = point(run_up.geometry, along(run_up.nominal, begin - goes_at).x.p);
    from[up] += fall_mm - along(fall, begin - falls_at).x.p;
    Coefficients c{};
    if (middle > falls_at) add(c, downward, fall, begin - falls_at, T);
    if (middle > goes_at) add(c, forward, run_up.nominal, begin - goes_at, T);
    Segment& s = out.emplace_back(cubic(limits, from, c, T));
    s.v_cap = run_up.v_cap, s.block = run_up.block, s.feature = run_up.feature;
  }
  return out;
}

}  // namespace gantry::motion
