#include "motion/path/sound.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdio>

#include "motion/path/series.hpp"

namespace gantry::motion {
namespace {

constexpr double kOver = 1.001;      // of a limit
constexpr int kSamples = 4;          // of each phase, and its end
constexpr double kSame_mm = 1e-6;    // or rad; and of a segment's length, where that is more than 1
constexpr double kStands = 1e-5;     // of an axis' speed: it stands
constexpr double kSameSpeed = 1e-4;  // of an axis' speed, from one segment to the next
constexpr double kSameBend = 5e-3;   // of an axis' acceleration there
constexpr double kBack_mm_s = 1e-6;

/// Position, speed and acceleration of every axis.
struct Axes {
  std::array<AxisVec, 3> d{};
};

/// Of the n-th axis that moves on a curve, around the places u, u^2, u^3.
Series of_axis(const Geometry& g, std::size_t n, const std::array<Series, 3>& u) {
  Series q{};
  for (std::size_t m = 0; m < 3; ++m)
    for (std::size_t k = 0; k < 4; ++k) q[k] += g.c[3 * n + m] * u[m][k];
  return q;
}

/// As an arch's pieces are, which are played evenly: u is s / whole.
bool is_cubic_in_time(const Geometry& g) { return g.u == std::array<double, 5>{1, 0, 0, 0, 0}; }

/// u, u^2 and u^3 of a curve around s = p + v t + a t^2/2 + j t^3/6.
std::array<Series, 3> powers(const Geometry& g, const State& x, double jerk) {
  const double per = 1 / g.whole;
  const Series on{(g.begin + x.p) * per, x.v * per, x.a / 2 * per, jerk / 6 * per};
  const Series u = is_cubic_in_time(g) ? on : polynomial([&](std::size_t k) { return k == 0 ? 0 : g.u[k - 1]; }, 5, on);
  const Series squared = times(u, u);
  return {u, squared, times(squared, u)};
}

/// Does `what` for each axis that moves: its number, and the series of its motion.
template <class What>
void for_axes(const Geometry& g, const State& x, double jerk, What what) {
  if (g.degree == 0 || !(g.whole > 0)) return;
  const bool line = g.degree == 1;
  const std::array<Series, 3> u = line ? std::array<Series, 3>{} : powers(g, x, jerk);
  std::size_t n = 0;
  for (unsigned moving = g.moving; moving != 0; moving &= moving - 1, ++n) {
    const auto i = static_cast<std::size_t>(std::countr_zero(moving));
    const double d1 = line ? g.c[n] / g.whole : 0;
    what(i, line ? Series{d1 * (g.begin + x.p), d1 * x.v, d1 * x.a / 2, d1 * jerk / 6} : of_axis(g, n, u));
  }
}

Axes axes_at(const Geometry& g, const State& x) {
  Axes out;
  out.d[0] = g.from;
  for_axes(g, x, 0,
           [&](std::size_t i, const Series& q) { out.d[0][i] += q[0], out.d[1][i] = q[1], out.d[2][i] = 2 * q[2]; });
  return out;
}

class Look {
 public:
  Look(const Limits& limits, std::span<const Segment> capped) : limits_(limits), capped_(capped) {}

  /// In their order. False: `why` says what does not hold.
  bool see(const Segment& s) {
    ++number_;
    const Axes begin = axes_at(s.geometry, {0, s.nominal.v0, s.nominal.a0});
    if (!joins(begin)) return false;
    last_ = begin, rests_ = true;
    if (s.kind == SegmentKind::Dwell) return true;
    State x{0, s.nominal.v0, s.nominal.a0};
    for (const Phase& phase : s.nominal.phases)
      if (!keeps(s, x, phase)) return false;
    if (std::abs(x.p - s.geometry.length) > close(s))
      return refuse("ends %.9g mm from its end", x.p - s.geometry.length);
    last_ = axes_at(s.geometry, x);
    rests_ = s.rests;
    return !rests_ || stands(last_);
  }
  /// Nothing goes on behind the last one.
  bool ends() { return rests_ || refuse("%s", "is the last one and does not rest at its end"); }

  std::string why;

 private:
  static double close(const Segment& s) { return kSame_mm * std::max(1.0, s.geometry.length); }

