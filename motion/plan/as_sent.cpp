#include "motion/plan/as_sent.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

#include "motion/geometry.hpp"
#include "motion/plan/verify.hpp"
#include "motion/profile/speed_profile.hpp"

namespace gantry::motion {
namespace {

constexpr double kFirst_s = 0.016;      // of a motion is looked at as one; what is not free as that in halves
constexpr double kAcross_s = 0.002;     // from here on across the path, too
constexpr double kShortest_s = 0.1e-3;  // what is not free in so short a time is a hit,
constexpr double kFinest_s = 4e-6;      // where it sets out and comes to rest, in this
constexpr int kRates = 4;               // parts of the rates, in so short a time
constexpr int kPerBreath = 32;          // pieces
constexpr double kLimits = 1.001;       // of the axes' acceleration and jerk, as plans keep them
constexpr double kOneLine = 1e-12;      // of the directions of two segments on one line

/// The largest speed between two moments of a profile.
double fastest(const SpeedProfile& profile, double from_s, double to_s) {
  State x{0, profile.v0, profile.a0};
  double most = 0, begin_s = 0;
  const std::size_t n = profile.phases.size();
  for (std::size_t k = 0; k < n && begin_s <= to_s; ++k) {
    const Phase& phase = profile.phases[k];
    const double from = std::clamp(from_s - begin_s, 0.0, phase.duration_s),
                 to = std::clamp(to_s - begin_s, 0.0, phase.duration_s);
    if (begin_s + phase.duration_s >= from_s) {
      most = std::max({most, advanced(x, phase.jerk, from).v, advanced(x, phase.jerk, to).v});
      const double top = phase.jerk < 0 ? x.a / -phase.jerk : 0;
      if (top > from && top < to) most = std::max(most, advanced(x, phase.jerk, top).v);
    }
    x = advanced(x, phase.jerk, phase.duration_s);
    begin_s += phase.duration_s;
  }
  return most;
}

double acceleration(const Segment& s, double t, std::size_t axis) {
  const State x = along(s.nominal, t).x;
  GeometryJet g;
  differentiate<2>(s.geometry, std::clamp(x.p, 0.0, s.geometry.length), g);
  return g.d2[axis] * x.v * x.v + g.d1[axis] * x.a;
}

}  // namespace

/// What one proof needs again and again.
struct AsSent::Asked {
  Margins margins;
  double clearance_mm;
  Proof proof{};
};

AsSent::AsSent(const Scene& scene, const Limits& limits, std::span<const Segment> motion)
    : scene_(scene), limits_(limits), motion_(motion) {
  unsigned moving = 0;
  double end_s = 0;
  for (const Segment& s : motion) {
    if (s.kind != SegmentKind::Dwell) moving |= s.geometry.moving;
    ends_s_.push_back(end_s += motion::duration(s.nominal));
  }
  const auto counts = [&](std::size_t axis) {
    return axis == scene.x() || axis == scene.y() || axis == scene.z() || (scene.has_lift() && axis == scene.u()) ||
           (scene.turns() && axis == scene.c());
  };
  for (std::size_t i = 0; i < limits.axes; ++i)
    if ((moving >> i & 1u) != 0 && counts(i)) axes_.push_back(i);
  if (axes_.empty()) return;
  const auto& delay_s = limits.response_delay_s;
  const auto [least, most] =
      std::minmax_element(axes_.begin(), axes_.end(), [&](auto a, auto b) { return delay_s[a] < delay_s[b]; });
  middle_s_ = (delay_s[*least] + delay_s[*most]) / 2, spread_s_ = delay_s[*most] - delay_s[*least];
}

/// Before its start and after its end it stands.
AsSent::At AsSent::at(double t) const {
  const auto next = std::upper_bound(ends_s_.begin(), ends_s_.end(), t);
  const bool over = next == ends_s_.end();
  const auto k = static_cast<std::size_t>(next - ends_s_.begin()) - (over ? 1 : 0);
  const Segment& s = motion_[k];
  const double begin_s = k > 0 ? ends_s_[k - 1] : 0;
  if (s.kind == SegmentKind::Dwell) return {point(s.geometry, 0), {}};
  const State x = motion::along(s.nominal, t - begin_s).x;
  GeometryJet g;
  differentiate<1>(s.geometry, std::clamp(x.p, 0.0, s.geometry.length), g);
  At out{g.q, {}};
  if (t >= 0 && !over)
    for (const std::size_t i : axes_) out.v[i] = g.d1[i] * x.v;
  return out;
}

/// The lag common to all axes that leaves the targets least beside the path at these speeds.
double AsSent::middle_delay_s(const AxisVec& v) const {
  double sum = 0, weighted = 0;
  for (const std::size_t i : axes_) sum += v[i] * v[i], weighted += v[i] * v[i] * limits_.response_delay_s[i];
  return sum > 0 ? weighted / sum : middle_s_;
}

AsSent::Around AsSent::around(double begin_s, double end_s) const {
  begin_s -= spread_s_ / 2, end_s += spread_s_ / 2;
  Around out;
  const auto first =
      static_cast<std::size_t>(std::lower_bound(ends_s_.begin(), ends_s_.end(), begin_s) - ends_s_.begin());
  const auto each = [&](const auto& look) {
    for (std::size_t k = first; k < motion_.size(); ++k) {
      const double starts_s = k > 0 ? ends_s_[k - 1] : 0;
      if (starts_s > end_s) break;
      if (motion_[k].kind == SegmentKind::Dwell) continue;
      look(motion_[k], std::max(0.0, begin_s - starts_s), std::min(ends_s_[k], end_s) - starts_s);
    }
  };
  unsigned moving = 0;
  each([&](const Segment& s, double, double) {
    const bool begins = moving == 0;
    moving |= s.geometry.moving;
    const AxisVec direction = derivative<1>(s.geometry, 0);
    if (begins) out.line = true, out.direction = direction;
    out.line = out.line && s.geometry.degree == 1;
    for (std::size_t i = 0; i < direction.size(); ++i)
      out.line = out.line && std::abs(direction[i] - out.direction[i]) <= kOneLine;
  });
  const auto moves = [&](std::size_t axis) { return (moving >> axis & 1u) != 0; };
  double least_s = HUGE_VAL, most_s = 0;
  for (const std::size_t i : axes_)
    if (moves(i)) {
      least_s = std::min(least_s, limits_.response_delay_s[i]);
      most_s = std::max(most_s, limits_.response_delay_s[i]);
    }
  out.beside_path = most_s > least_s;
  if (!out.beside_path) return out;
  each([&](const Segment& s, double from_s, double to_s) {
    if (out.line) out.fastest = std::max(out.fastest, fastest(s.nominal, from_s, to_s));
    for (const std::size_t i : axes_) {
      if ((s.geometry.moving >> i & 1u) == 0) continue;
      const double at_ends = std::min(std::abs(acceleration(s, from_s, i)), std::abs(acceleration(s, to_s, i)));
      const double bound =
          std::min(kLimits * limits_.axis[i].a_max, at_ends + kLimits * limits_.axis[i].j_max * (to_s - from_s));
      out.acceleration[i] = std::max(out.acceleration[i], bound);
    }
  });
  return out;
}

/// Axis i is sent q_i(t + r e_i) with e_i = d_i - d, d a lag that is the same for all, and a rate r in 0..1. Another
/// lag than the middle one shifts the times by the difference. On a line, with s(t) its way and u its direction, that
/// is u_i (s(t + r e_i) - s(t)) beside a point of the line: at most |u_i e_i| times the speed. d being the mean with
/// weights u_i^2, all of it is across the line. Elsewhere it is off the tangent at t_m by |v_i e_i| + a_i (w + |e_i|)^2
/// / 2 at most, for |t - t_m| <= w.
AsSent::Sweep AsSent::along(const At& x, const Around& near, double middle_s, double half_s) const {
  const double d = middle_delay_s(near.line ? near.direction : x.v), w = half_s + std::abs(d - middle_s_);
  Sweep out{x.q, x.q, 0};
  AxisVec off{};
  if (near.line) {
    out.from = at(middle_s - w).q, out.to = at(middle_s + w).q;
    for (const std::size_t i : axes_)
      off[i] = near.fastest * std::abs(near.direction[i] * (limits_.response_delay_s[i] - d));
  } else {
    for (const std::size_t i : axes_) {
      const double e = std::abs(limits_.response_delay_s[i] - d);
      out.from[i] -= x.v[i] * w, out.to[i] += x.v[i] * w;
      off[i] = std::abs(x.v[i]) * e + near.acceleration[i] * (w + e) * (w + e) / 2;
    }
  }
  out.extra_mm = farthest_mm(scene_, off);
  return out;
}

/// From one rate to another at one moment: no farther off that line than a_i (r1 - r0)^2 e_i^2 / 8, and with what the
/// time around it leaves open.
AsSent::Sweep AsSent::across(const At& x, const Around& near, double middle_s, double half_s, double from_rate,
                             double to_rate) const {
  Sweep out{x.q, x.q, 0};
  AxisVec off{};
  for (const std::size_t i : axes_) {
    const double e = limits_.response_delay_s[i] - middle_s_, part = (to_rate - from_rate) * e;
    out.from[i] = at(middle_s + from_rate * e).q[i], out.to[i] = at(middle_s + to_rate * e).q[i];
    const double a = near.acceleration[i], v = near.line ? std::abs(near.direction[i]) * near.fastest
                                                         : std::abs(x.v[i]) + a * (half_s + std::abs(e));
    off[i] = v * half_s + a * part * part / 8;
  }
  out.extra_mm = farthest_mm(scene_, off);
  return out;
}

/// Nothing: it is free, by both checks.
Result<std::optional<Hit>> AsSent::hit_by(const Sweep& sweep, Asked& asked) const {
  asked.margins.clearance_mm = asked.clearance_mm + sweep.extra_mm;
  asked.proof.clear();
  auto hit = first_hit(scene_, sweep.from, sweep.to, asked.margins, &asked.proof);
  if (!hit && !is_free(scene_, sweep.from, sweep.to, asked.proof, asked.margins))
    return fail(Fault::Internal, "the two collision checks disagree on targets as they are sent");
  return hit;
}

Result<void> AsSent::prove(double begin_s, double end_s, Asked& asked) const {
  const double half_s = (end_s - begin_s) / 2, middle_s = begin_s + half_s;
  const Around near = around(begin_s, end_s);
  if (!near.beside_path) return {};
  const At x = at(middle_s);
  Sweep tried = along(x, near, middle_s, half_s);
  auto hit = hit_by(tried, asked);
  if (!hit) return tl::unexpected(hit.error());
  if (!*hit) return {};
  const bool fine = 2 * half_s <= kShortest_s;
  if (2 * half_s <= kAcross_s) {
    const int parts = fine ? kRates : 1;
    for (int k = 0; k < parts; ++k) {
      tried = across(x, near, middle_s, half_s, static_cast<double>(k) / parts, (k + 1.0) / parts);
      hit = hit_by(tried, asked);
      if (!hit) return tl::unexpected(hit.error());
      if (*hit) break;
    }
    if (!*hit) return {};
  }
  // Where it sets out and comes to rest targets are next to nothing off the path, and a shorter time decides.
  const bool at_rest = middle_s < 2 * spread_s_ || middle_s > duration_s() - 2 * spread_s_;
  if (!fine || (at_rest && 2 * half_s > kFinest_s)) {
    if (auto r = prove(begin_s, middle_s, asked); !r) return r;
    return prove(middle_s, end_s, asked);
  }
  (*hit)->clearance_mm = asked.clearance_mm;
  AxisVec beside{};
  for (const std::size_t i : axes_) beside[i] = x.v[i] * (limits_.response_delay_s[i] - middle_delay_s(x.v));
  return tl::unexpected(
      collision(scene_, **hit, tried.from, tried.to,
                fmt::format("{}: targets are sent {:.2g} mm beside the path there, because axes that move have unlike "
                            "response_delay",
                            describe(scene_, **hit), farthest_mm(scene_, beside))));
}

Result<void> AsSent::certify(double begin_s, double end_s, const ClearanceRules& rules, const Breath& breath) const {
  if (!beside_path()) return {};
  auto margins = make_margins(scene_, rules.clearance_mm, rules.approaches);
  if (!margins) return tl::unexpected(margins.error());
  constexpr double kNotAsked_mm = -1e9;
  for (PairMargin& pair : margins->pairs) pair.clearance_mm = kNotAsked_mm;
  Asked asked{*std::move(margins), rules.clearance_mm};
  // Axes that are ahead have set out before the middle of them has, and others come to rest after it.
  if (begin_s <= 0) begin_s -= spread_s_ / 2;
  if (end_s >= duration_s()) end_s += spread_s_ / 2;
  const double pieces = std::max(1.0, std::ceil((end_s - begin_s) / kFirst_s));
  for (int n = 0; n < pieces; ++n) {
    if (n % kPerBreath == 0 && !go_on(breath)) return given_up();
    const double piece_s = (end_s - begin_s) / pieces;
    if (auto r = prove(begin_s + n * piece_s, begin_s + (n + 1) * piece_s, asked); !r) return r;
  }
  return {};
}

double farthest_mm(const Scene& scene, const AxisVec& d) {
  const double lift = scene.has_lift() ? std::abs(d[scene.u()]) : 0;
  double turned = 0;
  if (scene.turns())
    for (const SceneBody& body : scene.head()) turned = std::max(turned, body.turning_mm * std::abs(d[scene.c()]));
  return std::hypot(d[scene.x()], d[scene.y()], std::abs(d[scene.z()]) + lift) + turned;
}

/// With u the line's direction and s(t) its way, axis i is sent u_i s(t + e_i): |s(t + e_i) - s(t)| <= v |e_i|.
double beside_line_mm(const Limits& limits, const Segment& line) {
  const AxisVec u = derivative<1>(line.geometry, 0);
  double sum = 0, mean = 0, square = 0;
  for (std::size_t i = 0; i < limits.axes; ++i) {
    const double weight = u[i] * u[i], d = limits.response_delay_s[i];
    sum += weight, mean += weight * d, square += weight * d * d;
  }
  return sum > 0 ? line.v_cap * std::sqrt(std::max(0.0, square - mean * mean / sum)) : 0;
}

}  // namespace gantry::motion
