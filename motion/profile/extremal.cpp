#include "motion/profile/extremal.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace gantry::motion::scaled {
namespace {

constexpr double kEps = std::numeric_limits<double>::epsilon();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

double square(double x) noexcept { return x * x; }

}  // namespace

Extremal::Extremal(const Ends& ends, const Box& box) noexcept : e_(ends), b_(box) {
  up_ = 1 / b_.j_up, down_ = 1 / b_.j_down, c_ = (up_ + down_) / 2;
  d_ = (e_.vf - e_.v0) - (e_.af - e_.a0) * (e_.af + e_.a0) * up_ / 2;
  unsure_ = 8 * kEps * (std::abs(e_.v0) + std::abs(e_.vf) + (square(e_.a0) + square(e_.af)) * up_ / 2);
  // Where one ramp from a0 to af does it (D = 0) rounding must not decide: only one of the two sides knows that ramp.
  if (std::abs(d_) <= unsure_) {
    d_ = 0;
    reversed_ = e_.a0 <= 0 && e_.af <= 0;
  } else {
    reversed_ = d_ < 0;
  }
  if (reversed_) {
    e_ = {ends.vf, -ends.af, ends.v0, -ends.a0};
    std::swap(b_.a_up, b_.a_down);
    d_ = -d_;
  }
  still_ = (e_.af - e_.a0) * up_;

  double begin = -e_.af;
  bool gap = true;
  const double hole_2 = e_.a0 > 0 ? square(e_.a0) - d_ / c_ : 0;
  if (hole_2 > unsure_) {
    const double hole = std::sqrt(hole_2);
    edge_ = unsure_ / (2 * hole);
    if (begin < -hole + edge_) add(begin, std::max(begin, -hole), gap);  // one motion alone, where one ramp does it
    begin = std::max(begin, parameter(c_ * hole_2));
  }
  const double room = std::max(b_.v_up - e_.vf + square(e_.af) * up_ / 2, 0.0);
  add(begin, std::max(begin, parameter(room)), gap);
  const Region last = region_[count_ - 1];
  region_[count_++] = {last.t_end, kInfinity, last.x_end, last.x_end, Region::Form::Coast, false, true};
}

/// x >= 0 at which c L^2 + a_down k is so much.
double Extremal::parameter(double sum) const noexcept {
  const double full = c_ * square(b_.a_down);
  return sum < full ? std::sqrt(sum / c_) : b_.a_down + (sum - full) / b_.a_down;
}

/// Regions from x_begin to x_end, cut where a bound begins or ends to matter.
void Extremal::add(double x_begin, double x_end, bool after_gap) noexcept {
  double knots[5];
  int n = 0;
  const auto knot = [&](double x) {
    if (x > x_begin && x < x_end) knots[n++] = x;
  };
  const double at_peak = c_ * square(b_.a_up) - d_;  // c x^2 + a_down k where P reaches a_up
  const double narrow = at_peak > 0 ? std::sqrt(at_peak / c_) : 0;
  if (narrow > 0) knot(-narrow);
  if (x_begin < 0) knot(0);
  if (narrow > 0 && narrow < b_.a_down) knot(narrow);
  knot(b_.a_down);
  const double beyond = at_peak - c_ * square(b_.a_down);
  if (beyond > 0) knot(b_.a_down + beyond / b_.a_down);

  double x = x_begin, t = duration_at(x_begin);
  for (int i = 0; i <= n; ++i) {
    const double next = i < n ? knots[i] : x_end, t_next = std::max(duration_at(next), t), middle = (x + next) / 2;
    const bool low = middle >= b_.a_down;
    const bool peak = low ? middle - b_.a_down >= beyond / b_.a_down : c_ * square(middle) >= at_peak;
    using Form = Region::Form;
    const Form form = peak ? (low ? Form::PeakAndLow : Form::Peak) : (low ? Form::Low : Form::Free);
    region_[count_++] = {t, t_next, x, next, form, after_gap && i == 0, x >= 0};
    x = next, t = t_next;
  }
}

