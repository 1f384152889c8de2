// Axes that answer their target with unlike delays would bend the path: this delays each by what the slowest is slower,
// and the outputs by as much.
//   Compensation c(limits, delays_s);  c.reset(q);
//   Compensated out = c.step(setpoint, safe_mask);   // every tick
// Lives in the loop.
#pragma once
#include <array>
#include <cstdint>
#include <span>

#include "motion/types.hpp"

namespace gantry::motion {

struct Compensated {
  AxisVec q{}, v{};
  std::uint32_t outputs = 0;
  bool settled = false;  ///< the delayed setpoint has come to where the planned one stands
};

class Compensation {
 public:
  /// Ticks; the largest delay is 3 below that, and no machine file may ask for more (config/check_timing.cpp).
  static constexpr std::size_t kHistory = 64;

  /// response_delay_s[i]: how far axis i lags its command, >= 0; clamped to the history.
  Compensation(const Limits& limits, const AxisVec& response_delay_s) noexcept;

  /// Every axis stands at q since ever.
  void reset(const AxisVec& q, std::uint32_t outputs = 0) noexcept;

  /// The delayed targets are at q and go at v since ever. Returns where the planned setpoint is then.
  AxisVec go_on(const AxisVec& q, const AxisVec& v, std::uint32_t outputs) noexcept;

  /// q(t - (D - d_i)) of every axis, D = the largest delay in whole ticks; outputs of D ticks ago. Bits of safe_mask
  /// are cleared now, and in all that is still on its way: a stop's closing is never late.
  Compensated step(const Setpoint& planned, std::uint32_t safe_mask) noexcept;

  [[nodiscard]] int delay_ticks() const noexcept { return delay_ticks_; }
  /// None of these bits is on its way out, or set in what came last.
  [[nodiscard]] bool clear_of(std::uint32_t mask) const noexcept;

 private:
  struct Sample {
    AxisVec q{}, v{};
    std::uint32_t outputs = 0;
  };
  [[nodiscard]] const Sample& ago(int ticks) const noexcept;

  std::size_t axes_ = 0;
  double tick_s_ = 0.001;
  int delay_ticks_ = 0;
  std::array<int, kMaxAxes> whole_{};        ///< own delay of axis i: whole ticks ...
  std::array<double, kMaxAxes> fraction_{};  ///< ... and the part of a tick beyond, 0 <= f < 1
  std::array<Sample, kHistory> history_{};
  std::size_t newest_ = 0;
};

}  // namespace gantry::motion
