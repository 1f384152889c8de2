// One writer, any number of readers that the writer does not know: it never waits and never fails, a reader that is too
// slow loses values and is told how many. Lies in shared memory; readers may have it read-only, come at any time and
// die at any instruction.
//   ring.push(v);                         // the writer
//   RingCursor c = ring.oldest();         // a reader
//   while (ring.next(c, v)) ...           // c.position, c.lost
#pragma once
#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>

#include "core/rt/latest.hpp"

namespace gantry::monitor {

struct RingCursor {
  std::uint64_t position = 0;  ///< number of the next value to read
  std::uint64_t lost = 0;
};

template <class T, std::size_t N>
class LossyRing {
  struct Numbered {
    std::uint64_t number;
    T value;
  };

 public:
  void push(const T& value) noexcept {
    const std::uint64_t n = count_.load(std::memory_order_relaxed);
    slots_[n % N].store({n, value});
    count_.store(n + 1, std::memory_order_release);
  }

  /// How many were ever pushed.
  [[nodiscard]] std::uint64_t count() const noexcept { return count_.load(std::memory_order_acquire); }
  /// Where the values begin that can still be read.
  [[nodiscard]] RingCursor oldest() const noexcept {
    const std::uint64_t n = count();
    return {n > N ? n - N : 0, 0};
  }
  /// False when there is nothing newer. What was overwritten before it could be read is counted as lost.
  bool next(RingCursor& cursor, T& value) const noexcept {
    for (;;) {
      const std::uint64_t n = count();
      if (cursor.position >= n) return false;
      if (n - cursor.position > N) {
        cursor.lost += n - N - cursor.position;
        cursor.position = n - N;
      }
      Numbered read;
      const bool intact = slots_[cursor.position % N].load(read) && read.number == cursor.position;
      ++cursor.position;
      if (intact) {
        value = read.value;
        return true;
      }
      ++cursor.lost;  // the writer was faster, or died in the middle of it
    }
  }
  /// The newest value, skipping all others.
  bool newest(T& value) const noexcept {
    for (int tries = 0; tries < 8; ++tries) {
      const std::uint64_t n = count();
      if (n == 0) return false;
      Numbered read;
      if (slots_[(n - 1) % N].load(read) && read.number == n - 1) {
        value = read.value;
        return true;
      }
    }
    return false;
  }

 private:
  std::atomic<std::uint64_t> count_{0};
  std::array<rt::Latest<Numbered>, N> slots_{};
};

}  // namespace gantry::monitor
