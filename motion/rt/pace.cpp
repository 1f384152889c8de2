// The rate at which the planned time of a path's pieces goes by: 1 as planned, an override below, 0 for a stop.
#include <algorithm>
#include <cmath>
#include <optional>

#include "motion/geometry.hpp"
#include "motion/profile/line_bounds.hpp"
#include "motion/rt/interpolator.hpp"

namespace gantry::motion {
namespace {

// Planned time that has to be known ahead, or a rest: a stop takes less. Below the one the tool brakes, above it by
// `kGo` it goes.
constexpr double kLow_s = 0.5, kLowStops = 1.5, kGo = 1.2;
constexpr std::size_t kStraightPieces = 64;  // how many pieces a straight stop may reach over
constexpr double kGentler = 0.995;           // of the jerk, where what was before leaves no room for all of it

struct Attempt {
  RateChange::Vigour vigour;
  double share = 1;  ///< of the change to the rate that is wanted
};
// Another rate than 0 is tried one every few ticks, a stop oftener: that bounds the work of a tick. A small rate can
// always be had from a standstill, and the others from there.
constexpr std::array<Attempt, 8> kChanges{{{{1, 0.85}, 1},
                                           {{0.6, 0.6}, 1},
                                           {{0.3, 0.4}, 1},
                                           {{0.6, 0.6}, 0.9},
                                           {{0.1, 0.4}, 0.9},
                                           {{0.3, 0.4}, 0.5},
                                           {{0.3, 0.4}, 0.2},
                                           {{0.2, 0.3}, 0.05}}};
constexpr unsigned kChangeEvery = 4;

/// The shortest stop on a line, where there is one from this state. Within the last tick a changing rate may use a
/// little more than the limits, which show in a mean over three.
std::optional<Profile> stop_on(const Geometry& line, const State& x, const Bounds& b, const Recent& recent,
                               const Limits& limits) noexcept {
  const double turned = x.a * x.a / (2 * b.j);  // change of speed while the acceleration goes to 0
  if ((x.a < 0 && x.v < turned) || (x.a > 0 && x.v + turned > b.v)) return std::nullopt;
  const Profile p = stop(x, b).profile;
  Differences judge(recent, limits);
  for (int n = 1; n <= 3; ++n)
    if (!judge.keeps_limits(point(line, evaluate(p, std::min(n * limits.tick_s, duration(p))).p))) return std::nullopt;
  return p;
}

}  // namespace

void Interpolator::choose_rate() noexcept {
  const bool enough = enough_is_known();
  starving_ = !enough;
  const double to = stopping_ || !enough ? 0 : std::min(override_, 1.0);
  if (to != wanted_) wanted_ = to, tries_ = 0;
  if (to == goal_ && (to > 0 || stands())) return;
  const State x = along(front().nominal, t_).x;
  if (!(x.v > 0)) {  // at a rest any rate will do
    rate_ = {to, 0};
    goal_ = to;
    change_.drop();
    return;
  }
  const PieceCursor here(ring_, 0, t_);
  if (to == 0) {
    if (brake_on_line(x)) return;
    if (const auto lower = change_.stop(here, rate_, recent_, limits_, tries_)) goal_ = *lower;
    return;
  }
  const unsigned n = tries_++;
  if (n % kChangeEvery != 0) return;
  if (goal_ > 0 && !leaves_leads(to)) return;
  const Attempt& a = kChanges[n / kChangeEvery % kChanges.size()];
  const double next = a.share == 1 ? to : rate_.r + a.share * (to - rate_.r);
  if (std::abs(to - next) >= std::abs(to - goal_)) return;
  if (change_.plan(here, rate_, next, recent_, limits_, a.vigour)) goal_ = next;
}

/// The shortest stop, where its whole path is straight.
bool Interpolator::brake_on_line(const State& planned) noexcept {
  State x{planned.p, planned.v * rate_.r, planned.a * rate_.r * rate_.r + planned.v * rate_.slope};
  if (front().geometry.degree != 1 || !(x.v > 0)) return false;
  Bounds b = line_bounds(limits_, derivative<1>(front().geometry, 0));
  x.a = std::clamp(x.a, -b.a, b.a);  // a changing rate may end a tick a little above
  auto p = stop_on(front().geometry, x, b, recent_, limits_);
  if (!p) b.j *= kGentler, p = stop_on(front().geometry, x, b, recent_, limits_);
  if (!p) return false;
  const double braking_mm = end_state(*p).p;
  double known = 0;
  for (std::size_t i = 0; i < kStraightPieces; ++i) {
    const Segment* s = ring_.peek(i);
    if (s == nullptr || s->block != block_ || s->kind != SegmentKind::Piece || s->geometry.degree != 1) return false;
    known += s->geometry.length;
    if (braking_mm <= known) {
      change_.drop();
      adopt(Course::ToRest, *p);
      goal_ = 0;
      return true;
    }
    if (s->rests) return false;
  }
  return false;
}

/// After a straight stop: the planned time of the place where the tool stands.
void Interpolator::stand_on_piece() noexcept {
  const double s = std::min(evaluate(profile_, t_end_).p, front().geometry.length);
  course_ = Course::Paced;
  t_ = time_at(front().nominal, s);
  rate_ = {0, 0};
  goal_ = 0;
}

/// What is left of a tick, on pieces. True when the block has come to its end.
bool Interpolator::pace(double& left) noexcept {
  RateChange::Step step{rate_.r * left, rate_};
  if (change_.under_way()) step = change_.next();
  rate_ = step.end;
  t_ += step.ahead;
  left = 0;
  for (;;) {
    const double end = duration(front().nominal);
    if (t_ < end - kSnap_s) return false;
    if (front().rests) {
      left = rate_.r > 0 && front().feature != kTravel ? std::min((t_ - end) / rate_.r, limits_.tick_s) : 0;
      if (left < kSnap_s) left = 0;
      t_end_ = end;
      change_.drop();
      return leave();
    }
    const Segment* next = ring_.peek(1);
    const bool arrives = std::abs(along(front().nominal, end).x.p - front().geometry.length) <= kBeyond;
    if (!arrives || next == nullptr || next->block != block_ || next->kind != SegmentKind::Piece) {
      lost_ = true;
      return false;
    }
    t_ -= end;
    pass_front();
  }
}

/// The path ahead is known up to a rest, or so far that a stop fits.
bool Interpolator::enough_is_known() noexcept {
  if (rest_is_known() || ring_.size() >= SegmentRing::capacity()) return true;
  const bool going = course_ == Course::Paced && goal_ > 0;
  const double low_s = std::max(kLow_s, kLowStops * longest_stop_s(limits_, fastest_));
  return known_s_ - (course_ == Course::Paced ? t_ : 0) >= (going ? 1 : kGo) * low_s;
}

/// Looks at new segments up to the next rest.
bool Interpolator::rest_is_known() noexcept {
  if (rest_after_ > popped_) return true;
  if (scanned_ <= popped_) scanned_ = popped_, known_s_ = fastest_ = 0;
  for (; scanned_ < seen_;) {
    const Segment* s = ring_.peek(scanned_ - popped_);
    if (s == nullptr || s->block != block_) return false;
    ++scanned_;
    if (s->kind == SegmentKind::Piece) {
      const double lasts_s = duration(s->nominal);
      known_s_ += lasts_s;
      fastest_ = std::max(fastest_, s->geometry.length / lasts_s);
    }
    if (s->rests) {
      rest_after_ = scanned_;
      return true;
    }
  }
  return false;
}

void Interpolator::see_new_segments() noexcept { seen_ = popped_ + ring_.size(); }

}  // namespace gantry::motion
