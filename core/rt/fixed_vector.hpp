// A vector with a fixed upper size that never allocates; trivially copyable when T is, so that it may cross the RT
// boundary.
#pragma once
#include <array>
#include <cassert>
#include <cstddef>
#include <cstdint>

namespace gantry::rt {

template <class T, std::size_t N>
class FixedVector {
 public:
  /// False when full: the value was not taken.
  constexpr bool push_back(const T& value) noexcept {
    if (size_ >= N) return false;
    items_[size_++] = value;
    return true;
  }
  constexpr void clear() noexcept { size_ = 0; }
  [[nodiscard]] constexpr std::size_t size() const noexcept { return size_; }
  [[nodiscard]] constexpr bool empty() const noexcept { return size_ == 0; }
  static constexpr std::size_t capacity() noexcept { return N; }

  constexpr T& operator[](std::size_t i) noexcept { return assert(i < size_), items_[i]; }
  constexpr const T& operator[](std::size_t i) const noexcept { return assert(i < size_), items_[i]; }
  constexpr T& back() noexcept { return (*this)[size_ - 1]; }
  constexpr const T& back() const noexcept { return (*this)[size_ - 1]; }
  constexpr T* begin() noexcept { return items_.data(); }
  constexpr T* end() noexcept { return items_.data() + size_; }
  constexpr const T* begin() const noexcept { return items_.data(); }
  constexpr const T* end() const noexcept { return items_.data() + size_; }

 private:
  std::array<T, N> items_{};
  std::uint32_t size_ = 0;
};

}  // namespace gantry::rt
