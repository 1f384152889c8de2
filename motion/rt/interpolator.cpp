// How time goes on: ticks, segments entered and left, stops that come to their end.
#include "motion/rt/interpolator.hpp"

#include <algorithm>
#include <cmath>

#include "motion/geometry.hpp"

namespace gantry::motion {
namespace {

// Bound of the work in one tick; a tool that would cross more segments than this waits for the next tick.
constexpr int kSegmentsPerTick = 64;

}  // namespace

Interpolator::Interpolator(SegmentRing& ring, const Limits& limits, std::uint32_t valve_mask) noexcept
    : ring_(ring), limits_(limits), outputs_(valve_mask) {}

void Interpolator::start(const AxisVec& q) noexcept {
  if (doing_ == Doing::Block) drop_block();
  doing_ = Doing::Nothing;
  stopping_ = false;
  outputs_.close_valve();
  q_ = q;
  recent_.fill(q);
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
  started_ = stopping_ = starving_ = resumed_ = false;
  leads_ = 0;
  shuts_at_.reset();
  gone_mm_ = along_block_mm_ = 0;
  rest_after_ = 0;
  scanned_ = popped_;
  known_s_ = fastest_ = 0;
}

Setpoint Interpolator::step(double override_factor) noexcept {
  const Setpoint out = tick(override_factor);
  recent_ = {recent_[1], recent_[2], out.q};
  return out;
}

Setpoint Interpolator::tick(double override_factor) noexcept {
  if (doing_ == Doing::AxisStop) return axis_stop_tick();
  if (doing_ == Doing::Nothing) return setpoint();
  const double wanted =
      std::isfinite(override_factor) ? std::clamp(override_factor, kLeastOverride, kMostOverride) : 1.0;
  if (wanted != override_ && leaves_leads(wanted)) {
    override_ = wanted;
    stale_ = true;
  }
  see_new_segments();
  if (resumed_) set_out();
  if (leads_ > 0) {
    --leads_, ++tick_in_block_;
    fire_events();
    return setpoint();
  }
  const bool reached_end = advance();
  if (lost_) {
    lost_ = false;
    axis_stop();
    Setpoint out = axis_stop_tick();
    out.off_path = true;
    return out;
  }
  resumed_ = resumed_ || (starving_ && !stopping_ && !reached_end && stands());
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

/// What the tool will do from the standstill of a stop is known before it does it, so that what leads it can.
void Interpolator::set_out() noexcept {
  if (stopping_) {
    if (!stands()) return;
    stopping_ = false;
    stale_ = true;
  }
  if (course_ == Course::None) {
    if (!enter()) return;
    s_ = 0;
  }
  if (course_ == Course::Paced) {
    choose_rate();
    if (goal_ == 0) return;  // tried again
  } else if (stale_ && front().kind != SegmentKind::Dwell && replan(evaluate(profile_, t_))) {
    stale_ = false;
  }
  resumed_ = false;
  open_first();
}

/// One tick of the block; true when it has come to its end.
bool Interpolator::advance() noexcept {
  bool ended = false;
  double left = limits_.tick_s;
  if (course_ == Course::Paced) choose_rate();
  for (int n = 0; n < kSegmentsPerTick && left > 0 && !ended && !lost_; ++n) {
    if (course_ == Course::None && !enter()) break;
    if (course_ == Course::Paced) {
      ended = pace(left);
      continue;
    }
    const SegmentKind kind = front().kind;
    if (kind == SegmentKind::Dwell && stopping_) break;  // frozen
    if (stale_ && kind != SegmentKind::Dwell && kind != SegmentKind::Piece && replan(evaluate(profile_, t_)))
      stale_ = false;
    if (course_ == Course::Standing) break;
    if (course_ == Course::ToRest) {
      brake_on(left);
      break;
    }
    const double rest = t_end_ - t_;
    if (left >= rest - kSnap_s) {
      const double over = left - lasts(front(), rest);
      left = over > kSnap_s ? over : 0;
      ended = leave();
    } else {
      t_ += left;
      left = 0;
    }
  }
  if (lost_ || (course_ != Course::None && !take_path_state())) {
    lost_ = true;
    return false;
  }
  if (!started_) return false;
  if (course_ == Course::None && !ended && ring_.peek(0) == nullptr) starving_ = true;
  ++tick_in_block_;
  if (!ended) fire_events();
  return ended;
}

/// Goes into the block's next segment. False: it is not there yet, or a stop keeps the tool from it.
bool Interpolator::enter() noexcept {
  while (ring_.peek(0) != nullptr && front().block != block_) pop();
  if (ring_.peek(0) == nullptr || stopping_) return false;
  if (front().kind == SegmentKind::Piece && !enough_is_known()) {
    starving_ = true;
    return false;
  }
  started_ = true;
  choose_course();
  return true;
}

/// The front segment has come to its end, where the path rests. True when the block ends there.
bool Interpolator::leave() noexcept {
  t_ = t_end_;
  if (!take_path_state()) {
    lost_ = true;
    return false;
  }
  const bool ends_block = front().ends_block;
  v_ = a_ = AxisVec{};
  s_dot_ = 0;
  moving_ = false;
  fire_events();
  course_ = Course::None;
  pop();
  return ends_block;
}

/// A stop on a straight path may reach over segment ends: its s goes on into the next one.
void Interpolator::brake_on(double left) noexcept {
  const bool ends = left >= t_end_ - t_ - kSnap_s;
  t_ = ends ? t_end_ : t_ + left;
  while (evaluate(profile_, t_).p > front().geometry.length && !front().rests && ring_.peek(1) != nullptr) {
    profile_.from.p -= front().geometry.length;
    pass_front();
  }
  if (!ends) return;
  if (front().kind == SegmentKind::Piece)
    stand_on_piece();
  else
    adopt(Course::Standing, {{std::min(evaluate(profile_, t_).p, front().geometry.length), 0, 0}, {}});
}

/// The tool goes on into the next segment.
void Interpolator::pass_front() noexcept {
  s_ = front().geometry.length;
  fire_front();
  pop();
}

void Interpolator::pop() noexcept {
  unlist_front();
  touch_end_mm_ = kWholeSegment;
  if (scanned_ > popped_ && front().kind == SegmentKind::Piece) known_s_ -= duration(front().nominal);
  if (front().kind != SegmentKind::Dwell) gone_mm_ += front().geometry.length;
  ring_.pop(scratch_);
  ++popped_;
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
  if (course_ == Course::Paced) return rate_.r == 0 && !change_.under_way();
  return course_ == Course::None || course_ == Course::Standing || front().kind == SegmentKind::Dwell;
}

/// Axis values from s at the end of a tick. False: s is not on its segment.
bool Interpolator::take_path_state() noexcept {
  const Segment& segment = front();
  const bool paced = course_ == Course::Paced;
  State x = paced ? along(segment.nominal, t_).x : evaluate(profile_, t_);
  if (!(x.p >= -kBeyond && x.p <= segment.geometry.length + kBeyond)) return false;
  if (paced) x = {x.p, x.v * rate_.r, x.a * rate_.r * rate_.r + x.v * rate_.slope};
  s_ = x.p;
  along_block_mm_ = segment.kind == SegmentKind::Dwell ? gone_mm_ : gone_mm_ + s_;
  feature_ = segment.feature;
  probing_ = segment.kind == SegmentKind::UntilProbe;
  GeometryJet g;
  differentiate<2>(segment.geometry, s_, g);
  q_ = g.q;
  moving_ = segment.kind != SegmentKind::Dwell && !stands();
  if (!moving_) x.v = x.a = 0;
  s_dot_ = x.v;
  for (std::size_t i = 0; i < kMaxAxes; ++i) {
    v_[i] = g.d1[i] * x.v;
    a_[i] = g.d2[i] * x.v * x.v + g.d1[i] * x.a;
  }
  return true;
}

Setpoint Interpolator::setpoint() const noexcept {
  Setpoint out;
  out.q = q_, out.v = v_, out.a = a_;
  out.outputs = outputs_.bits();
  out.moving = moving_;
  out.along_block_mm = along_block_mm_;  // of a block that a stop has ended, too: where the tool stands
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
  if (doing_ != Doing::AxisStop) brake_axes();
}

void Interpolator::axis_stop_from(const AxisVec& q, const AxisVec& v) noexcept {
  outputs_.close_valve();
  q_ = q, v_ = v, a_ = AxisVec{};
  brake_axes();
}

void Interpolator::brake_axes() noexcept {
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

bool Interpolator::idle() const noexcept { return doing_ == Doing::Nothing; }
bool Interpolator::at_rest() const noexcept { return !moving_; }
bool Interpolator::held() const noexcept { return stopping_ && after_stop_ == AfterStop::Wait && !resumed_; }
bool Interpolator::starving() const noexcept { return starving_; }

}  // namespace gantry::motion
