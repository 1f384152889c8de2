// Where the tool is on a stretch at a time: constant-jerk pieces give s, curves give the axes.
//   PathCursor c;  for (t ...) CurveSetpoint x = c.at(stretch, t, axes);     // t rises: each call goes on from the
//   last
// For benches and tests: the machine plays segments (run.hpp).
#pragma once
#include "motion/path/timing.hpp"

namespace gantry::motion {

struct CurveSetpoint {
  AxisVec q{}, v{}, a{};
  double s = 0, s_dot = 0;  ///< in the stretch, and the tool's speed
};

class PathCursor {
 public:
  [[nodiscard]] CurveSetpoint at(const Stretch& stretch, double t, std::size_t axes) noexcept;
  void restart() noexcept { *this = {}; }

 private:
  std::size_t piece_ = 0, curve_ = 0;
  double piece_t_ = 0, curve_s_ = 0;  ///< where they begin
};

}  // namespace gantry::motion
