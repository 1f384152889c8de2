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
  std::uint64_t slept = 0;   ///< periods that a late wake-up slept through: a stall of 5.3 ms sleeps through 5
  std::uint64_t missed = 0;  ///< the same, and cycles that woke in time and were not done in time
  std::uint64_t cycles = 0;
  std::string cost{};  ///< of a whole cycle, in words; empty when there is nothing to do in it
};

inline Figures figures(const Latencies& l) {
  Figures f{.max = static_cast<double>(l.max()),
            .stalls = l.above(1000),
            .slept = l.whole(1000),
            .missed = l.whole(1000),
            .cycles = l.count() + l.whole(1000)};
  for (std::size_t q = 0; q < kQuantiles.size(); ++q) f.at[q] = static_cast<double>(l.quantile(kQuantiles[q]));
  return f;
}

}  // namespace gantry::bench