Extremal::Arc Extremal::arc_at(double x) const noexcept {
  Arc a;
  a.low = std::min(x, b_.a_down);
  a.hold_low = std::max(x - b_.a_down, 0.0);
  const double g = d_ + c_ * square(a.low) + b_.a_down * a.hold_low, full = c_ * square(b_.a_up);
  a.peak = g < full ? std::sqrt(g / c_) : b_.a_up;
  a.hold_peak = std::max(g - full, 0.0) / b_.a_up;
  return a;
}

double Extremal::duration_at(double x) const noexcept {
  const Arc a = arc_at(x);
  return still_ + 2 * c_ * (a.peak + a.low) + a.hold_peak + a.hold_low;
}

Extremal::Arc Extremal::arc(double duration, const Region& region) const noexcept {
  if (duration <= region.t_begin) return arc_at(region.x_begin);
  if (duration >= region.t_end && region.form != Region::Form::Coast) return arc_at(region.x_end);
  const double s = duration - still_;
  Arc a;
  switch (region.form) {
    case Region::Form::Free: {  // 2c (P + L) = s,  c P^2 = D + c L^2
      const double half = s / (2 * c_);
      a.low = (half - d_ / (c_ * half)) / 2;
      a.peak = half - a.low;
      break;
    }
    case Region::Form::Peak:  // 2c (a_up + L) + h = s,  c a_up^2 + a_up h = D + c L^2
      a.peak = b_.a_up;
      a.low = std::sqrt(std::max(s * b_.a_up - d_, 0.0) / c_) - b_.a_up;
      a.hold_peak = std::max(s - 2 * c_ * (a.peak + a.low), 0.0);
      break;
    case Region::Form::Low:  // 2c (P + a_down) + k = s,  c P^2 = D + c a_down^2 + a_down k
      a.low = b_.a_down;
      a.peak = std::sqrt((d_ + s * b_.a_down) / c_) - b_.a_down;
      a.hold_low = std::max(s - 2 * c_ * (a.peak + a.low), 0.0);
      break;
    case Region::Form::PeakAndLow: {  // a_up h - a_down k = D + c a_down^2 - c a_up^2
      a.peak = b_.a_up, a.low = b_.a_down;
      const double both = s - 2 * c_ * (a.peak + a.low), apart = d_ + c_ * (square(a.low) - square(a.peak));
      a.hold_low = std::max((a.peak * both - apart) / (a.peak + a.low), 0.0);
      a.hold_peak = std::max(both - a.hold_low, 0.0);
      break;
    }
    case Region::Form::Coast:
      a = arc_at(region.x_begin);
      a.coast = duration - region.t_begin;
      break;
  }
  return a;
}

Extremal::Reach Extremal::reach(const Arc& m, const Region& region) const noexcept {
  constexpr double kSixth = 1.0 / 6;
  double p = 0, v = e_.v0, a = e_.a0;
  const auto ramp = [&](double t, double to, double j_sixth) {  // a constant jerk from a to `to`
    p += t * (v + t * (a / 2 + t * j_sixth));
    v += t * (a + to) / 2;
    a = to;
  };
  const auto hold = [&](double t) {
    p += t * (v + t * a / 2);
    v += t * a;
  };
  const double rise = std::max(m.peak - e_.a0, 0.0) * up_, fall = std::max(m.peak + m.low, 0.0) * down_;
  ramp(rise, m.peak, b_.j_up * kSixth);
  hold(m.hold_peak);
  const double h = v + m.peak * fall / 2;
  ramp(fall, -m.low, -b_.j_down * kSixth);
  hold(m.hold_low);
  ramp(std::max(e_.af + m.low, 0.0) * up_, e_.af, b_.j_up * kSixth);
  if (region.form == Region::Form::Coast) return {p + b_.v_up * m.coast, b_.v_up};
  return {p, h};
}

