// Latency histogram with a relative resolution of 1/16 from 1 ns to 1000 s, fixed size, no allocation: add() in the
// loop, quantile() later.
#pragma once
#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>

namespace gantry::rt {

class Histogram {
 public:
  void add(std::int64_t ns) noexcept {
    const auto v = static_cast<std::uint64_t>(std::max<std::int64_t>(ns, 0));
    ++buckets_[bucket(v)];
    ++count_;
    max_ = std::max(max_, static_cast<std::int64_t>(v));
  }

  /// Upper edge in ns of the bucket that holds the q-quantile (0 <= q <= 1); never above the maximum; 0 when empty.
  [[nodiscard]] std::int64_t quantile(double q) const noexcept {
    const auto wanted = static_cast<std::uint64_t>(q * static_cast<double>(count_));
    std::uint64_t seen = 0;
    for (std::size_t i = 0; i < buckets_.size(); ++i) {
      seen += buckets_[i];
      if (seen > wanted) return std::min(upper_edge(i), max_);
    }
    return max_;
  }
  /// Calls f(upper edge in ns, count) for every bucket that holds something, ascending.
  template <class F>
  void for_each(F&& f) const {
    for (std::size_t i = 0; i < buckets_.size(); ++i)
      if (buckets_[i] != 0) f(std::min(upper_edge(i), max_), buckets_[i]);
  }
  [[nodiscard]] std::uint64_t count() const noexcept { return count_; }
  [[nodiscard]] std::int64_t max() const noexcept { return max_; }

 private:
  static constexpr std::size_t kSub = 16;  // buckets per octave
  static constexpr std::size_t kOctaves = 40;

  static std::size_t bucket(std::uint64_t v) noexcept {
    if (v < kSub) return static_cast<std::size_t>(v);
    const auto octave = static_cast<std::size_t>(std::bit_width(v) - 5);  // v in [16, 32) is octave 0
    const auto index = kSub + octave * kSub + static_cast<std::size_t>((v >> octave) - kSub);
    return std::min(index, kSub * kOctaves - 1);
  }
  static std::int64_t upper_edge(std::size_t i) noexcept {
    if (i < kSub) return static_cast<std::int64_t>(i);
    const std::size_t octave = (i - kSub) / kSub;
    return static_cast<std::int64_t>(((i - kSub) % kSub + kSub + 1) << octave) - 1;
  }

  std::array<std::uint64_t, kSub * kOctaves> buckets_{};
  std::uint64_t count_ = 0;
  std::int64_t max_ = 0;
};

}  // namespace gantry::rt
