// Events: which of them are due, looking ahead by their lead over the course that is planned.
#include <algorithm>

#include "motion/rt/approach.hpp"
#include "motion/rt/interpolator.hpp"

namespace gantry::motion {
namespace {

constexpr double kReached = 1e-9;  // of s: rounding at the end of a segment

}  // namespace

void Interpolator::fire_events() noexcept {
  for (std::size_t i = 0; i < kEventWindow; ++i) {
    const Segment* s = ring_.peek(i);
    if (s == nullptr || s->block != block_) return;
    for (std::size_t k = 0; k < s->events.size(); ++k) {
      const OutputEvent& e = s->events[k];
      const auto bit = static_cast<std::uint8_t>(1u << k);
      if (fired(i) & bit) continue;
      if (stopping_) {
        if (i > 0 || s_ < e.at_s - kReached) continue;
        outputs_.apply_while_stopping(e);
      } else {
        if (!is_due(i, e)) continue;
        outputs_.apply(e);
      }
      fired(i) = static_cast<std::uint8_t>(fired(i) | bit);
    }
  }
}

/// A dispense command that fired ahead of its place, which a stop now keeps the tool from, is given again.
void Interpolator::take_back_events() noexcept {
  for (std::size_t i = 0; i < kEventWindow; ++i) {
    const Segment* s = ring_.peek(i);
    if (s == nullptr || s->block != block_) return;
    for (std::size_t k = 0; k < s->events.size(); ++k)
      if (s->events[k].dispense && (i > 0 || course_ == Course::None || s_ < s->events[k].at_s - kReached))
        fired(i) = static_cast<std::uint8_t>(fired(i) & ~(1u << k));
  }
}

/// By the present course, and the courses that will follow it, s(now + lead + tick/2) >= at_s on that segment.
bool Interpolator::is_due(std::size_t segment, const OutputEvent& e) noexcept {
  double ahead = e.lead_s + limits_.tick_s / 2;
  double v = v_in_;
  std::size_t next = 0;
  if (course_ != Course::None) {
    const bool to_end = course_ == Course::Nominal || course_ == Course::ToEnd;
    const double rest = t_end_ - t_;
    if (segment == 0) return (to_end && ahead >= rest) || evaluate(profile_, t_ + ahead).p >= e.at_s - kReached;
    if (!to_end) return false;
    ahead -= rest;
    v = rests_after(front()) ? 0 : course_ == Course::ToEnd ? v_out_ : evaluate(profile_, t_end_).v;
    next = 1;
  }
  for (std::size_t i = next; ahead >= 0; ++i) {
    const Segment& s = *ring_.peek(i);
    Profile p{{0, s.nominal.v0, s.nominal.a0}, s.nominal.phases};
    if (!nominal_fits(s, v)) {
      const Approach a = approach(v, s.geometry.length, v_allowed(i), bounds_of(s, override_));
      if (!a.found) return false;
      p = a.profile;
    }
    const double t = duration(p);
    if (i == segment) return ahead >= t || evaluate(p, ahead).p >= e.at_s - kReached;
    ahead -= t;
    v = rests_after(s) ? 0 : end_state(p).v;
  }
  return false;
}

}  // namespace gantry::motion
