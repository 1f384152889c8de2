#include "motion/profile/straight.hpp"

#include <algorithm>
#include <cmath>

#include "motion/profile/arrive.hpp"
#include "motion/profile/open_trajectory.hpp"

namespace gantry::motion {
namespace {

constexpr double kCollinear = 1e-12;  // relative: what doubles leave of a line that was meant

/// One vector over the axes for each of: the displacement, speeds and accelerations at both ends.
using Picks = double (*)(const AxisMove&);
constexpr Picks kVectors[] = {
    [](const AxisMove& m) { return m.to.p - m.from.p; },
    [](const AxisMove& m) { return m.from.v; },
    [](const AxisMove& m) { return m.to.v; },
    [](const AxisMove& m) { return m.from.a; },
    [](const AxisMove& m) { return m.to.a; },
};

struct Line {
  AxisVec direction{};  // largest component 1
  double along[5] = {};
};

double largest(std::span<const AxisMove> axes, Picks pick, std::size_t& at) noexcept {
  double most = 0;
  for (std::size_t i = 0; i < axes.size(); ++i)
    if (axes[i].enabled && std::abs(pick(axes[i])) > most) most = std::abs(pick(axes[i])), at = i;
  return most;
}

bool line_of(std::span<const AxisMove> axes, Line& line) noexcept {
  bool known = false;
  for (std::size_t k = 0; k < std::size(kVectors); ++k) {
    std::size_t main = 0;
    if (largest(axes, kVectors[k], main) == 0) continue;
    const double value = kVectors[k](axes[main]);
    if (!known) {
      for (std::size_t i = 0; i < axes.size(); ++i)
        line.direction[i] = axes[i].enabled ? kVectors[k](axes[i]) / value : 0;
      known = true;
    }
    line.along[k] = value / line.direction[main];
    for (std::size_t i = 0; i < axes.size(); ++i)
      if (axes[i].enabled &&
          !(std::abs(kVectors[k](axes[i]) - line.along[k] * line.direction[i]) <= kCollinear * std::abs(line.along[k])))
        return false;
  }
  return known;
}

/// Bounds of the scalar, which starts at 0: within all axes' own.
AxisBounds bounds_of(std::span<const AxisMove> axes, const AxisVec& direction) noexcept {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  AxisBounds b(kInfinity, kInfinity, kInfinity);
  const auto tighten = [](double& most, double& least, double high, double low, double d) {
    most = std::min(most, (d > 0 ? high : low) / d);
    least = std::max(least, (d > 0 ? low : high) / d);
  };
  for (std::size_t i = 0; i < axes.size(); ++i) {
    const double d = direction[i];
    if (d == 0) continue;
    const AxisBounds& a = axes[i].bounds;
    tighten(b.v_max, b.v_min, a.v_max, a.v_min, d);
    tighten(b.a_max, b.a_min, a.a_max, a.a_min, d);
    tighten(b.j_max, b.j_min, a.j_max, a.j_min, d);
    tighten(b.p_max, b.p_min, a.p_max - axes[i].from.p, a.p_min - axes[i].from.p, d);
  }
  return b;
}

}  // namespace

bool move_straight(std::span<const AxisMove> axes, const Together& how, Joint& out) noexcept {
  Line line;
  if (!line_of(axes, line)) return false;
  const State from{0, line.along[1], line.along[3]}, to{line.along[0], line.along[2], line.along[4]};
  OpenTrajectory trajectory(from, to, bounds_of(axes, line.direction), how.outside);
  if (trajectory.reason() != Reason::Solved) return false;
  const double t =
      common_duration(std::span(&trajectory, 1), std::max(trajectory.shortest_s(), how.min_duration_s), how.cycle_s);
  Profile scalar;
  if (t < 0 || !trajectory.write(t, scalar)) return false;
  out.duration_s = t;
  out.straight = true;
  for (std::size_t i = 0; i < axes.size(); ++i) {
    Profile profile{axes[i].from, {}};
    if (axes[i].enabled)
      for (const Phase& phase : scalar.phases)
        profile.phases.push_back({phase.duration_s, phase.jerk * line.direction[i]});
    out.profiles.push_back(profile);
  }
  out.reason = Reason::Solved;
  return true;
}

}  // namespace gantry::motion
