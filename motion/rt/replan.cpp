// What s does next on a line: the planner's own s(t), or a new one after a stop or an override.
#include <algorithm>
#include <cmath>

#include "motion/geometry.hpp"
#include "motion/profile/line_bounds.hpp"
#include "motion/profile/touch_end.hpp"
#include "motion/rt/approach.hpp"
#include "motion/rt/interpolator.hpp"

namespace gantry::motion {
namespace {

constexpr double kSameSpeed = 1e-9;  // relative: speeds that are one

double peak_speed(const Profile& profile) noexcept {
  double t = 0, peak = profile.from.v;
  for (const Phase& phase : profile.phases) {
    t += phase.duration_s;
    peak = std::max(peak, evaluate(profile, t).v);
  }
  return peak;
}

}  // namespace

void Interpolator::brake(AfterStop then) noexcept {
  outputs_.close_valve();
  if (doing_ != Doing::Block) return;
  resumed_ = false;
  if (!stopping_) {
    stopping_ = true;
    stale_ = true;
    after_stop_ = then;
    if (leads_ > 0 || (course_ != Course::None && s_ == 0 && !moving_)) stand_still();
    take_back_events();
  } else if (after_stop_ == AfterStop::Wait) {
    after_stop_ = then;
  }
}

void Interpolator::hold() noexcept { brake(AfterStop::Wait); }
void Interpolator::abort() noexcept { brake(AfterStop::Drop); }

void Interpolator::probe_latched(AxisId axis, double position) noexcept {
  if (doing_ != Doing::Block || course_ == Course::None || front().kind != SegmentKind::UntilProbe) return;
  if (stopping_ || !replan_beyond(axis, position)) brake(AfterStop::EndBlock);
}

/// Goes on from the latched position at the speed of the course that it has, and brakes. False: too late for that.
bool Interpolator::replan_beyond(AxisId axis, double position) noexcept {
  const Geometry& line = front().geometry;
  const double slope = derivative<1>(line, 0)[axis.value];
  if (slope == 0) return false;
  const State x = evaluate(profile_, t_);
  const double latched = std::min((position - line.from[axis.value]) / slope, x.p);
  Bounds b = bounds_of(front());
  b.v = std::min(b.v, peak_speed(profile_) * (1 + kSameSpeed));
  const double end = touch_end(latched, b);
  if (end < line.length) {
    const Approach a = approach(x, end, b);
    if (!a.found) return false;
    adopt(Course::ToEnd, a.profile);
    touch_end_mm_ = end;
  }
  return true;
}

/// Comes to rest first, where it does not stand yet: what comes next is led from there.
void Interpolator::resume() noexcept {
  if (held()) resumed_ = true;
}

/// Has not set out yet, and does not: what was entered to know what comes is not begun.
void Interpolator::stand_still() noexcept {
  leads_ = 0;
  if (s_ == 0) {
    change_.drop();
    course_ = Course::None;
  } else if (course_ == Course::Paced) {
    change_.drop();
    rate_ = {0, 0};
    goal_ = 0;
  } else if (course_ == Course::ToEnd) {
    adopt(Course::Standing, {{evaluate(profile_, t_).p, 0, 0}, {}});
  }
}

void Interpolator::adopt(Course course, const Profile& profile) noexcept {
  course_ = course;
  profile_ = profile;
  t_ = 0;
  t_end_ = duration(profile);
}

/// Bounds of s on a line at the present override; a touch is never faster than planned.
Bounds Interpolator::bounds_of(const Segment& s) const noexcept {
  Bounds b = line_bounds(limits_, derivative<1>(s.geometry, 0));
  const double factor = s.kind == SegmentKind::UntilProbe ? std::min(override_, 1.0) : override_;
  b.v = std::min(s.v_cap * factor, b.v);
  return b;
}

/// At the beginning of the front segment, at rest.
void Interpolator::choose_course() noexcept {
  const Segment& s = front();
  starving_ = false;
  stale_ = false;
  if (s.kind == SegmentKind::Piece) {
    course_ = Course::Paced;
    t_ = 0;
    goal_ = std::min(override_, 1.0);
    rate_ = {goal_, 0};
    change_.drop();
  } else if (s.kind == SegmentKind::Dwell || override_ == 1) {
    Profile profile{{0, s.nominal.v0, s.nominal.a0}, {}};
    for (const Phase& phase : s.nominal.phases) profile.phases.push_back(phase);
    adopt(Course::Nominal, profile);
  } else if (!replan({0, 0, 0})) {
    adopt(Course::Standing, {});  // cannot be: from rest every end can be had
  }
}

/// A new course from x on the line in front. False: so near its end that the course has to be kept until there.
bool Interpolator::replan(const State& x) noexcept {
  const Segment& s = front();
  Bounds b = bounds_of(s);
  const double end = std::min(touch_end_mm_, s.geometry.length);
  if (stopping_) {
    const Profile p = stop(x, b).profile;
    if (end_state(p).p <= s.geometry.length) {
      adopt(Course::ToRest, p);
      return true;
    }
  }
  const Approach a = approach(x, end, b);
  if (!a.found) return false;
  adopt(Course::ToEnd, a.profile);
  return true;
}

}  // namespace gantry::motion