/// dH/dT, from H = v0 + (P^2 - a0^2)/(2 j_up) + a_up h + P (P + L)/(2 j_down) and what P, L, h are of T.
double Extremal::bend(const Arc& m, Region::Form form) const noexcept {
  const double both = m.peak + m.low;
  switch (form) {
    case Region::Form::Free: return (m.peak * m.low / both * up_ + both * down_ / 2) / (2 * c_);
    case Region::Form::Peak: return b_.a_up * (1 + (down_ / 2 - 2 * c_) * b_.a_up / (2 * c_ * both));
    case Region::Form::Low: return (m.peak * up_ + (m.peak + both) * down_ / 2) * b_.a_down / (2 * c_ * both);
    case Region::Form::PeakAndLow: return b_.a_up * b_.a_down / both;
    case Region::Form::Coast: break;
  }
  return 0;
}

Shape Extremal::shape(double duration, const Region& region) const noexcept {
  const Arc m = arc(duration, region);
  Shape s;
  s.t[0] = std::max(m.peak - e_.a0, 0.0) * up_;
  s.t[1] = m.hold_peak;
  s.t[2] = (m.low >= 0 ? m.peak : std::max(m.peak + m.low, 0.0)) * down_;  // one fall, split where a = 0
  s.t[3] = m.coast;
  s.t[4] = std::max(m.low, 0.0) * down_;
  s.t[5] = m.hold_low;
  s.t[6] = std::max(e_.af + m.low, 0.0) * up_;
  s.j[0] = s.j[6] = b_.j_up;
  s.j[2] = s.j[4] = -b_.j_down;
  if (reversed_) std::reverse(s.t, s.t + 7);
  return s;
}

const Extremal::Region* Extremal::find(double duration, double slack) const noexcept {
  for (int i = 0; i < count_; ++i) {
    if (duration < region_[i].t_begin - slack) return nullptr;
    const bool edge = i + 1 < count_ && region_[i + 1].after_gap;
    if (duration <= region_[i].t_end + (edge ? slack : 0)) return &region_[i];
  }
  return nullptr;
}

// x < 0.  P below a_up, m = P + x, P = (m + D/(c m))/2:   H = k + alpha m^2 + beta/m^2, a quadratic in m^2.
//         P at a_up:  H = c x^2 + x a_up/(2 j_down) + v0 - a0^2/(2 j_up) + D.
int Extremal::turns(const Region& region, double* out) const noexcept {
  const double base = e_.v0 - square(e_.a0) * up_ / 2;
  double t[2];
  int n = 0;
  if (region.form == Region::Form::Free) {
    const double alpha = 1 / (8 * b_.j_up) + 1 / (4 * b_.j_down), beta = square(d_ / c_) / (8 * b_.j_up);
    const double k = base + d_ / 2, disc = k * k - 4 * alpha * beta;
    if (k < 0 && disc >= 0)
      for (const double sign : {-1.0, 1.0}) {
        const double z = (-k + sign * std::sqrt(disc)) / (2 * alpha);
        if (z > 0) t[n++] = still_ + 2 * c_ * std::sqrt(z);
      }
  } else if (region.form == Region::Form::Peak) {
    const double half = b_.a_up / (4 * b_.j_down * c_), disc = half * half - (base + d_) / c_;
    if (disc >= 0)
      for (const double sign : {-1.0, 1.0}) t[n++] = duration_at(-half + sign * std::sqrt(disc));
  }
  int kept = 0;
  for (int i = 0; i < n; ++i)
    if (t[i] > region.t_begin && t[i] < region.t_end) out[kept++] = t[i];
  return kept;
}

double Extremal::blur(double duration, const Region& region) const noexcept {
  const Arc m = arc(duration, region);
  const double of_peak = m.peak > 0 ? std::min(std::sqrt(unsure_), unsure_ / m.peak) : std::sqrt(unsure_);
  const double of_edge = 2 * c_ * (1 + (m.peak > 0 ? std::abs(m.low) / m.peak : 0)) * edge_;
  return std::abs(reach(duration, region).dp_dt) * (of_peak + of_edge);
}

}  // namespace gantry::motion::scaled
