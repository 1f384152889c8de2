// Single-producer single-consumer ring of trivially copyable values: by it state crosses the RT boundary. No
// allocation, no lock; each side touches only its own index and keeps a copy of the other's, so that the cache line
// moves rarely.
//   Ring<Snapshot, 4096> r;   r.push(s) -> false when full;   r.pop(s) -> false when empty
#pragma once
#include <array>
#include <atomic>
#include <cstddef>
#include <type_traits>

namespace gantry::rt {

template <class T, std::size_t N>
class Ring {
  static_assert(std::is_trivially_copyable_v<T>, "only plain values cross the RT boundary");
  static_assert((N & (N - 1)) == 0, "size is a power of two");

 public:
  /// Producer. False when full: the value was not taken.
  bool push(const T& value) noexcept {
    const std::size_t head = head_.load(std::memory_order_relaxed);
    if (head - tail_seen_ >= N) {
      tail_seen_ = tail_.load(std::memory_order_acquire);
      if (head - tail_seen_ >= N) return false;
    }
    items_[head & (N - 1)] = value;
    head_.store(head + 1, std::memory_order_release);
    return true;
  }

  /// Consumer. False when empty.
  bool pop(T& value) noexcept {
    const T* p = peek(0);
    if (p == nullptr) return false;
    value = *p;
    tail_.store(tail_.load(std::memory_order_relaxed) + 1, std::memory_order_release);
    return true;
  }

  /// Consumer. The i-th waiting value without taking it; nullptr when there are fewer.
  const T* peek(std::size_t i) noexcept {
    const std::size_t tail = tail_.load(std::memory_order_relaxed);
    if (head_seen_ - tail <= i) {
      head_seen_ = head_.load(std::memory_order_acquire);
      if (head_seen_ - tail <= i) return nullptr;
    }
    return &items_[(tail + i) & (N - 1)];
  }

  /// Either side; a moment later it may be otherwise.
  [[nodiscard]] std::size_t size() const noexcept {
    return head_.load(std::memory_order_acquire) - tail_.load(std::memory_order_acquire);
  }
  static constexpr std::size_t capacity() noexcept { return N; }

 private:
  alignas(64) std::atomic<std::size_t> head_{0};
  std::size_t tail_seen_ = 0;
  alignas(64) std::atomic<std::size_t> tail_{0};
  std::size_t head_seen_ = 0;
  alignas(64) std::array<T, N> items_{};
};

}  // namespace gantry::rt
