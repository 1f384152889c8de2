// Wake-up latencies of one run, in whole microseconds as cyclictest counts them.
//   Latencies l;  l.add(17);  l.quantile(0.99)  ->  µs at or above 99 % of all
#pragma once
#include <array>
#include <cstdint>
#include <map>

namespace gantry::bench {

class Latencies {
 public:
  void add(std::int64_t us, std::uint64_t times = 1) {
    counts_[us] += times;
    count_ += times;
  }
  /// Smallest latency that q of all do not exceed; 0 when empty.
  [[nodiscard]] std::int64_t quantile(double q) const;
  [[nodiscard]] std::int64_t max() const { return counts_.empty() ? 0 : counts_.rbegin()->first; }
  [[nodiscard]] std::uint64_t count() const { return count_; }
  /// How many exceed `us`.
  [[nodiscard]] std::uint64_t above(std::int64_t us) const;
  /// Whole periods of `us` in all of them together: what a loop of that period has slept through.
  [[nodiscard]] std::uint64_t whole(std::int64_t us) const;

 private:
  std::map<std::int64_t, std::uint64_t> counts_;
  std::uint64_t count_ = 0;
};

inline constexpr std::array kQuantiles{0.5, 0.99, 0.999};

}  // namespace gantry::bench
