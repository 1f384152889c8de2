// One axis between entering its bounds and its target, whose duration is still open: what arriving together needs.
//   Way way(from, to, bounds, outside);     if (way.reason() == Reason::Solved)
//   t = way.shortest_s();   t = way.first_s(t);   way.write(t, profile);
#pragma once
#include <algorithm>
#include <optional>
#include <span>

#include "motion/profile/corridor.hpp"

namespace gantry::motion {

inline constexpr double kEqual = 1e-13;  ///< durations that differ by less, relatively, are one

class Way {
 public:
  Way(const State& from, const State& to, const AxisBounds& bounds, Outside outside) noexcept;

  [[nodiscard]] Reason reason() const noexcept { return reason_; }
  [[nodiscard]] double shortest_s() const noexcept { return shortest_s_; }
  /// First duration >= t that is not blocked; negative: none was found.
  double first_s(double t) noexcept;
  /// What it means when first_s() or write() find nothing.
  [[nodiscard]] Reason reason_of_none() const noexcept { return route_ ? Reason::NoWayWithin : Reason::NoSolution; }
  /// A profile of that duration, which first_s() has given. False: numerically out of range.
  bool write(double t, Profile& profile) noexcept;

 private:
  [[nodiscard]] Corridor corridor() const noexcept;
  void enter_corridor() noexcept;

  Profile entered_;  // phases that brought the start inside
  double entered_s_ = 0, shortest_s_ = 0;
  State inside_, to_;
  AxisBounds bounds_;
  Reason reason_ = Reason::NoSolution;
  std::optional<Phase> ramp_;  // where one leads to the target
  Scale scale_;
  double p_ = 0, resolution_ = 0, scale_p_ = 0;
  std::optional<scaled::Reachable> reachable_;
  scaled::Found shortest_;
  std::optional<Route> route_;  // with position limits: of the duration that was asked for last
};

/// t rounded up to a multiple of the cycle; cycle 0: t.
[[nodiscard]] double on_grid(double t, double cycle_s) noexcept;

/// First duration >= least, on the grid, that none of the ways has blocked; negative: none was found.
template <class AnyWay>
[[nodiscard]] double common_duration(std::span<std::optional<AnyWay>> ways, double least, double cycle_s) noexcept {
  constexpr int kMostRounds = 64;  // each axis has two gaps at most; a grid may take a few tries over each
  double t = on_grid(least, cycle_s);
  for (int round = 0; round < kMostRounds; ++round) {
    double need = t;
    for (auto& way : ways) {
      if (!way) continue;
      const double first = way->first_s(t);
      if (first < 0) return -1;
      need = std::max(need, first);
    }
    if (need <= t * (1 + kEqual)) return t;
    t = on_grid(need, cycle_s);
  }
  return -1;
}

}  // namespace gantry::motion
