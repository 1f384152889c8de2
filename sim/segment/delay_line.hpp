// Frames on their way back to the master, each with the instant at which it arrives, and what comes in behind it; by
// arrival, not by order of entry.
//   line.put(frame, arrives, fate);          // false: full, the frame is lost
//   if (line.next() <= now) { auto frame = line.front(); ...; line.pop(); }
#pragma once
#include <array>
#include <cstddef>
#include <cstring>
#include <span>

#include "core/clock.hpp"
#include "devices/frame_port.hpp"
#include "sim/segment/foreign_frame.hpp"
#include "sim/segment/frame_faults.hpp"

namespace gantry::sim {

class DelayLine {
 public:
  static constexpr std::size_t kFrames = 64;

  DelayLine() noexcept {
    for (std::size_t i = 0; i < kFrames; ++i) order_[i] = i;
  }

  bool put(std::span<const std::byte> frame, Time arrives, const FrameFate& fate) noexcept {
    const Time at = arrives + fate.delay;
    // What was held back comes right behind this one.
    for (std::size_t i = 0; i < count_; ++i)
      if (slots_[order_[i]].arrives == kNever) slots_[order_[i]].arrives = at + Time{1};
    bool kept = insert(frame, fate.held ? kNever : at);
    if (fate.duplicate) kept = insert(frame, fate.held ? kNever : at + Time{1}) && kept;
    if (fate.foreign) kept = insert(foreign_frame(), at + Time{1}) && kept;
    return kept;
  }
  [[nodiscard]] bool empty() const noexcept { return count_ == 0; }
  /// Arrival of the first frame; kNever: none is to come.
  [[nodiscard]] Time next() const noexcept { return count_ > 0 ? slots_[order_[0]].arrives : kNever; }
  [[nodiscard]] std::span<const std::byte> front() const noexcept {
    const Slot& s = slots_[order_[0]];
    return {s.bytes.data(), s.size};
  }
  void pop() noexcept {
    const std::size_t free = order_[0];
    for (std::size_t i = 1; i < count_; ++i) order_[i - 1] = order_[i];
    order_[--count_] = free;
  }

 private:
  struct Slot {
    Time arrives{};
    std::size_t size = 0;
    std::array<std::byte, devices::kMaxFrameBytes> bytes;
  };

  bool insert(std::span<const std::byte> frame, Time arrives) noexcept {
    if (count_ == kFrames || frame.size() > devices::kMaxFrameBytes) return false;
    const std::size_t slot = order_[count_];
    Slot& s = slots_[slot];
    s.arrives = arrives, s.size = frame.size();
    std::memcpy(s.bytes.data(), frame.data(), frame.size());
    std::size_t i = count_++;
    for (; i > 0 && slots_[order_[i - 1]].arrives > arrives; --i) order_[i] = order_[i - 1];
    order_[i] = slot;
    return true;
  }

  std::array<Slot, kFrames> slots_;
  std::array<std::size_t, kFrames> order_{};  ///< slots by arrival, then the free ones
  std::size_t count_ = 0;
};

}  // namespace gantry::sim
