// Takes the difference out of the two sides of a gantry axis when both have homed at switches of their own: the second
// side goes smoothly to the coordinate of the first. How far that has come, and why it did not.
//   squaring.start(second, first, slow_mm_s, period);   while (squaring.busy()) target = squaring.step();
// Pure state; lives in the RT loop.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>

#include "core/clock.hpp"
#include "core/fault.hpp"

namespace gantry::cycle {

class Squaring {
 public:
  /// Nowhere faster than `speed`, and at rest at both ends.
  void start(double from, double to, double speed_per_s, Time period) noexcept {
    constexpr double kSteepest = 1.5;  // of 3u^2 - 2u^3, at its middle
    constexpr double kAtLeast_s = 0.02;
    from_ = from, to_ = to, step_ = 0, begun_ = true;
    const double duration_s = std::max(kSteepest * std::abs(to - from) / speed_per_s, kAtLeast_s);
    steps_ = static_cast<std::int64_t>(std::ceil(duration_s / seconds(period)));
  }
  /// It ends where it is, or before it began.
  void fail(Fault why) noexcept { steps_ = step_, begun_ = true, fault_ = why; }
  [[nodiscard]] bool begun() const noexcept { return begun_; }
  [[nodiscard]] bool busy() const noexcept { return step_ < steps_; }
  [[nodiscard]] Fault fault() const noexcept { return fault_; }
  double step() noexcept {
    const double u = static_cast<double>(++step_) / static_cast<double>(steps_);
    return from_ + (to_ - from_) * u * u * (3 - 2 * u);
  }

 private:
  double from_ = 0, to_ = 0;
  std::int64_t step_ = 0, steps_ = 0;
  bool begun_ = false;
  Fault fault_ = Fault::None;
};

}  // namespace gantry::cycle
