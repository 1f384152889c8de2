// A vector with a fixed upper size that never allocates; trivially copyable, so that it may cross the RT boundary.
// Places that were never taken hold no values: making an empty one costs nothing, however large it may grow.
#pragma once
#include <cassert>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <new>
#include <type_traits>
#include <utility>

namespace gantry::rt {

template <class T, std::size_t N>
class FixedVector {
  static_assert(std::is_trivially_copyable_v<T>);

 public:
  FixedVector() noexcept {}  // user-provided, so that {} does not fill the places with zeros either
  /// False when full: the value was not taken.
  bool push_back(const T& value) noexcept {
    if (size_ >= N) return false;
    std::construct_at(reinterpret_cast<T*>(places_) + size_++, value);
    return true;
  }
  /// Made in its place; there is room for it.
  template <class... A>
  T& emplace_back(A&&... arguments) noexcept {
    assert(size_ < N);
    return *std::construct_at(reinterpret_cast<T*>(places_) + size_++, std::forward<A>(arguments)...);
  }
  void clear() noexcept { size_ = 0; }
  [[nodiscard]] std::size_t size() const noexcept { return size_; }
  [[nodiscard]] bool empty() const noexcept { return size_ == 0; }
  static constexpr std::size_t capacity() noexcept { return N; }

  T& operator[](std::size_t i) noexcept { return assert(i < size_), begin()[i]; }
  const T& operator[](std::size_t i) const noexcept { return assert(i < size_), begin()[i]; }
  T& back() noexcept { return (*this)[size_ - 1]; }
  const T& back() const noexcept { return (*this)[size_ - 1]; }
  T* begin() noexcept { return std::launder(reinterpret_cast<T*>(places_)); }
  T* end() noexcept { return begin() + size_; }
  const T* begin() const noexcept { return std::launder(reinterpret_cast<const T*>(places_)); }
  const T* end() const noexcept { return begin() + size_; }

 private:
  alignas(T) std::byte places_[N * sizeof(T)];
  std::uint32_t size_ = 0;
};

}  // namespace gantry::rt
