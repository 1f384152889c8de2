#include "app/job/stop_ahead.hpp"

#include <algorithm>
#include <cmath>

#include "motion/geometry.hpp"
#include "motion/profile/line_bounds.hpp"
#include "motion/profile/speed_profile.hpp"

namespace gantry::job {
namespace {

constexpr double kFar_s = 3;                 // of planned time ahead: more than a stop takes
constexpr std::ptrdiff_t kMostWork = 20000;  // ticks played ahead, some 4 ms
constexpr double kAsPlanned = 1e-3;          // of the planned one: it is played as planned
constexpr double kLeastSpeed = 1e-6;         // mm/s
constexpr double kUnseen = 1.02;             // the last setpoints are not told, and count for less than this
constexpr double kMostRise = 1.28;           // as much more a stop has taken whose rate rose as fast as it may
constexpr double kOnLine = 1.005;            // a hold that meets the end of a line has gone 0.4 % farther
constexpr double kLate = 1.5;                // ticks by which a difference of two speeds is behind

/// From (v, a) to rest.
double stop_mm(double v, double a, const motion::Bounds& b) {
  return motion::end_state(motion::stop({0, v, a}, b).profile).p;
}

/// Where nothing is known but how fast the tool goes and how much faster it has become: the jerk may go on raising that
/// until the stop begins.
double unplanned_mm(const OnPath& now, int ticks, double h, const motion::Bounds& b) {
  double p = 0, v = now.speed_mm_s, a = std::clamp(now.acceleration_mm_s2 + kLate * h * b.j, -b.a, b.a);
  const auto at_most = [&](double wished) {
    return std::min({wished, b.a, std::sqrt(2 * b.j * std::max(0.0, b.v - v))});
  };
  for (int n = 0; n < ticks; ++n) {
    a = at_most(a + h * b.j);
    p += h * (v + h * a);
    v = std::min(b.v, v + h * a);
  }
  return p + stop_mm(v, at_most(a), b);
}

}  // namespace

StopAhead::StopAhead(const motion::Limits& limits) : limits_(limits) {}

/// Looked for from the end of what the loop has been given, for a block may be long.
std::optional<double> StopAhead::from(const Plays& plays, const OnPath& now) {
  if (plays.block == nullptr || !(now.speed_mm_s > kLeastSpeed)) return std::nullopt;
  double begin_mm = plays.fed_mm;
  std::optional<std::size_t> first;
  for (std::size_t k = plays.fed; k-- > 0 && !(first && begin_mm <= now.along_block_mm);) {
    const motion::Segment& s = (*plays.block)[k];
    if (s.kind == motion::SegmentKind::Dwell) continue;
    begin_mm -= path_mm(s);
    first = k;
  }
  if (!first) return std::nullopt;
  const motion::Segment& s = (*plays.block)[*first];
  const double s_mm = std::clamp(now.along_block_mm - begin_mm, 0.0, s.geometry.length);
  if (s.kind != motion::SegmentKind::Piece) return on_line(s, s_mm, now);
  return on_pieces(*plays.block, *first, s_mm, now);
}

/// A line from rest to rest, played as planned or, behind a hold or at another rate, otherwise.
double StopAhead::on_line(const motion::Segment& line, double s_mm, const OnPath& now) const {
  const motion::Bounds b = motion::line_bounds(limits_, motion::derivative<1>(line.geometry, 0));
  const double t_s = motion::time_at(line.nominal, s_mm), left_mm = line.geometry.length - s_mm;
  const motion::State planned = motion::along(line.nominal, t_s).x;
  const double behind = motion::along(line.nominal, std::max(0.0, t_s - limits_.tick_s / 2)).x.a;
  const bool as_planned = std::abs(planned.v - now.speed_mm_s) <= kAsPlanned * std::max(now.speed_mm_s, line.v_cap) &&
                          std::abs(behind - now.acceleration_mm_s2) <= kLate * limits_.tick_s * b.j;
  double most_mm = 0;
  for (int n = 0; n <= kReaction; ++n) {
    if (as_planned) {
      const motion::State x = motion::along(line.nominal, t_s + n * limits_.tick_s).x;
      most_mm = std::max(most_mm, x.p - s_mm + stop_mm(x.v, x.a, b));
    } else {
      most_mm = std::max(most_mm, unplanned_mm(now, n, limits_.tick_s, b));
    }
  }
  return kOnLine * std::min(most_mm, left_mm);
}

/// The loop changes the rate at which planned time goes by.
std::optional<double> StopAhead::on_pieces(const std::deque<motion::Segment>& block, std::size_t first, double s_mm,
                                           const OnPath& now) {
  ring_ = std::make_unique<motion::SegmentRing>();
  double known_s = 0, known_mm = 0;
  bool rests = false;  // behind what is known
  for (std::size_t k = first; k < block.size() && block[k].kind == motion::SegmentKind::Piece; ++k) {
    if (!ring_->push(block[k])) break;
    known_s += motion::duration(block[k].nominal);
    known_mm += block[k].geometry.length;
    rests = block[k].rests;
    if (rests || known_s > kFar_s + motion::duration(block[first].nominal)) break;
  }
  const double h = limits_.tick_s, t_s = motion::time_at(block[first].nominal, s_mm);
  const motion::State planned = motion::along(block[first].nominal, t_s).x;
  if (!(planned.v > 0)) return std::nullopt;
  const double rate = std::min(1.0, now.speed_mm_s / planned.v);
  // Below it is planned with a rate that stands. One that rises behind a hold takes as much more as on a straight path.
  double rises = 1;
  if (rate < 1 - kAsPlanned) {
    const motion::Bounds b = motion::line_bounds(limits_, motion::derivative<1>(block[first].geometry, s_mm));
    const double by_plan = stop_mm(now.speed_mm_s, std::clamp(planned.a * rate * rate, 0.0, b.a), b);
    rises = std::clamp(unplanned_mm(now, 0, h, b) / by_plan, 1.0, kMostRise);
  }

  double most_mm = 0;
  for (int begins = 0; begins <= kReaction; ++begins) {
    const auto stands_s = stands_at_s(t_s + begins * h * rate, rate);
    if (!stands_s) return std::nullopt;
    most_mm = std::max(most_mm, gone_mm(*stands_s) - s_mm);
  }
  const double told_mm = kUnseen * rises * most_mm;
  return rests ? std::min(told_mm, std::max(kUnseen * most_mm, kOnLine * (known_mm - s_mm))) : told_mm;
}

/// Planned time at which a stop ends that the loop begins at `now_s`, tick by tick as the loop does.
/// Nothing where that takes too much work.
std::optional<double> StopAhead::stands_at_s(double now_s, double rate) {
  const double h = limits_.tick_s, most_s = now_s + kFar_s * rate;
  motion::Recent recent{place(now_s - 2 * h * rate), place(now_s - h * rate), place(now_s)};
  motion::Rate now{rate, 0};
  unsigned tries = 0;
  std::ptrdiff_t left = kMostWork;
  change_.drop();
  while (now_s < most_s) {
    motion::PieceCursor at(*ring_, 0, now_s);
    if (at.advance(0) != motion::PieceCursor::Met::Piece) return now_s;  // it rests by plan before it would be stopped
    if (left > 0) {
      change_.stop(at, now, recent, limits_, tries);
      left -= static_cast<std::ptrdiff_t>(change_.work());
    }
    if (left <= 0 && !change_.under_way()) return std::nullopt;
    const motion::RateChange::Step step =
        change_.under_way() ? change_.next() : motion::RateChange::Step{now.r * h, now};
    now_s += step.ahead, now = step.end;
    if (!(now.r > 0)) return now_s;
    recent = {recent[1], recent[2], place(now_s)};
  }
  return std::nullopt;
}

/// Path length from the beginning of the first piece.
double StopAhead::gone_mm(double planned_s) const {
  double mm = 0;
  for (std::size_t n = 0; n < ring_->size(); ++n) {
    const motion::Segment& s = *ring_->peek(n);
    const double lasts_s = motion::duration(s.nominal);
    if (planned_s < lasts_s) return mm + motion::along(s.nominal, planned_s).x.p;
    planned_s -= lasts_s;
    mm += s.geometry.length;
  }
  return mm;
}

AxisVec StopAhead::place(double planned_s) const {
  motion::PieceCursor at(*ring_, 0, std::max(0.0, planned_s));
  at.advance(0);
  const motion::Segment& s = at.piece();
  return motion::point(s.geometry, std::min(motion::along(s.nominal, at.t()).x.p, s.geometry.length));
}

}  // namespace gantry::job
