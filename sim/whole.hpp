// The whole number nearest to a value, halves away from zero, without a call: counters and clocks of the virtual bus
// are read many times a cycle.
#pragma once
#include <cstdint>

namespace gantry::sim {

/// |x| < 2^62; from 2^52 on a double is whole already.
constexpr std::int64_t whole(double x) noexcept { return static_cast<std::int64_t>(x < 0 ? x - 0.5 : x + 0.5); }

}  // namespace gantry::sim
