// What one run came to, of whoever ran: wake-up latency in us at kQuantiles, the longest, and the deadlines it missed.
#pragma once
#include <array>
#include <cstdint>
#include <string>

#include "bench/wake_up/latencies.hpp"

namespace gantry::bench {

struct Figures {
  std::array<double, kQuantiles.size()> at{};
  double max = 0;
  std::uint64_t stalls = 0;  ///< wake-ups more than a period late
  std::uint64_t missed = 0;  ///< periods in which a cycle was due and was not done: a stall of 5.3 ms misses 5
  std::uint64_t cycles = 0;
  std::string cost{};  ///< of a whole cycle, in words; empty when there is nothing to do in it
};

inline Figures figures(const Latencies& l) {
  Figures f{.max = static_cast<double>(l.max()),
            .stalls = l.above(1000),
            .missed = l.whole(1000),
            .cycles = l.count() + l.whole(1000)};
  for (std::size_t q = 0; q < kQuantiles.size(); ++q) f.at[q] = static_cast<double>(l.quantile(kQuantiles[q]));
  return f;
}

}  // namespace gantry::bench
