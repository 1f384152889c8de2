// The motions that come farthest: of all that take (v0, a0) to (vf, af) in a given time T, the one with the largest p.
// Everything the planner does rests on them. For a fixed T the bounds are convex and the motion depends linearly on its
// jerk, so that the displacements p that are possible in T are an interval, from the farthest motion in the opposite
// direction (the mirrored problem) to this one; the shortest motion is the first T whose interval holds p
// (reachable.cpp), and a mix of the two ends reaches any p between them in exactly T (Reachable::mix).
//
// Pontryagin: the jerk is +j_up, 0, -j_down, 0 (coasting at v_up), -j_down, 0, +j_up; zeros are arcs on a bound. The
// acceleration rises from a0 to a peak P (held for h when P = a_up), falls to -L (held for k when L = a_down) and
// rises to af. The speed condition alone gives, with c = (1/j_up + 1/j_down)/2,
//   c P^2 + a_up h = D + c L^2 + a_down k,     D = (vf - v0) - (af^2 - a0^2)/(2 j_up),
// one parameter x = L (beyond a_down: x = a_down + k), for D >= 0. D < 0 is the same problem in reversed time:
// (vf, -af) -> (v0, -a0) with a_up and a_down exchanged, same p. T grows with x, so that T itself is the parameter:
//   T = (af - a0)/j_up + 2c (P + L) + h + k,     and in each region x and P follow from T in closed form.
// Along the family dp/dT = H, the Hamiltonian: (speed where the fall begins) + P w/2, w = (P + L)/j_down the fall's
// duration (the costate of the speed there is w/2). P >= a0 cuts a gap |x| < sqrt(a0^2 - D/c) into the family where
// a0 > 0: durations in which the end state cannot be met at all ("blocked"). x >= -af is the family's beginning; its
// end is where the peak speed vf - af^2/(2 j_up) + c L^2 + a_down k meets v_up, beyond which only the coasting grows.
#pragma once
#include <cstdint>

#include "motion/profile/scaled.hpp"

namespace gantry::motion::scaled {

class Extremal {
 public:
  Extremal(const Ends& ends, const Box& box) noexcept;

  /// A stretch of durations over which the motion is of one form.
  struct Region {
    double t_begin, t_end;
    double x_begin, x_end;  ///< the parameter there
    enum class Form : std::uint8_t { Free, Peak, Low, PeakAndLow, Coast } form;
    bool after_gap;  ///< no motion exists just before t_begin
    bool convex;     ///< p(T) is convex here
  };
  [[nodiscard]] int regions() const noexcept { return count_; }
  [[nodiscard]] const Region& region(int i) const noexcept { return region_[i]; }

  /// Where it comes to in T, and how fast that grows with T. T within the region.
  struct Reach {
    double p = 0, dp_dt = 0;
  };
  [[nodiscard]] Reach reach(double duration, const Region& region) const noexcept {
    return reach(arc(duration, region), region);
  }
  struct Curve : Reach {
    double d2p_dt2 = 0;
  };
  [[nodiscard]] Curve curve(double duration, const Region& region) const noexcept {
    const Arc m = arc(duration, region);
    return {reach(m, region), bend(m, region.form)};
  }
  [[nodiscard]] Shape shape(double duration, const Region& region) const noexcept;
  /// The region that holds T (to within `slack`); nullptr: no motion takes T.
  [[nodiscard]] const Region* find(double duration, double slack) const noexcept;

  /// Durations in a region that is not convex at which dp/dT is 0, ascending; returns how many (at most 2).
  int turns(const Region& region, double* out) const noexcept;
  /// What p is uncertain by where the family begins or a gap lies: rounding of D moves the peak and the gap's edges.
  [[nodiscard]] double blur(double duration, const Region& region) const noexcept;

 private:
  struct Arc {  // what a motion consists of
    double peak = 0, low = 0, hold_peak = 0, hold_low = 0, coast = 0;
  };
  [[nodiscard]] Arc arc(double duration, const Region& region) const noexcept;
  [[nodiscard]] Arc arc_at(double x) const noexcept;
  [[nodiscard]] Reach reach(const Arc& m, const Region& region) const noexcept;
  [[nodiscard]] double bend(const Arc& m, Region::Form form) const noexcept;
  [[nodiscard]] double duration_at(double x) const noexcept;
  [[nodiscard]] double parameter(double sum) const noexcept;
  void add(double x_begin, double x_end, bool after_gap) noexcept;

  Ends e_;  // as used: D >= 0
  Box b_;
  bool reversed_ = false;
  double up_ = 1, down_ = 1;  // 1/j_up, 1/j_down
  double c_ = 1;              // (1/j_up + 1/j_down)/2
  double d_ = 0;              // D
  double unsure_ = 0;         // what D is uncertain by
  double still_ = 0;          // (af - a0)/j_up
  double edge_ = 0;           // what the gap's edges are uncertain by
  Region region_[14];
  int count_ = 0;
};

}  // namespace gantry::motion::scaled
