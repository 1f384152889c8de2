// Seeded randomness of the world: the same numbers on every host and in every process, from nothing but the seed
// (splitmix64, Steele, Lea, Flood 2014; std:: distributions differ between libraries).
#pragma once
#include <cstdint>

namespace gantry::sim {

constexpr std::uint64_t mix(std::uint64_t x) {
  x += 0x9E3779B97F4A7C15ULL;
  x = (x ^ (x >> 30)) * 0xBF58476D1CE4E5B9ULL;
  x = (x ^ (x >> 27)) * 0x94D049BB133111EBULL;
  return x ^ (x >> 31);
}
constexpr std::uint64_t mix(std::uint64_t a, std::uint64_t b) { return mix(mix(a) ^ b); }

class Random {
 public:
  explicit constexpr Random(std::uint64_t seed) : state_(seed) {}
  constexpr std::uint64_t next() { return mix(state_++); }
  /// Uniform in [0, 1).
  constexpr double unit() { return static_cast<double>(next() >> 11) * 0x1.0p-53; }
  /// Uniform in [-spread, spread).
  constexpr double symmetric(double spread) { return (2 * unit() - 1) * spread; }

 private:
  std::uint64_t state_;
};

}  // namespace gantry::sim
