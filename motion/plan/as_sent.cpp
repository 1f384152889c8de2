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
constexpr double kShortest_s = 0.1e-3;  // what is not free in so short a time is a hit
constexpr int kPerBreath = 32;          // pieces
constexpr double kLimits = 1.001;       // of the axes' acceleration, as plans keep it

}  // namespace

/// What one proof needs again and again.
struct AsSent::Asked {
  Margins margins;
  double clearance_mm;
  Proof proof{};
};

AsSent::AsSent(const Scene& scene, const Limits& limits, std::span<const Segment> motion)
    : scene_(scene), limits_(limits), motion_(motion), slow_mm_(beside_slow_mm(scene, limits)) {
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

/// With the common lag d, e_i = d_i - d, |t - t_m| <= w and a rate r in 0..1 axis i is sent q_i(t + r e_i), which is
/// off q_i(t_m) + v_i (t - t_m) by |v_i e_i| + a_i (w + |e_i|)^2 / 2 at most. Another lag than the middle one shifts
/// the times by the difference, by which w is larger.
AsSent::Sweep AsSent::along(const At& x, double half_s) const {
  const double d = middle_delay_s(x.v), w = half_s + std::abs(d - middle_s_);
  Sweep out{x.q, x.q, 0};
  AxisVec off{};
  for (const std::size_t i : axes_) {
    const double e = std::abs(limits_.response_delay_s[i] - d);
    out.from[i] -= x.v[i] * w, out.to[i] += x.v[i] * w;
    off[i] = std::abs(x.v[i]) * e + kLimits * limits_.axis[i].a_max * (w + e) * (w + e) / 2;
  }
  out.extra_mm = farthest_mm(scene_, off);
  return out;
}

/// The same from the path to the target of one moment, with what the time around it leaves open.
AsSent::Sweep AsSent::across(const At& x, double half_s) const {
  Sweep out{x.q, x.q, 0};
  AxisVec off{};
  for (const std::size_t i : axes_) {
    const double e = limits_.response_delay_s[i] - middle_s_, w = half_s + std::abs(e);
    out.to[i] += x.v[i] * e;
    off[i] = std::abs(x.v[i]) * half_s + kLimits * limits_.axis[i].a_max * w * w / 2;
  }
  out.extra_mm = farthest_mm(scene_, off);
  return out;
}

Result<void> AsSent::prove(double begin_s, double end_s, Asked& asked) const {
  const double half_s = (end_s - begin_s) / 2, middle_s = begin_s + half_s;
  const At x = at(middle_s);
  std::optional<Hit> hit;
  Sweep tried;
  for (const bool crosswise : {false, true}) {
    if (crosswise && 2 * half_s > kAcross_s) break;
    tried = crosswise ? across(x, half_s) : along(x, half_s);
    asked.margins.clearance_mm = asked.clearance_mm + tried.extra_mm;
    asked.proof.clear();
    hit = first_hit(scene_, tried.from, tried.to, asked.margins, &asked.proof);
    if (hit) continue;
    if (!is_free(scene_, tried.from, tried.to, asked.proof, asked.margins))
      return fail(Fault::Internal, "the two collision checks disagree on targets as they are sent");
    return {};
  }
  if (2 * half_s > kShortest_s) {
    if (auto r = prove(begin_s, middle_s, asked); !r) return r;
    return prove(middle_s, end_s, asked);
  }
  hit->clearance_mm = asked.clearance_mm;
  AxisVec beside{};
  for (const std::size_t i : axes_) beside[i] = x.v[i] * (limits_.response_delay_s[i] - middle_delay_s(x.v));
  return tl::unexpected(
      collision(scene_, *hit, tried.from, tried.to,
                fmt::format("{}: targets are sent {:.2g} mm beside the path there, because axes that move have unlike "
                            "response_delay",
                            describe(scene_, *hit), farthest_mm(scene_, beside))));
}

Result<void> AsSent::certify(double begin_s, double end_s, const ClearanceRules& rules, const Breath& breath) const {
  if (!beside_path()) return {};
  auto margins = make_margins(scene_, rules.clearance_mm, rules.approaches);
  if (!margins) return tl::unexpected(margins.error());
  constexpr double kNotAsked_mm = -1e9;
  for (PairMargin& pair : margins->pairs) pair.clearance_mm = kNotAsked_mm;
  Asked asked{*std::move(margins), rules.clearance_mm - slow_mm_};
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

/// As across() has it at next to no speed. Where one motion ends and another begins, the one has j d^3/6 to go when the
/// other has gone as much, which is less.
double beside_slow_mm(const Scene& scene, const Limits& limits) {
  std::vector<double> delay_s;
  const auto take = [&](bool there, std::size_t axis) {
    if (there) delay_s.push_back(limits.response_delay_s[axis]);
  };
  take(true, scene.x()), take(true, scene.y()), take(true, scene.z());
  take(scene.has_lift(), scene.u()), take(scene.turns(), scene.c());
  const auto [least, most] = std::minmax_element(delay_s.begin(), delay_s.end());
  if (*least == *most) return 0;
  const double w = kShortest_s + (*most - *least) / 2;
  AxisVec off{};
  for (std::size_t i = 0; i < limits.axes; ++i) off[i] = kLimits * limits.axis[i].a_max * w * w / 2;
  return farthest_mm(scene, off);
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
