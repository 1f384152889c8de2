#include "motion/path/outline.hpp"

#include <algorithm>
#include <cmath>

namespace gantry::motion {
namespace {

constexpr double kSamePoint = 1e-9;  ///< mm

AxisVec difference(const AxisVec& a, const AxisVec& b, std::size_t axes) {
  AxisVec out{};
  for (std::size_t i = 0; i < axes; ++i) out[i] = a[i] - b[i];
  return out;
}

}  // namespace

// A chord fits where every point between its ends is within the tolerance of it and none goes back along it by more.
Outline::Chord Outline::chord(std::size_t from, std::size_t to) const {
  const std::size_t n = measure_.axes;
  AxisVec displacement = difference(waiting_[to].q, waiting_[from].q, n);
  const double length = aside(measure_, displacement);
  Chord out{0, from, true};
  double reached = 0;
  for (std::size_t k = from + 1; k < to; ++k) {
    double on = 0, square = 0;
    for (std::size_t i = 0; i < n; ++i) {
      const double x = measure_.weight[i] * (waiting_[k].q[i] - waiting_[from].q[i]);
      square += x * x;
      on += x * measure_.weight[i] * displacement[i];
    }
    on = length > 0 ? on / length : 0;
    const double nearest = std::clamp(on, 0.0, length);
    // The distance from the differences themselves, so that a point on the chord has none but rounding.
    double off = 0;
    for (std::size_t i = 0; i < n; ++i) {
      const double x = measure_.weight[i] *
                       (waiting_[k].q[i] - waiting_[from].q[i] - (length > 0 ? displacement[i] * nearest / length : 0));
      off += x * x;
    }
    off = std::sqrt(off);
    if (off > out.aside_mm) out.aside_mm = off, out.farthest = k;
    if (off > tolerance_mm_ || on < reached - tolerance_mm_) out.fits = false;
    reached = std::max(reached, on);
  }
  return out;
}

// Where the chord to the last point does not fit any more: at the farthest point, if both sides of it are straight (a
// corner), else as late as possible (a bend: the middle would give chords of half the length).
std::size_t Outline::best_break() const {
  constexpr double kCorner = 0.1;  // of a bend the halves are 1/4 as far from their chords
  const std::size_t last = waiting_.size() - 1;
  const Chord whole = chord(0, last);
  const std::size_t m = whole.farthest;
  if (m == 0) return last - 1;
  const double halves = std::max(chord(0, m).aside_mm, chord(m, last).aside_mm);
  return halves <= kCorner * whole.aside_mm && chord(0, m).fits ? m : last - 1;
}

void Outline::emit(std::size_t last, std::vector<Vertex>& out) {
  Vertex v = waiting_[last];
  alone_ = false;
  double before = 0;
  for (std::size_t k = 1; k <= last; ++k) before = std::max(before, waiting_[k].aside_mm);
  v.aside_mm = before + chord(0, last).aside_mm;
  out.push_back(v);
  waiting_.erase(waiting_.begin(), waiting_.begin() + static_cast<std::ptrdiff_t>(last));
}

// Of a straight line any number of points may wait: every second one that lies on the chord of its neighbours, but for
// a thousandth of the tolerance, is forgotten, and the next one remembers how far off it was.
bool Outline::thin_out() {
  const double flat = 1e-3 * tolerance_mm_;
  std::vector<Vertex> kept{waiting_.front()};
  for (std::size_t k = 1; k < waiting_.size(); ++k) {
    if (k % 2 == 1 && k + 1 < waiting_.size()) {
      const Chord over = chord(k - 1, k + 1);
      const double off = over.aside_mm + waiting_[k].aside_mm;
      if (over.fits && over.aside_mm <= flat) {
        waiting_[k + 1].aside_mm = std::max(waiting_[k + 1].aside_mm, off);
        continue;
      }
    }
    kept.push_back(waiting_[k]);
  }
  const bool thinner = kept.size() < waiting_.size();
  waiting_ = std::move(kept);
  return thinner;
}

void Outline::add(const AxisVec& p, double aside_mm, std::vector<Vertex>& out) {
  if (waiting_.empty()) {
    waiting_.push_back({p, 0, false});
    out.push_back(waiting_.back());
    return;
  }
  if (aside(measure_, difference(p, waiting_.back().q, measure_.axes)) < kSamePoint) return;
  waiting_.push_back({p, aside_mm, false});
  while (waiting_.size() > 2 && !chord(0, waiting_.size() - 1).fits) emit(best_break(), out);
  if (waiting_.size() > kMostWaiting && !thin_out()) emit(waiting_.size() - 2, out);
}

// A path that comes back to where it began, all of it within the tolerance, goes out to its farthest point
// nevertheless.
void Outline::finish(std::vector<Vertex>& out) {
  if (alone_ && waiting_.size() > 2 &&
      aside(measure_, difference(waiting_.back().q, waiting_.front().q, measure_.axes)) < kSamePoint)
    emit(chord(0, waiting_.size() - 1).farthest, out);
  if (waiting_.size() > 1) emit(waiting_.size() - 1, out);
  waiting_.clear();
  alone_ = true;
}

}  // namespace gantry::motion
