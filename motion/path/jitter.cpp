#include "motion/path/jitter.hpp"

#include <algorithm>
#include <cmath>

#include "motion/path/rounding.hpp"

namespace gantry::motion {
namespace {

constexpr double kShortLeg = 4;  // tolerances: of the legs of a jump
constexpr double kCalm = 16;     // tolerances of way without a jump end it

}  // namespace

Jitter::Jitter(const Measure& measure, double tolerance_mm, double share)
    : measure_(measure), tolerance_mm_(tolerance_mm), outline_(measure, share * tolerance_mm) {}

double Jitter::distance(const AxisVec& a, const AxisVec& b) const {
  AxisVec d{};
  for (std::size_t i = 0; i < measure_.axes; ++i) d[i] = b[i] - a[i];
  return aside(measure_, d);
}

/// A sharp turn beside a short leg, at the last vertex.
bool Jitter::jumps(const AxisVec& next) const {
  if (!before_) return false;
  const double in = distance(*before_, last_->q), out = distance(last_->q, next);
  if (std::min(in, out) > kShortLeg * tolerance_mm_ || !(in > 0 && out > 0)) return false;
  AxisVec turn{};
  for (std::size_t i = 0; i < measure_.axes; ++i)
    turn[i] = (next[i] - last_->q[i]) / out - (last_->q[i] - (*before_)[i]) / in;
  return aside(measure_, turn) > kSharp;
}

/// The last vertex goes its way.
void Jitter::pass(bool jumps, std::vector<Vertex>& out) {
  if (jumps && !jumping_) {
    std::vector<Vertex> gone;  // where it begins has gone out before
    outline_.add(*before_, 0, gone);
    jumping_ = true;
  }
  if (!jumping_) {
    out.push_back(*last_);
    return;
  }
  outline_.add(last_->q, last_->aside_mm, out);
  calm_mm_ = jumps ? 0 : calm_mm_ + distance(*before_, last_->q);
  if (calm_mm_ < kCalm * tolerance_mm_) return;
  outline_.finish(out);
  jumping_ = false;
}

void Jitter::add(const Vertex& v, std::vector<Vertex>& out) {
  if (last_) {
    pass(jumps(v.q), out);
    before_ = last_->q;
  }
  last_ = v;
}

void Jitter::finish(std::vector<Vertex>& out) {
  if (!last_) return;
  pass(false, out);
  if (jumping_) outline_.finish(out);
  jumping_ = false;
  calm_mm_ = 0;
  before_.reset(), last_.reset();
}

}  // namespace gantry::motion
