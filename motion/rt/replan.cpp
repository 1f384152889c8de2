// What s does next: the planner's own s(t), or a new one after a stop, an override, or because the path runs out.
#include <algorithm>
#include <cmath>

#include "motion/geometry.hpp"
#include "motion/rt/approach.hpp"
#include "motion/rt/interpolator.hpp"

namespace gantry::motion {
namespace {

constexpr double kSameSpeed = 1e-9;        // relative: speeds that are one
constexpr std::size_t kStopSegments = 16;  // how many segments one stop may reach over
// A latch is seen cycles after it happened (the axis' lag, the wire there and back, a host that was late). Braking only
// this long beyond the latched place, seen early or late, makes every setpoint a function of the place alone.
constexpr double kSeenWithin_s = 0.025;

bool faster(double v, double limit) noexcept { return v > limit * (1 + kSameSpeed); }

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
  if (!stopping_) {
    stopping_ = true;
    stale_ = true;
    after_stop_ = then;
    take_back_events();
  } else if (after_stop_ == AfterStop::Wait) {
    after_stop_ = then;
  }
}

void Interpolator::hold() noexcept { brake(AfterStop::Wait); }
void Interpolator::stop_path() noexcept { brake(AfterStop::Wait); }
void Interpolator::abort() noexcept { brake(AfterStop::Drop); }

void Interpolator::probe_latched(AxisId axis, double position) noexcept {
  if (doing_ != Doing::Block || course_ == Course::None || front().kind != SegmentKind::UntilProbe) return;
  if (stopping_ || !replan_beyond(axis, position)) brake(AfterStop::EndBlock);
}

/// Goes on from the latched place at the speed of the course that it has, and brakes. False: too late for that.
bool Interpolator::replan_beyond(AxisId axis, double position) noexcept {
  const Geometry& line = front().geometry;
  const double along = derivative<1>(line, 0)[axis.value];
  if (along == 0) return false;
  const State x = evaluate(profile_, t_);
  const double latched = std::min((position - line.c[0][axis.value]) / along, x.p);
  Bounds b = bounds_of(front(), override_);
  b.v = std::min(b.v, peak_speed(profile_) * (1 + kSameSpeed));
  const double end = latched + kSeenWithin_s * b.v + change_length(b.v, 0, b.a, b.j);
  if (end < line.length) {
    const Approach a = approach(x, end, 0, 0, b);
    if (!a.found) return false;
    adopt(Course::ToEnd, a.profile);
    v_out_ = 0;
    way_end_ = end;
  }
  return true;
}

void Interpolator::resume() noexcept {
  if (!held()) return;
  stopping_ = false;
  stale_ = true;
}

void Interpolator::adopt(Course course, const Profile& profile) noexcept {
  course_ = course;
  profile_ = profile;
  t_ = 0;
  t_end_ = duration(profile);
}

/// At the beginning of the front segment, at speed v_in_ without acceleration.
void Interpolator::choose_course() noexcept {
  const Segment& s = front();
  starving_ = false;
  stale_ = false;
  if (s.kind == SegmentKind::Dwell || (!stopping_ && nominal_fits(s, v_in_))) {
    adopt(Course::Nominal, {{0, s.nominal.v0, s.nominal.a0}, s.nominal.phases});
    return;
  }
  if (!replan({0, v_in_, 0})) adopt(Course::Standing, {});  // cannot be: from acceleration 0 every end can be had
}

bool Interpolator::nominal_fits(const Segment& s, double v_in) const noexcept {
  return s.kind == SegmentKind::Dwell || (override_ == 1 && std::abs(v_in - s.nominal.v0) <= kSameSpeed * (1 + v_in));
}

/// Speed, known to be safe, that the present course would have at the end of the front segment.
double Interpolator::v_at_end() noexcept {
  switch (course_) {
    case Course::Nominal: return rest_is_known() ? front().v_exit : std::min(front().v_exit, v_allowed(0));
    case Course::ToEnd: return v_out_;
    case Course::ToRest: return 0;
    default: return kNoCourse;
  }
}

/// A new course from x on the front segment. False: so near its end that the course has to be kept until there.
bool Interpolator::replan(const State& x) noexcept {
  if (stopping_ && replan_to_rest(x)) return true;
  const Segment& s = front();
  const double v_now = v_at_end();
  const Bounds b = bounds_of(s, override_);
  const double end = std::min(way_end_, s.geometry.length);
  Approach a = approach(x, end, stopping_ ? 0 : v_allowed(0), v_now, b);
  if (!a.found && stopping_) a = approach(x, end, v_allowed(0), v_now, b);
  if (!a.found) return false;
  adopt(Course::ToEnd, a.profile);
  v_out_ = a.v_out;
  starving_ = !stopping_ && !rest_is_known() && a.v_out < s.v_exit;
  return true;
}

/// Brakes to rest at once, over following segments within the smallest of their bounds.
bool Interpolator::replan_to_rest(const State& x) noexcept {
  Bounds b = bounds_of(front(), 1);
  double end = 0;
  for (std::size_t i = 0; i < kStopSegments; ++i) {
    const Segment* s = ring_.peek(i);
    if (s == nullptr || s->block != block_ || s->kind == SegmentKind::Dwell) return false;
    b.a = std::min(b.a, s->a_max);
    b.j = std::min(b.j, s->j_max);
    if (faster(std::abs(x.a), b.a)) return false;
    end += s->geometry.length;
    const Profile p = stop(x, b).profile;
    if (end_state(p).p <= end) {
      if (!speeds_fit(p, i)) return false;
      adopt(Course::ToRest, p);
      return true;
    }
    if (rests_after(*s)) return false;
  }
  return false;
}

/// True when braking enters each of the next segments no faster than they allow.
bool Interpolator::speeds_fit(const Profile& braking, std::size_t segments) noexcept {
  double end = 0, lo = 0;
  for (std::size_t i = 0; i < segments; ++i) {
    end += ring_.peek(i)->geometry.length;
    double hi = duration(braking);
    for (int n = 0; n < 50; ++n) {
      const double mid = (lo + hi) / 2;
      (evaluate(braking, mid).p < end ? lo : hi) = mid;
    }
    const State x = evaluate(braking, hi);
    const Segment& next = *ring_.peek(i + 1);
    const double coming = x.a > 0 ? x.v + x.a * x.a / (2 * next.j_max) : x.v;
    if (faster(coming, next.v_max)) return false;
    lo = hi;
  }
  return true;
}

/// Nominal play at t on the front segment leaves room to brake for the end of the known path.
bool Interpolator::can_brake(double t) noexcept {
  const Segment& s = front();
  if (s.kind == SegmentKind::Dwell || rest_is_known()) return true;
  const double v_end = v_allowed(0);
  if (!faster(s.v_exit, v_end)) return true;
  const State x = evaluate(profile_, t);
  const Bounds b = bounds_of(s, override_);
  return x.p + std::min(way_to_speed(x, v_end, b), way_to_speed(x, 0, b)) <= s.geometry.length;
}

/// True when the planned motion is known up to a rest: it is its own proof that the tool can stop.
bool Interpolator::rest_is_known() noexcept {
  if (rest_after_ > popped_) return true;
  for (scanned_ = std::max(scanned_, popped_); scanned_ < seen_;) {
    const Segment* s = ring_.peek(scanned_ - popped_);
    if (s == nullptr || s->block != block_) return false;
    ++scanned_;
    if (rests_after(*s)) {
      rest_after_ = scanned_;
      return true;
    }
  }
  return false;
}

double Interpolator::v_allowed(std::size_t i) noexcept {
  if (!looked_ahead_) {
    ahead_.update(block_, override_);
    looked_ahead_ = true;
  }
  return ahead_.v_end(i);
}

void Interpolator::see_new_segments() noexcept {
  const std::size_t now = popped_ + ring_.size();
  if (now == seen_) return;
  seen_ = now;
  looked_ahead_ = false;
  if (course_ == Course::ToEnd && !stopping_ && faster(v_allowed(0), v_out_)) stale_ = true;
}

}  // namespace gantry::motion
