// What p can be reached in T, and when a given p can be: the two extremal motions beside each other.
//   Reachable r(ends, box);
//   Found f = r.first(p, resolution);             // shortest;  r.first(p, resolution, t): the first from t on
//   Shape s = r.shape(f);                         // its motion, when it is at an end of the interval
//   Mix m = r.mix(T, p, resolution);              // a motion of exactly T, wherever in the interval
// All in scaled units.
#pragma once
#include <optional>

#include "motion/profile/extremal.hpp"

namespace gantry::motion::scaled {

enum class Side : std::uint8_t { None, Up, Down, Between };

struct Found {
  double duration = -1;
  Side side = Side::None;  ///< None: numerically out of range
  int region = 0;          ///< of that side's family
};

/// share * up + (1 - share) * down: both last T, and so does every mix of their jerks.
struct Mix {
  bool possible = false;
  double share = 1;
  double missing = 0;  ///< what p is outside of the interval by
  Shape up, down;
};

class Reachable {
 public:
  Reachable(const Ends& ends, const Box& box) noexcept : ends_(ends), box_(box), up_(ends, box) {}

  /// Shortest duration >= from_t in which p can be gone; `resolution`: what p is uncertain by.
  [[nodiscard]] Found first(double p, double resolution, double from_t = 0) noexcept;
  /// Beginning of the next stretch of durations in which p can be gone, after the one that begins with `found`.
  [[nodiscard]] Found next(double p, double resolution, const Found& found) noexcept;
  /// `found.side` is Up or Down.
  [[nodiscard]] Shape shape(const Found& found) noexcept;
  /// A motion of that duration.
  [[nodiscard]] Mix mix(double duration, double p, double resolution) noexcept;

 private:
  const Extremal& down() noexcept;

  Ends ends_;
  Box box_;
  Extremal up_;
  std::optional<Extremal> down_;  ///< made when asked for: most shortest motions need one side alone
};

}  // namespace gantry::motion::scaled
