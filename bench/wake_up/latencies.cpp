#include "bench/wake_up/latencies.hpp"

namespace gantry::bench {

std::int64_t Latencies::quantile(double q) const {
  const auto wanted = static_cast<std::uint64_t>(q * static_cast<double>(count_));
  std::uint64_t seen = 0;
  for (const auto& [us, times] : counts_) {
    seen += times;
    if (seen > wanted) return us;
  }
  return max();
}

std::uint64_t Latencies::above(std::int64_t us) const {
  std::uint64_t n = 0;
  for (auto it = counts_.upper_bound(us); it != counts_.end(); ++it) n += it->second;
  return n;
}

std::uint64_t Latencies::whole(std::int64_t us) const {
  std::uint64_t n = 0;
  for (const auto& [latency, times] : counts_) n += static_cast<std::uint64_t>(latency / us) * times;
  return n;
}

}  // namespace gantry::bench
