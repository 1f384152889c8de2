// Events: which of them are due, looking ahead by their lead over the course that is planned.
#include <algorithm>
#include <cmath>

#include "motion/rt/approach.hpp"
#include "motion/rt/interpolator.hpp"

namespace gantry::motion {
namespace {

constexpr double kReached = 1e-9;    // of s: rounding at the end of a segment
constexpr unsigned kNextEvents = 2;  // a feature opens and shuts

/// How many times as fast as by nominal play such a segment is played at most: on a line an override is of its set
/// speed alone, which it may never come to.
double at_most(SegmentKind kind, double rate) {
  switch (kind) {
    case SegmentKind::Dwell: return 1;
    case SegmentKind::Piece: return std::min(rate, 1.0);
    case SegmentKind::Path:
    case SegmentKind::UntilProbe: break;
  }
  return std::max(rate, 1.0);
}

}  // namespace

/// Segments with events, as they come: the next few are looked at in every tick, the others not.
void Interpolator::list_events() noexcept {
  listed_ = std::max(listed_, popped_);
  for (; waiting_size_ < waiting_.size() && listed_ < seen_; ++listed_)
    if (!ring_.peek(listed_ - popped_)->events.empty()) waiting_[waiting_size_++] = {listed_, 0};
}

/// The front segment goes, and with it what waits on it.
void Interpolator::unlist_front() noexcept {
  if (waiting_size_ == 0 || waiting_[0].number != popped_) return;
  std::copy(waiting_.begin() + 1, waiting_.begin() + static_cast<std::ptrdiff_t>(waiting_size_), waiting_.begin());
  --waiting_size_;
}

/// The end of the front segment has been reached: all of its events have.
void Interpolator::fire_front() noexcept {
  list_events();
  if (waiting_size_ == 0 || waiting_[0].number != popped_) return;
  for (std::size_t k = 0; k < front().events.size(); ++k)
    if ((waiting_[0].fired >> k & 1u) == 0)
      stopping_ ? outputs_.apply_while_stopping(front().events[k]) : outputs_.apply(front().events[k]);
}

/// The listed events of this block in their order, fired or not, as long as `look` wants more: of the i-th segment from
/// the front, with their bits in `fired`.
template <class Look>
void Interpolator::each_waiting(Look&& look) noexcept {
  for (std::size_t n = 0; n < waiting_size_; ++n) {
    Waiting& waiting = waiting_[n];
    const std::size_t i = waiting.number - popped_;
    const Segment* s = ring_.peek(i);
    if (s == nullptr || s->block != block_) return;
    for (std::size_t k = 0; k < s->events.size(); ++k)
      if (!look(waiting, i, s->events[k], static_cast<std::uint8_t>(1u << k))) return;
  }
}

void Interpolator::fire_events() noexcept {
  list_events();
  each_waiting([&](Waiting& waiting, std::size_t i, const OutputEvent& e, std::uint8_t bit) {
    if ((waiting.fired & bit) != 0) return true;
    if (stopping_) {
      if (!has_come_to(waiting.number, e.at_s)) return true;
      outputs_.apply_while_stopping(e);
    } else {
      if (!is_due(i, e)) return true;
      outputs_.apply(e);
      if (outputs_.closes(e))
        shuts_at_ = Place{waiting.number, e.at_s,
                          tick_in_block_ + static_cast<std::uint32_t>(std::lround(e.lead_s / limits_.tick_s))};
    }
    waiting.fired = static_cast<std::uint8_t>(waiting.fired | bit);
    return true;
  });
}

/// The tool has come to that place; None: the front segment is not entered yet.
bool Interpolator::has_come_to(std::size_t number, double at_s) const noexcept {
  return popped_ > number || (popped_ == number && course_ != Course::None && s_ >= at_s - kReached);
}

bool Interpolator::lays_its_last() const noexcept {
  return shuts_at_ && tick_in_block_ <= shuts_at_->until && !has_come_to(shuts_at_->number, shuts_at_->at_s);
}

/// A dispense command that fired ahead of its place, which a stop now keeps the tool from, is given again, and what
/// follows it.
void Interpolator::take_back_events() noexcept {
  bool again = false;
  each_waiting([&](Waiting& waiting, std::size_t, const OutputEvent& e, std::uint8_t bit) {
    again = again || (e.dispense && !has_come_to(waiting.number, e.at_s));
    if (again) waiting.fired = static_cast<std::uint8_t>(waiting.fired & ~bit);
    return true;
  });
}

/// By the present course, begun when what is waited for is over, and the courses that will follow it, s(now + lead +
/// tick/2) >= at_s on that segment.
bool Interpolator::is_due(std::size_t segment, const OutputEvent& e) noexcept {
  const double ahead = e.lead_s + (0.5 - static_cast<double>(leads_)) * limits_.tick_s;
  return ahead >= 0 && comes_within(ahead, segment, e.at_s);
}

/// The next dispense command whose place is nearer, from this standstill, than its lead: it is given now, and the tool
/// sets out so much later.
void Interpolator::open_first() noexcept {
  list_events();
  each_waiting([&](Waiting& waiting, std::size_t i, const OutputEvent& e, std::uint8_t bit) {
    if (!e.dispense || (waiting.fired & bit) != 0) return true;
    // The tick that gives the command is one in which the tool still stands.
    const auto enough = static_cast<std::size_t>(std::lround(e.lead_s / limits_.tick_s)) + 1;
    std::size_t soonest = 0, latest = enough;  // ticks after which it is there, if before its lead is over
    while (soonest < latest) {
      const std::size_t middle = (soonest + latest) / 2;
      if (comes_within((static_cast<double>(middle) + 0.5) * limits_.tick_s, i, e.at_s))
        latest = middle;
      else
        soonest = middle + 1;
    }
    if (soonest == enough) return false;
    outputs_.apply(e);
    waiting.fired = static_cast<std::uint8_t>(waiting.fired | bit);
    leads_ = enough - soonest;
    return false;
  });
}

/// At most this rate from now on: how long the tool takes at least to that place.
double Interpolator::least_s(double rate, std::size_t segment, double at_s) noexcept {
  double sum = 0;
  for (std::size_t i = 0; i <= segment; ++i) {
    const Segment& s = *ring_.peek(i);
    const double from = i == 0 && course_ != Course::None ? time_at(s.nominal, s_) : 0;
    const double to = i == segment ? time_at(s.nominal, at_s) : duration(s.nominal);
    sum += (to - from) / at_most(s.kind, rate);
  }
  return sum;
}

/// Whether the pace may change to this rate and leave the leads of what comes next whole. A command that was given
/// ahead counts on the pace that it was given at; behind a standstill a lead is waited for.
bool Interpolator::leaves_leads(double rate) noexcept {
  list_events();
  if (course_ == Course::Paced) rate = std::max({rate, rate_.slope > 0 ? 1.0 : rate_.r, goal_});
  bool leaves = true;
  unsigned looked = 0;
  each_waiting([&](const Waiting& waiting, std::size_t i, const OutputEvent& e, std::uint8_t bit) {
    if (has_come_to(waiting.number, e.at_s)) return true;
    if ((waiting.fired & bit) != 0)
      leaves = false;
    else if (!stopping_ && !resumed_)
      leaves = least_s(rate, i, e.at_s) >= e.lead_s + limits_.tick_s;
    return leaves && ++looked < kNextEvents;
  });
  return leaves;
}

/// What comes behind travel begins with a tick, however long that has taken.
double Interpolator::lasts(const Segment& s, double seconds) const noexcept {
  return s.feature == kTravel ? whole_ticks(seconds, limits_.tick_s) : seconds;
}

/// Is the tool at at_s of that segment so much time ahead?
bool Interpolator::comes_within(double ahead, std::size_t segment, double at_s) noexcept {
  if (course_ == Course::None) return comes_to(0, ahead, segment, at_s);
  if (course_ == Course::Paced) {
    const double t = change_.ahead(ahead, goal_, limits_.tick_s);
    double begin = -t_;  // of segment i, in planned time from here
    for (std::size_t i = 0;; ++i) {
      const Segment* s = ring_.peek(i);
      if (s == nullptr || s->block != block_) return false;
      const double end = begin + duration(s->nominal);
      if (i == segment) return t >= end || along(s->nominal, t - begin).x.p >= at_s - kReached;
      if (t < end) return false;
      if (s->rests)
        return goal_ > 0 &&
               comes_to(i + 1, ahead - lasts(*s, change_.until(end, goal_, limits_.tick_s)), segment, at_s);
      begin = end;
    }
  }
  const bool to_end = course_ == Course::Nominal || course_ == Course::ToEnd;
  const double rest = t_end_ - t_;
  if (segment == 0) return (to_end && ahead >= rest) || evaluate(profile_, t_ + ahead).p >= at_s - kReached;
  return to_end && comes_to(1, ahead - lasts(front(), rest), segment, at_s);
}

/// From rest at the beginning of segment `from`, that segment is at at_s so much time later.
bool Interpolator::comes_to(std::size_t from, double ahead, std::size_t segment, double at_s) noexcept {
  for (std::size_t i = from; ahead >= 0; ++i) {
    const Segment* s = ring_.peek(i);
    if (s == nullptr || s->block != block_) return false;
    if (s->kind == SegmentKind::Path || s->kind == SegmentKind::UntilProbe) {
      if (override_ != 1) {
        const Approach a = approach({0, 0, 0}, s->geometry.length, bounds_of(*s));
        if (!a.found) return false;
        const double t = duration(a.profile);
        if (i == segment) return ahead >= t || evaluate(a.profile, ahead).p >= at_s - kReached;
        ahead -= lasts(*s, t);
        continue;
      }
    }
    const double rate = s->kind == SegmentKind::Piece ? std::min(override_, 1.0) : 1, t = duration(s->nominal) / rate;
    if (i == segment) return ahead >= t || along(s->nominal, ahead * rate).x.p >= at_s - kReached;
    ahead -= lasts(*s, t);
  }
  return false;
}

}  // namespace gantry::motion
