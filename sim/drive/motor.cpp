#include "sim/drive/motor.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace gantry::sim {
namespace {

constexpr double kRest = 1e-9;        // mm or rad from a standing command at which the motor is put on it
constexpr double kInstant_s = 1e-12;  // edges are found this exactly
constexpr double kNoTime_s = 1e-15;   // rests of time below this are rounding
constexpr double kInfinity = std::numeric_limits<double>::infinity();

// x(t) of tau x' + x = p + v t + a t^2/2 with x(0) = x0:
//   x(t) = p + v t + a t^2/2 - tau (v + a t) + tau^2 a + K e^(-t/tau),   K = x0 - (p - tau v + tau^2 a)
// and the command itself when tau = 0.
struct Course {
  double p, v, a, tau, k;

  Course(const CommandPiece& c, double x0, double lag) noexcept
      : p(c.p - lag * c.v + lag * lag * c.a), v(c.v - lag * c.a), a(c.a), tau(lag), k(lag > 0 ? x0 - p : 0) {}

  [[nodiscard]] double fade(double t) const noexcept { return tau > 0 ? std::exp(-t / tau) : 0; }
  [[nodiscard]] double decay(double t) const noexcept { return k * fade(t); }
  [[nodiscard]] double at(double t, double decayed) const noexcept { return p + (v + 0.5 * a * t) * t + decayed; }
  [[nodiscard]] double speed(double t, double decayed) const noexcept {
    return v + a * t - (tau > 0 ? decayed / tau : 0);
  }
  [[nodiscard]] double at(double t) const noexcept { return at(t, decay(t)); }
  [[nodiscard]] double speed(double t) const noexcept { return speed(t, decay(t)); }
  /// No point of [0, t] lies farther from at(0) than this.
  [[nodiscard]] double reach(double t) const noexcept {
    const double transient = tau > 0 ? std::abs(k) * std::min(1.0, t / tau) : 0;
    return (std::abs(v) + 0.5 * std::abs(a) * t) * t + transient;
  }
};

// Root of a monotone f in [lo, hi] with a change of sign, by bisection with secant steps (regula falsi, Illinois).
template <class F>
double root(F f, double lo, double hi) noexcept {
  double f_lo = f(lo), f_hi = f(hi);
  for (int i = 0, side = 0; i < 100 && hi - lo > kInstant_s; ++i) {
    double mid = (lo * f_hi - hi * f_lo) / (f_hi - f_lo);
    if (i % 4 == 3 || !(mid > lo && mid < hi)) mid = 0.5 * (lo + hi);
    const double f_mid = f(mid);
    if ((f_mid < 0) == (f_hi < 0)) {
      hi = mid, f_hi = f_mid;
      if (side == -1) f_lo *= 0.5;
      side = -1;
    } else {
      lo = mid, f_lo = f_mid;
      if (side == 1) f_hi *= 0.5;
      side = 1;
    }
  }
  return hi;
}

// Ends of the monotone stretches of x in (0, t]: the roots of its speed, at most two, because the speed itself bends
// only where a + (K/tau^2) e^(-t/tau) = 0.
struct Stretches {
  std::array<double, 3> end{};
  int count = 0;

  Stretches(const Course& x, double t) noexcept {
    double turn = t;
    if (x.tau > 0 && x.k != 0 && x.a != 0) {
      const double ratio = -x.a * x.tau * x.tau / x.k;
      if (ratio > 0) turn = std::clamp(-x.tau * std::log(ratio), 0.0, t);
    }
    add_root(x, 0, turn);
    add_root(x, turn, t);
    end[static_cast<std::size_t>(count++)] = t;
  }

 private:
  void add_root(const Course& x, double lo, double hi) noexcept {
    if (hi - lo <= kNoTime_s) return;
    if (x.speed(lo) * x.speed(hi) < 0)
      end[static_cast<std::size_t>(count++)] = root([&](double t) { return x.speed(t); }, lo, hi);
  }
};

// First instant in [0, t] at which x, coming from x0, passes the threshold; infinity when it does not. Without a lag
// the motor stands on its command at once, so at(0) may lie far from x0.
double crossing(const Course& x, const Threshold& threshold, double x0, double t) noexcept {
  const double start = x.at(0);
  const bool before = threshold.closed(x0);
  if (std::abs(start - x0) > kRest && threshold.closed(start) != before) return 0;
  const auto f = [&](double s) { return x.at(s) - threshold.edge; };
  const Stretches stretches(x, t);
  double from = 0;
  for (int i = 0; i < stretches.count; ++i) {
    const double to = stretches.end[static_cast<std::size_t>(i)];
    if (threshold.closed(x.at(to)) != before) {
      const double f_from = f(from), f_to = f(to);
      if (f_from * f_to < 0) return root(f, from, to);
      return f_to == 0 && f_from != 0 ? to : from;
    }
    from = to;
  }
  return kInfinity;
}

CommandPiece shifted(const CommandPiece& c, double t) noexcept {
  return {c.p + (c.v + 0.5 * c.a * t) * t, c.v + c.a * t, c.a};
}

/// The first position on the other side of the edge, seen from a position where the input is `closed_before`.
double beyond(const Threshold& threshold, bool closed_before) noexcept {
  if (!closed_before) return threshold.edge;
  return std::nextafter(threshold.edge, threshold.closed_below ? kInfinity : -kInfinity);
}

}  // namespace