  template <class... Values>
  bool refuse(const char* what, Values... values) {
    char text[160], all[200];
    std::snprintf(text, sizeof text, what, values...);
    std::snprintf(all, sizeof all, "segment %zu %s", number_, text);
    why = all;
    return false;
  }

  bool stands(const Axes& x) {
    for (std::size_t i = 0; i < limits_.axes; ++i)
      if (std::abs(x.d[1][i]) > kStands * limits_.axis[i].v_max)
        return refuse("moves axis %zu at %.6g a second where it is to stand", i, x.d[1][i]);
    return true;
  }

  bool joins(const Axes& begin) {
    if (number_ > 1)
      for (std::size_t i = 0; i < limits_.axes; ++i)
        if (const double off = begin.d[0][i] - last_.d[0][i]; !(std::abs(off) <= kSame_mm))
          return refuse("begins %.9g from where the one before ends, in axis %zu", off, i);
    if (rests_) return stands(begin);
    for (std::size_t i = 0; i < limits_.axes; ++i) {
      const double faster = begin.d[1][i] - last_.d[1][i], bent = begin.d[2][i] - last_.d[2][i];
      if (!(std::abs(faster) <= kSameSpeed * limits_.axis[i].v_max))
        return refuse("begins at another speed than the one before ends, in axis %zu by %.6g a second", i, faster);
      if (!(std::abs(bent) <= kSameBend * limits_.axis[i].a_max))
        return refuse("begins with another acceleration, in axis %zu by %.6g", i, bent);
    }
    return true;
  }

  /// Goes on through the phase.
  bool keeps(const Segment& s, State& x, const Phase& phase) {
    const bool is_capped = !capped_.empty() && &s >= &capped_.front() && &s <= &capped_.back();
    const double turns_s = phase.jerk != 0 ? -x.a / phase.jerk : 0;
    if (!(phase.duration_s >= 0) || !std::isfinite(phase.duration_s + phase.jerk))
      return refuse("has a phase of %.6g s", phase.duration_s);
    // On a line the axes go as s does: what is greatest is so at the phase's end, where the last one has ended, or
    // where the speed turns.
    const bool turns = turns_s > 0 && turns_s < phase.duration_s, line = s.geometry.degree <= 1;
    const int step = line ? kSamples + 1 : is_cubic_in_time(s.geometry) && phase.jerk == 0 ? kSamples / 2 : 1;
    for (int n = turns ? -1 : line ? kSamples : 0; n <= kSamples; n += n < 0 ? (line ? kSamples + 1 : 1) : step) {
      const State y = advanced(x, phase.jerk, n < 0 ? turns_s : phase.duration_s * n / kSamples);
      if (!(y.v >= -kBack_mm_s)) return refuse("goes back at %.6g mm/s, %.6g mm from its start", y.v, y.p);
      if (!(y.p >= -close(s) && y.p <= s.geometry.length + close(s)))
        return refuse("leaves its %.9g mm: %.9g mm", s.geometry.length, y.p);
      if (is_capped && !(y.v <= kOver * s.v_cap))
        return refuse("goes at %.6g mm/s, where %.6g mm/s are set", y.v, s.v_cap);
      for_axes(s.geometry, y, phase.jerk, [&](std::size_t i, const Series& q) {
        const AxisLimits& l = limits_.axis[i];
        const double v = std::abs(q[1]), a = std::abs(2 * q[2]), j = std::abs(6 * q[3]);
        if (!(v <= kOver * l.v_max && a <= kOver * l.a_max && j <= kOver * l.j_max))
          refuse("takes axis %zu to v %.5f, a %.5f, j %.5f of its limits", i, v / l.v_max, a / l.a_max, j / l.j_max);
      });
      if (!why.empty()) return false;
    }
    x = advanced(x, phase.jerk, phase.duration_s);
    return true;
  }

  const Limits& limits_;
  std::span<const Segment> capped_;
  std::size_t number_ = 0;
  Axes last_;  ///< at the end of the one before
  bool rests_ = true;
};

}  // namespace

std::optional<std::string> unsound(const Limits& limits, std::span<const Segment> segments,
                                   std::span<const Segment> capped) {
  Look look(limits, capped);
  for (const Segment& s : segments)
    if (!look.see(s)) return std::move(look.why);
  if (!look.ends()) return std::move(look.why);
  return std::nullopt;
}

}  // namespace gantry::motion
