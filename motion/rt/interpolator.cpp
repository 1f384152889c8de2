// How time goes on: ticks, segments entered and left, stops that come to their end.
#include "motion/rt/interpolator.hpp"

#include <algorithm>
#include <cmath>

#include "motion/geometry.hpp"

namespace gantry::motion {
namespace {

// Durations are sums of doubles: what ends within this of a tick ends on it. The shift stays below what jerk shows.
constexpr double kSnap_s = 1e-11;
// Bound of the work in one tick; a tool that would cross more segments than this waits for the next tick.
constexpr int kSegmentsPerTick = 64;

}  // namespace

Interpolator::Interpolator(SegmentRing& ring, const Limits& limits, std::uint32_t valve_mask) noexcept
    : ring_(ring), limits_(limits), ahead_(ring), outputs_(valve_mask) {}

void Interpolator::start(const AxisVec& q) noexcept {
  if (doing_ == Doing::Block) drop_block();
  doing_ = Doing::Nothing;
  stopping_ = false;
  outputs_.close_valve();
  q_ = q;
  v_ = a_ = AxisVec{};
  s_dot_ = 0;
  moving_ = false;
}

void Interpolator::begin_block(std::uint32_t block) noexcept {
  if (doing_ != Doing::Nothing) return;
  doing_ = Doing::Block;
  block_ = block;
  tick_in_block_ = 0;
  course_ = Course::None;
  v_in_ = 0;
  started_ = stopping_ = starving_ = looked_ahead_ = false;
  rest_after_ = 0;
  scanned_ = popped_;
}

Setpoint Interpolator::step(double override_factor) noexcept {
  if (doing_ == Doing::AxisStop) return axis_stop_tick();
  if (doing_ == Doing::Nothing) return setpoint();
  const double wanted = std::isfinite(override_factor) ? std::clamp(override_factor, 0.1, 2.0) : 1.0;
  if (wanted != override_) {
    override_ = wanted;
    stale_ = true;
    looked_ahead_ = false;
  }
  see_new_segments();
  const bool reached_end = advance();
  const bool stopped = !reached_end && stopping_ && stands();
  if (stopped) moving_ = false;
  Setpoint out = setpoint();
  out.block_done = reached_end || (stopped && after_stop_ == AfterStop::EndBlock);
  if (stopped && after_stop_ != AfterStop::Wait) drop_block();
  if (out.block_done || (stopped && after_stop_ == AfterStop::Drop)) {
    doing_ = Doing::Nothing;
    stopping_ = starving_ = false;
  }
  return out;
}

/// One tick of the block; true when it has come to its end.
bool Interpolator::advance() noexcept {
  bool ended = false;
  double left = limits_.tick_s;
  for (int n = 0; n < kSegmentsPerTick && left > 0 && !ended; ++n) {
    if (course_ == Course::None && !enter()) break;
    const Segment& segment = front();
    if (segment.kind == SegmentKind::Dwell && stopping_) break;  // frozen
    if (stale_ && segment.kind != SegmentKind::Dwell && replan(evaluate(profile_, t_))) stale_ = false;
    if (course_ == Course::Standing) break;
    const double rest = t_end_ - t_;
    const bool ends = left >= rest - kSnap_s;
    if (course_ == Course::Nominal && !can_brake(ends ? t_end_ : t_ + left) && replan(evaluate(profile_, t_))) {
      starving_ = true;
      continue;
    }
    if (course_ == Course::ToRest) {
      t_ = ends ? t_end_ : t_ + left;
      left = 0;
      // A stop may reach over segment ends: its s goes on into the next one.
      while (evaluate(profile_, t_).p > front().geometry.length && ring_.peek(1) != nullptr) {
        s_ = front().geometry.length;
        fire_events();
        profile_.from.p -= s_;
        pop();
      }
      if (ends) adopt(Course::Standing, {{std::min(evaluate(profile_, t_).p, front().geometry.length), 0, 0}, {}});
    } else if (ends) {
      left = rest > left - kSnap_s ? 0 : left - rest;
      ended = leave();
    } else {
      t_ += left;
      left = 0;
    }
  }
  if (course_ != Course::None) take_path_state();
  if (!started_) return false;
  if (course_ == Course::None && !ended && ring_.peek(0) == nullptr) starving_ = true;
  ++tick_in_block_;
  if (!ended) fire_events();
  return ended;
}

/// Goes into the block's next segment. False: it is not there yet, or a stop keeps the tool from it.
bool Interpolator::enter() noexcept {
  while (ring_.peek(0) != nullptr && front().block != block_) pop();
  if (ring_.peek(0) == nullptr || (stopping_ && v_in_ == 0)) return false;
  started_ = true;
  choose_course();
  return true;
}

/// The front segment has come to its end. True when the block has.
bool Interpolator::leave() noexcept {
  t_ = t_end_;
  take_path_state();
  const bool ends_block = front().ends_block;
  v_in_ = rests_after(front()) ? 0 : std::max(evaluate(profile_, t_end_).v, 0.0);
  if (course_ == Course::ToEnd) v_in_ = v_out_;
  if (v_in_ == 0) {
    v_ = a_ = AxisVec{};
    s_dot_ = 0;
    moving_ = false;
  }
  fire_events();
  course_ = Course::None;
  pop();
  return ends_block;
}

void Interpolator::pop() noexcept {
  fired(0) = 0;
  way_end_ = kWholeWay;
  ring_.pop(scratch_);
  ++popped_;
  looked_ahead_ = false;
}

void Interpolator::forget(std::uint32_t block) noexcept {
  if (doing_ != Doing::Block || block != block_) pop_block(block);
}

void Interpolator::pop_block(std::uint32_t block) noexcept {
  while (ring_.peek(0) != nullptr && front().block == block) pop();
}

void Interpolator::drop_block() noexcept {
  pop_block(block_);
  course_ = Course::None;
}

bool Interpolator::stands() noexcept {
  if (course_ == Course::None) return v_in_ == 0;
  return course_ == Course::Standing || front().kind == SegmentKind::Dwell;
}

/// Axis values from s at the end of a tick.
void Interpolator::take_path_state() noexcept {
  const Segment& segment = front();
  const State x = evaluate(profile_, t_);
  s_ = std::clamp(x.p, 0.0, segment.geometry.length);
  feature_ = segment.feature;
  probing_ = segment.kind == SegmentKind::UntilProbe;
  q_ = point(segment.geometry, s_);
  if (segment.kind == SegmentKind::Dwell || course_ == Course::Standing) {
    v_ = a_ = AxisVec{};
    s_dot_ = 0;
    moving_ = false;
    return;
  }
  const AxisVec q1 = derivative<1>(segment.geometry, s_), q2 = derivative<2>(segment.geometry, s_);
  for (std::size_t i = 0; i < kMaxAxes; ++i) {
    v_[i] = q1[i] * x.v;
    a_[i] = q2[i] * x.v * x.v + q1[i] * x.a;
  }
  s_dot_ = x.v;
  moving_ = true;
}

Setpoint Interpolator::setpoint() const noexcept {
  Setpoint out;
  out.q = q_, out.v = v_, out.a = a_;
  out.outputs = outputs_.bits();
  out.moving = moving_;
  if (doing_ != Doing::Block || !started_) return out;
  out.block = block_;
  out.tick_in_block = tick_in_block_;
  out.feature = feature_;
  out.s = s_, out.s_dot = s_dot_;
  out.probing = probing_;
  return out;
}

void Interpolator::axis_stop() noexcept {
  outputs_.close_valve();
  if (doing_ == Doing::AxisStop) return;
  for (std::size_t i = 0; i < limits_.axes; ++i) {
    const AxisLimits& l = limits_.axis[i];
    axis_stop_[i] = stop({q_[i], v_[i], a_[i]}, {l.v_max, l.a_max, l.j_max}).profile;
  }
  axis_stop_t_ = 0;
  if (doing_ == Doing::Block) drop_block();
  doing_ = Doing::AxisStop;
  stopping_ = starving_ = false;
}

Setpoint Interpolator::axis_stop_tick() noexcept {
  axis_stop_t_ += limits_.tick_s;
  moving_ = false;
  for (std::size_t i = 0; i < limits_.axes; ++i) {
    const bool ended = axis_stop_t_ >= duration(axis_stop_[i]);
    const State x = ended ? end_state(axis_stop_[i]) : evaluate(axis_stop_[i], axis_stop_t_);
    q_[i] = x.p;
    v_[i] = ended ? 0 : x.v;
    a_[i] = ended ? 0 : x.a;
    moving_ = moving_ || !ended;
  }
  s_dot_ = 0;
  if (!moving_) doing_ = Doing::Nothing;
  return setpoint();
}

void Interpolator::set_outputs(std::uint32_t mask, std::uint32_t bits) noexcept { outputs_.set(mask, bits); }

bool Interpolator::idle() const noexcept { return doing_ == Doing::Nothing; }
bool Interpolator::at_rest() const noexcept { return !moving_; }
bool Interpolator::held() const noexcept { return stopping_ && after_stop_ == AfterStop::Wait; }
bool Interpolator::starving() const noexcept { return starving_; }

}  // namespace gantry::motion
