#include "motion/path/timing.hpp"

#include <cmath>

namespace gantry::motion {

// In two halves of duration h with jerks j1, j2 between (v0, a0) and (v1, a1), over the length l:
//   a_m = (v1 - v0)/h - (a0 + a1)/2,   l = (v0 + v1) h + (a0 - a1) h^2/3.
std::vector<TimePiece> timed(std::span<const PaceCell> cells, std::span<const PaceNode> nodes) {
  std::vector<TimePiece> out;
  double s = 0;
  for (std::size_t k = 0; k < cells.size(); ++k) {
    const double l = cells[k].length;
    const auto [v0, a0] = nodes[k];
    const auto [v1, a1] = nodes[k + 1];
    if (v0 <= 0) {
      const double t = 3 * l / v1;
      out.push_back({t, s, 0, 0, 6 * l / (t * t * t)});
    } else if (v1 <= 0) {
      const double t = 3 * l / v0, j = 6 * l / (t * t * t);
      out.push_back({t, s, j * t * t / 2, -j * t, j});
    } else {
      const double sum = v0 + v1, change = a0 - a1;
      const double h = 2 * l / (sum + std::sqrt(std::max(0.0, sum * sum + 4 * change * l / 3)));
      const double middle = (v1 - v0) / h - (a0 + a1) / 2;
      const TimePiece first{h, s, v0, a0, (middle - a0) / h};
      const State x = after(first, h);
      out.push_back(first);
      out.push_back({h, x.p, x.v, middle, (a1 - middle) / h});
    }
    s += l;
  }
  return out;
}

}  // namespace gantry::motion
