// Several axes between position limits: a motion drawn at random within the bounds of every axis is a witness that the
// case can be solved, in its duration.
#pragma once
#include <cstdint>

namespace gantry::bench {

/// Prints what was found; true when every case was solved, no later than its witness allows, and right.
bool between_limits(std::uint64_t cases, unsigned seed);

}  // namespace gantry::bench
