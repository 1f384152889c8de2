// The trajectory of one axis to its target, whose duration is still open: axes that arrive together agree on one.
//   OpenTrajectory x(from, to, bounds, outside);
//   if (x.reason() == Reason::Solved) t = x.shortest_s();   t = x.first_s(t);   x.write(t, profile);
#pragma once
#include <optional>

#include "motion/profile/corridor.hpp"

namespace gantry::motion {

class OpenTrajectory {
 public:
  OpenTrajectory(const State& from, const State& to, const AxisBounds& bounds, Outside outside) noexcept;

  [[nodiscard]] Reason reason() const noexcept { return reason_; }
  [[nodiscard]] double shortest_s() const noexcept { return shortest_s_; }
  /// First duration >= t that is not blocked; negative: none was found.
  double first_s(double t) noexcept;
  /// What it means when first_s() or write() find nothing.
  [[nodiscard]] Reason reason_of_none() const noexcept { return route_ ? Reason::NoMotionWithin : Reason::NoSolution; }
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

}  // namespace gantry::motion
