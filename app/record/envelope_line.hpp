// The worst of each stretch of time, however long a job is: a few hundred stretches, which are merged in pairs when
// they become too many.
//   EnvelopeLine line;   line.add(t_s, value, limit); ...   line.points()
#pragma once
#include <cstddef>
#include <utility>
#include <vector>

namespace gantry::record {

struct EnvelopePoint {
  double t_s = 0;               ///< where the stretch begins
  double value = 0, limit = 0;  ///< of the value that was the largest part of its limit
};

class EnvelopeLine {
 public:
  /// `t_s` never falls; `limit` above 0.
  void add(double t_s, double value, double limit) {
    if (!points_.empty() && t_s < points_.back().t_s + stretch_s_) {
      if (value * points_.back().limit > points_.back().value * limit)
        points_.back().value = value, points_.back().limit = limit;
      return;
    }
    if (points_.size() == kMost) halve();
    points_.push_back({t_s, value, limit});
  }
  [[nodiscard]] const std::vector<EnvelopePoint>& points() const { return points_; }
  [[nodiscard]] double stretch_s() const { return stretch_s_; }

  static constexpr std::size_t kMost = 1200;

 private:
  void halve() {
    stretch_s_ *= 2;
    std::vector<EnvelopePoint> kept;
    for (const EnvelopePoint& p : points_) {
      if (kept.empty() || p.t_s >= kept.back().t_s + stretch_s_)
        kept.push_back(p);
      else if (p.value * kept.back().limit > kept.back().value * p.limit)
        kept.back().value = p.value, kept.back().limit = p.limit;
    }
    points_ = std::move(kept);
  }

  std::vector<EnvelopePoint> points_;
  double stretch_s_ = 0.02;
};

}  // namespace gantry::record
