// How the rate changes at which the planned time of a path is played: to 0 for a stop, back to 1, to an override.
//   RateChange change;
//   if (change.plan(cursor, {1, 0}, 0, recent, limits, {.use = 1, .land = 0.85}))     // else: not from here, not so
//     while (change.under_way()) { step = change.next(); tau += step.ahead; }         // hard, or not yet
// With tau the planned time and r = dtau/dt an axis has q' = n' r, q'' = n'' r^2 + n' r', q''' = n''' r^3 + 3 n'' r r'
// + n' r'': any constant r <= 1 keeps all limits. A change of rate is played to its end before it is adopted,
// tick by tick, and judged by the differences of its setpoints. Lives in the loop: no allocation, bounded work.
#pragma once
#include <array>
#include <limits>
#include <optional>

#include "motion/rt/differences.hpp"
#include "motion/rt/piece_cursor.hpp"
#include "motion/types.hpp"

namespace gantry::motion {

/// dtau/dt and its derivative.
struct Rate {
  double r = 1, slope = 0;
};

class RateChange {
 public:
  /// Ticks of a change, and of those that a tick plays ahead before it tries no more: both bound its work.
  static constexpr std::size_t kMostTicks = 1000, kEnoughWork = 400;

  /// How hard: shares of the room for r'' that a change and its end may use, of what can be seen at one place.
  struct Vigour {
    double use = 1, land = 0.85;
  };
  /// What a stop tries, the hardest first.
  static constexpr std::array<Vigour, 8> kStops{
      {{1, 0.85}, {0.9, 0.6}, {0.75, 0.55}, {0.6, 0.5}, {0.45, 0.45}, {0.3, 0.4}, {0.2, 0.4}, {0.1, 0.4}}};

  struct Step {
    double ahead = 0;  ///< planned time that goes by in the tick
    Rate end;
  };

  /// False: it would break a limit, run out of the known path, or take too long or as much planned time as `shorter_s`;
  /// what is under way stays.
  bool plan(PieceCursor from, const Rate& now, double to, const Recent& recent, const Limits& limits,
            const Vigour& vigour, double shorter_s = std::numeric_limits<double>::infinity()) noexcept;

  /// To 0, tried in each tick: the first way to stop that is possible is taken, and then any harder one that becomes
  /// possible and needs less. Where they take more than kMostTicks every second tick tries a lower rate instead, from
  /// which there may be one. `tries`: how many have been tried, 0 at the order. The rate to which what is under way
  /// leads, if that is new.
  std::optional<double> stop(const PieceCursor& from, const Rate& now, const Recent& recent, const Limits& limits,
                             unsigned& tries) noexcept;
  /// How often a tick has been played ahead since the last stop() began.
  [[nodiscard]] std::size_t work() const noexcept { return work_; }

  [[nodiscard]] bool under_way() const noexcept { return next_ < size_; }
  Step next() noexcept { return steps_[active_][next_++]; }
  void drop() noexcept { next_ = size_ = 0, stop_ = kStops.size(); }

  /// Planned time that goes by within `seconds` from now; `after`: the rate when nothing is under way (any more).
  [[nodiscard]] double ahead(double seconds, double after, double tick_s) const noexcept;
  /// Seconds until so much planned time has gone by; `after` is above 0.
  [[nodiscard]] double until(double planned_s, double after, double tick_s) const noexcept;

 private:
  std::array<std::array<Step, kMostTicks>, 2> steps_;
  std::size_t active_ = 0, next_ = 0, size_ = 0;
  std::size_t work_ = 0;              ///< ticks played ahead, some twice
  std::size_t stop_ = kStops.size();  ///< which of them is under way; none: the size
  bool too_long_ = false;             ///< the last plan took more ticks than may be, or more path than is known
  bool lower_next_ = false;           ///< the next tick tries a lower rate
  std::size_t lowered_ = 0;           ///< how many were tried since the order
};

}  // namespace gantry::motion
