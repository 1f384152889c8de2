// The one place where mm or rad become counts and back. A drive counts in 32 bits and wraps; inside, counts are 64 bits
// and never wrap.
//   AxisScale scale(2000.0, invert);            // counts per mm
//   scale.set_reference(at, position);          // after homing: the counts `at` are this coordinate
//   Counts c = scale.to_counts(12.5);           // nearest count
// May be used in the RT loop.
#pragma once
#include <cmath>
#include <cstdint>

#include "core/id.hpp"

namespace gantry::devices {

class AxisScale {
 public:
  AxisScale() = default;
  /// counts_per_unit > 0: counts per mm or rad; `invert`: counts rise while the coordinate falls.
  AxisScale(double counts_per_unit, bool invert) noexcept
      : counts_per_unit_(invert ? -counts_per_unit : counts_per_unit) {}

  [[nodiscard]] Counts to_counts(double position) const noexcept {
    return {zero_ + std::llround(position * counts_per_unit_)};
  }
  [[nodiscard]] double to_position(Counts counts) const noexcept {
    return static_cast<double>(counts.value - zero_) / counts_per_unit_;
  }
  /// Counts of a difference: a distance, a speed per second, a window.
  [[nodiscard]] double to_counts_delta(double distance) const noexcept { return distance * counts_per_unit_; }

  /// From now on the counts `at` are the coordinate `position`. The offset is a whole number of counts, so that a
  /// reference does not depend on where the axis stood.
  void set_reference(Counts at, double position) noexcept {
    zero_ = at.value - std::llround(position * counts_per_unit_);
  }
  [[nodiscard]] Counts zero() const noexcept { return {zero_}; }

 private:
  double counts_per_unit_ = 1;
  std::int64_t zero_ = 0;  ///< counts at coordinate 0
};

/// Makes the wrapping 32-bit counts of 6064h continuous (R46): the nearest 64-bit value that has these low 32 bits.
class Unwrap {
 public:
  Counts step(std::int32_t raw) noexcept {
    if (!known_) return restart(raw);
    last_ = near(last_, raw).value;
    return {last_};
  }
  /// Forgets the past: the counter was set anew (homing, drive reset).
  Counts restart(std::int32_t raw) noexcept {
    known_ = true;
    last_ = raw;
    return {last_};
  }
  /// The value nearest to `reference` whose low 32 bits are `raw`.
  [[nodiscard]] static Counts near(std::int64_t reference, std::int32_t raw) noexcept {
    const auto step =
        static_cast<std::int32_t>(static_cast<std::uint32_t>(raw) - static_cast<std::uint32_t>(reference));
    return {reference + step};
  }

 private:
  std::int64_t last_ = 0;
  bool known_ = false;
};

/// What stands in 607Ah: the low 32 bits.
constexpr std::int32_t wrap(Counts c) noexcept {
  return static_cast<std::int32_t>(static_cast<std::uint64_t>(c.value));
}

}  // namespace gantry::devices
