// s(t) as pieces of constant jerk, and what stands beside every plan: an integrator that shares nothing with the
// planner and looks whether the plan keeps what it promises.
#pragma once
#include <span>
#include <string>
#include <vector>

#include "motion/path/pace.hpp"

namespace gantry::motion {

/// Constant jerk for a while; s counts from the start of the stretch.
struct TimePiece {
  double duration_s = 0;
  double s = 0, v = 0, a = 0, j = 0;  ///< at its start
};

/// State after time t in the piece.
[[nodiscard]] inline State after(const TimePiece& p, double t) noexcept { return advanced({p.s, p.v, p.a}, p.j, t); }

/// Into how many pieces a cell between these nodes is timed.
[[nodiscard]] inline std::size_t pieces_between(const PaceNode& begin, const PaceNode& end) noexcept {
  return begin.v <= 0 || end.v <= 0 ? 1 : 2;
}

/// Pieces between nodes: one in a cell that begins or ends at rest, else two of equal duration.
[[nodiscard]] std::vector<TimePiece> timed(std::span<const PaceCell> cells, std::span<const PaceNode> nodes);

/// A stretch of path with its time. curves[k] begins where curves[k - 1] ends, pieces likewise.
struct Stretch {
  std::vector<Curve> curves;
  std::vector<TimePiece> pieces;
  double length_mm = 0, duration_s = 0;
};

/// What was found; `share` > 1 means that a limit is broken.
struct Inspection {
  bool sound = false;       ///< s stays within [0, length] and never goes back, pieces join, limits hold x 1.001
  double share = 0;         ///< largest use of a limit, as a factor of time: sqrt of acceleration, cube root of jerk
  bool only_speed = false;  ///< what is broken is the set speed or an axis' speed, and nothing else
  std::string reason;
  std::vector<double> piece_share;  ///< the same for each piece, as far as was looked
};

/// from: the state before the stretch.
[[nodiscard]] Inspection inspect(const Stretch& stretch, const Limits& limits, double v_set, const State& from);

}  // namespace gantry::motion
