#include "motion/path/spread.hpp"

#include <algorithm>
#include <cmath>

namespace gantry::motion {
namespace {

constexpr double kGentle = 0.5;  ///< |d2 - d1|
constexpr double kUneven = 6;    ///< ratio of legs

}  // namespace

void Spread::settle(std::size_t k) {
  const Knot &a = knots_[k - 1], &b = knots_[k + 1];
  Knot& x = knots_[k];
  const double before = x.at - a.at, after = b.at - x.at;
  if (!(before > 0) || !(after > 0)) return;
  AxisVec change{};
  for (std::size_t i = 0; i < measure_.axes; ++i)
    change[i] = (b.vertex.q[i] - x.vertex.q[i]) / after - (x.vertex.q[i] - a.vertex.q[i]) / before;
  x.stays =
      x.vertex.rest || aside(measure_, change) > kGentle || std::max(before, after) > kUneven * std::min(before, after);
}

// Of the parabola through three vertices; at one that stays, of the parabola on its moving side is not known: the
// chord's.
AxisVec Spread::tangent(std::size_t k) const {
  AxisVec out{};
  const Knot &a = knots_[k - 1], &x = knots_[k], &b = knots_[k + 1];
  const double before = x.at - a.at, after = b.at - x.at;
  for (std::size_t i = 0; i < measure_.axes; ++i) {
    const double d1 = (x.vertex.q[i] - a.vertex.q[i]) / before, d2 = (b.vertex.q[i] - x.vertex.q[i]) / after;
    out[i] = (d1 * after + d2 * before) / (before + after);
  }
  return out;
}

Vertex Spread::moved(std::size_t k) {
  Knot& x = knots_[k];
  if (x.stays) return x.vertex;
  std::size_t reach = 1;
  while (reach < kReach && reach < k && k + reach + 1 < knots_.size() && !knots_[k - reach].stays &&
         !knots_[k + reach].stays)
    ++reach;
  double at = 0, weights = 0;
  for (std::size_t n = k - reach; n <= k + reach; ++n) {
    const double weight = static_cast<double>(reach + 1 - (n > k ? n - k : k - n));
    at += weight * knots_[n].at, weights += weight;
  }
  at /= weights;
  std::size_t n = k;
  while (n > k - reach && knots_[n].at > at) --n;
  while (n + 1 < k + reach && knots_[n + 1].at <= at) ++n;
  const Knot &a = knots_[n], &b = knots_[n + 1];
  const double h = b.at - a.at, u = (at - a.at) / h;
  AxisVec chord{}, t0{}, t1{};
  for (std::size_t i = 0; i < measure_.axes; ++i) chord[i] = (b.vertex.q[i] - a.vertex.q[i]) / h;
  if (!a.stays) t0 = tangent(n);
  if (!b.stays) t1 = tangent(n + 1);
  Vertex out = x.vertex;
  AxisVec off{};
  for (std::size_t i = 0; i < measure_.axes; ++i) {
    // At a vertex that stays the curve bends on evenly: its slope mirrors the other end's about the chord.
    const double s0 = a.stays ? 2 * chord[i] - t1[i] : t0[i], s1 = b.stays ? 2 * chord[i] - t0[i] : t1[i];
    off[i] = h * (u * (1 - u) * (1 - u) * (s0 - chord[i]) - u * u * (1 - u) * (s1 - chord[i]));
    out.q[i] = a.vertex.q[i] + u * h * chord[i] + off[i];
  }
  if ((a.stays && b.stays) || aside(measure_, off) > most_aside_mm_) return x.vertex;
  for (std::size_t m = k - reach + 1; m <= k + reach; ++m)
    out.aside_mm = std::max(out.aside_mm, knots_[m].vertex.aside_mm);
  // The old place is a point of the polyline, which the new legs pass at some distance.
  const AxisVec &old = x.vertex.q, &other = knots_[at > x.at ? k - 1 : k + 1].vertex.q;
  AxisVec leg{}, way{};
  for (std::size_t i = 0; i < measure_.axes; ++i) leg[i] = other[i] - out.q[i], way[i] = old[i] - out.q[i];
  double on = 0, square = 0;
  for (std::size_t i = 0; i < measure_.axes; ++i) {
    const double w = measure_.weight[i] * measure_.weight[i];
    on += w * leg[i] * way[i], square += w * leg[i] * leg[i];
  }
  for (std::size_t i = 0; i < measure_.axes; ++i) way[i] -= square > 0 ? leg[i] * on / square : 0;
  x.left_mm = aside(measure_, way);
  if (x.left_mm > most_aside_mm_) {
    x.left_mm = 0;
    return x.vertex;
  }
  if (at > x.at) out.aside_mm = std::max(out.aside_mm, x.left_mm);  // else it lies on the next leg
  return out;
}

void Spread::put(std::size_t k, std::vector<Vertex>& out) {
  Vertex v = moved(k);
  if (k > 0) v.aside_mm = std::max(v.aside_mm, knots_[k - 1].left_mm);
  out.push_back(v);
}

void Spread::add(const Vertex& v, std::vector<Vertex>& out) {
  Knot x{v, 0, true};
  if (!knots_.empty()) {
    AxisVec step{};
    for (std::size_t i = 0; i < measure_.axes; ++i) step[i] = v.q[i] - knots_.back().vertex.q[i];
    x.at = knots_.back().at + along(measure_, step);
  }
  knots_.push_back(x);
  if (knots_.size() > 2) settle(knots_.size() - 2);
  // A knot is moved when those up to kReach + 1 after it are settled.
  for (; done_ + kReach + 2 < knots_.size(); ++done_) put(done_, out);
  while (done_ > kKept) {
    knots_.pop_front();
    --done_;
  }
}

void Spread::finish(std::vector<Vertex>& out) {
  for (; done_ < knots_.size(); ++done_) put(done_, out);
  knots_.clear();
  done_ = 0;
}

}  // namespace gantry::motion
