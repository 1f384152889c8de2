#include "motion/profile/open_trajectory.hpp"

#include <algorithm>
#include <cmath>

namespace gantry::motion {
OpenTrajectory::OpenTrajectory(const State& from, const State& to, const AxisBounds& bounds, Outside outside) noexcept
    : entered_{from, {}}, to_(to), bounds_(bounds), scale_(bounds) {
  inside_ = enter(from, bounds, outside, entered_);
  scale_p_ = position_scale(from, to, bounds);
  entered_s_ = duration(entered_);
  p_ = (to.p - inside_.p) / scale_.p;
  resolution_ = kResolution * scale_p_ / scale_.p;
  reachable_.emplace(scale_.ends(inside_, to), scale_.box);
  const bool walls = std::isfinite(bounds.p_min) || std::isfinite(bounds.p_max);
  if ((ramp_ = one_ramp(entered_, inside_, to, bounds))) {
    shortest_s_ = entered_s_ + ramp_->duration_s;
    if (walls) route_.emplace().duration_s = ramp_->duration_s;
    reason_ = Reason::Solved;
    return;
  }
  if (walls) {
    enter_corridor();
    return;
  }
  shortest_ = reachable_->first(p_, resolution_);
  shortest_s_ = entered_s_ + shortest_.duration * scale_.t;
  if (shortest_.side != scaled::Side::None) reason_ = Reason::Solved;
}

Corridor OpenTrajectory::corridor() const noexcept {
  return {inside_, to_, bounds_, resolution_ * scale_.p, entered_.phases.size()};
}

void OpenTrajectory::enter_corridor() noexcept {
  Corridor within = corridor();
  if (within.inside(entered_)) route_ = within.shortest();
  shortest_s_ = entered_s_ + (route_ ? route_->duration_s : kNever);
  reason_ = route_ && *route_ ? Reason::Solved : route_ ? within.reason_of_none() : Reason::StartCannotStay;
}

double OpenTrajectory::first_s(double t) noexcept {
  if (t <= shortest_s_ * (1 + kEqual)) return shortest_s_;
  if (route_) {
    const double had = entered_s_ + route_->duration_s;
    if (std::abs(t - had) <= kEqual * t) return had;
    route_ = corridor().first(t - entered_s_);
    return *route_ ? entered_s_ + route_->duration_s : -1;
  }
  const scaled::Found found = reachable_->first(p_, resolution_, (t - entered_s_) / scale_.t);
  return found.side == scaled::Side::None ? -1 : entered_s_ + found.duration * scale_.t;
}

bool OpenTrajectory::write(double t, Profile& profile) noexcept {
  profile = entered_;
  if (ramp_ && t <= shortest_s_ * (1 + kEqual)) {
    append(profile, ramp_->duration_s, ramp_->jerk);
    return true;
  }
  if (route_) {
    if (!corridor().write(*route_, profile)) return false;
  } else if (std::abs(t - shortest_s_) <= kEqual * t) {
    append(profile, reachable_->shape(shortest_), scale_);
  } else {
    const scaled::Mix mix = reachable_->mix((t - entered_s_) / scale_.t, p_, 10 * resolution_);
    if (!mix.possible) return false;
    append(profile, mix, scale_);
  }
  return arrives(profile, to_, bounds_, scale_p_, !entered_.phases.empty());
}

}  // namespace gantry::motion