Motor::Motor(const config::SimAxis& truth)
    : truth_(truth),
      edges_{Threshold{kNegLimit, truth.neg_limit, true}, Threshold{kPosLimit, truth.pos_limit, false},
             Threshold{kHome, truth.home_switch, truth.home_active_below}, Threshold{kProbe, kNoContact, true}} {
  restore(truth.start);
}

void Motor::restore(double position) noexcept {
  position_ = position, velocity_ = 0;
  first_ = waiting_ = 0;
  if (truth_.delay_s > 0) remember({position, 0, 0}, truth_.delay_s);
}

std::uint32_t Motor::inputs() const noexcept {
  std::uint32_t bits = 0;
  for (const auto& t : edges_)
    if (t.closed(position_)) bits |= t.input;
  return bits;
}

Ran Motor::run(const CommandPiece& command, double dt, std::uint32_t watch) noexcept {
  if (truth_.delay_s <= 0) return follow(command, truth_.lag_s, dt, watch);
  // What is acted on now was commanded delay_s ago; what is commanded now joins the end of the queue for as long as it
  // was really run.
  Ran ran{0, 0, position_};
  while (dt - ran.elapsed_s > kNoTime_s && waiting_ > 0 && ran.changed == 0) {
    Delayed& oldest = delayed_[first_];
    const double step = std::min(oldest.dt, dt - ran.elapsed_s);
    const Ran part = follow(oldest.command, truth_.lag_s, step, watch);
    remember(shifted(command, ran.elapsed_s), part.elapsed_s);
    ran = {ran.elapsed_s + part.elapsed_s, part.changed, part.position};
    oldest.command = shifted(oldest.command, part.elapsed_s);
    oldest.dt -= part.elapsed_s;
    if (oldest.dt <= kNoTime_s) {
      first_ = (first_ + 1) % delayed_.size();
      --waiting_;
    }
  }
  if (ran.changed == 0) ran.elapsed_s = dt;
  return ran;
}

Ran Motor::coast(double dt, std::uint32_t watch) noexcept {
  const double stops_s = truth_.coast > 0 ? std::abs(velocity_) / truth_.coast : 0;
  Ran ran{0, 0, position_};
  if (stops_s > 0)
    ran = follow({position_, velocity_, -std::copysign(truth_.coast, velocity_)}, 0, std::min(dt, stops_s), watch);
  if (ran.elapsed_s >= stops_s) velocity_ = 0;
  // Commands that are still on their way find no torque: it stands where it is.
  first_ = waiting_ = 0;
  if (truth_.delay_s > 0) remember({position_, 0, 0}, truth_.delay_s);
  if (ran.changed == 0) ran.elapsed_s = dt;
  return ran;
}

Ran Motor::follow(const CommandPiece& command, double lag_s, double dt, std::uint32_t watch) noexcept {
  if (stalled_) {
    velocity_ = 0;
    return {dt, 0, position_};
  }
  const bool standing = command.v == 0 && command.a == 0;
  if (standing && position_ == command.p) {
    velocity_ = 0;
    return {dt, 0, position_};
  }
  const Course course(command, position_, lag_s);
  // What lies farther away than this is not met.
  const double reach = course.reach(dt) * (1 + 1e-9) + 2 * std::abs(course.at(0) - position_) + kRest;
  std::array<double, 4> met{};
  double elapsed = dt;
  for (std::size_t i = 0; i < edges_.size(); ++i) {
    const bool near = (watch & edges_[i].input) != 0 && std::abs(edges_[i].edge - position_) <= reach;
    met[i] = near ? crossing(course, edges_[i], position_, dt) : kInfinity;
    elapsed = std::min(elapsed, met[i]);
  }
  if (elapsed != faded_s_ || lag_s != faded_lag_s_)
    faded_s_ = elapsed, faded_lag_s_ = lag_s, faded_ = course.fade(elapsed);
  const double start = position_, decayed = course.k * faded_;
  position_ = course.at(elapsed, decayed);
  velocity_ = course.speed(elapsed, decayed);
  if (standing && std::abs(position_ - command.p) < kRest) position_ = command.p, velocity_ = 0;

  // The motor is put exactly on the edge that it met, on the side where the level has changed, so that rounding cannot
  // show the same edge twice.
  Ran ran{elapsed, 0, 0};
  for (std::size_t i = 0; i < edges_.size(); ++i)
    if (met[i] <= elapsed && std::abs(position_ - edges_[i].edge) <= kRest)
      position_ = beyond(edges_[i], edges_[i].closed(start));
  for (const auto& t : edges_)
    if ((watch & t.input) != 0 && t.closed(position_) != t.closed(start)) ran.changed |= t.input;
  ran.position = position_;
  return ran;
}

void Motor::remember(const CommandPiece& command, double dt) noexcept {
  if (dt <= 0) return;
  if (waiting_ == delayed_.size()) {  // far more pieces than a cycle makes: the newest one is stretched
    delayed_[(first_ + waiting_ - 1) % delayed_.size()].dt += dt;
    return;
  }
  delayed_[(first_ + waiting_++) % delayed_.size()] = {command, dt};
}

}  // namespace gantry::sim
