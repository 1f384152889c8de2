// One datagram that rides along in the next cyclic frame: how the run thread reaches a register or a mailbox while the
// loop owns the bus, at no extra frame. One asker at a time.
//   slot.post(command, address, data);   ... slot.take(data, wkc) -> Taken::Pending | Lost | Answered   (run thread)
// The loop's side is in Cyclic. No lock on either side.
#pragma once
#include <algorithm>
#include <array>
#include <atomic>
#include <cstdint>
#include <span>

#include "devices/rt/frame.hpp"

namespace gantry::devices {

class AcyclicSlot {
 public:
  enum class Taken : std::uint8_t { Pending, Lost, Answered };

  // --- the asker -----------------------------------------------------------------------------------------------------
  /// False when the data are too long, or the datagram before is still under way.
  bool post(wire::Command command, std::uint32_t address, std::span<const std::byte> data) noexcept {
    if (data.size() > data_.size() || state_.load(std::memory_order_acquire) != State::Free) return false;
    command_ = command;
    address_ = address;
    length_ = data.size();
    std::copy(data.begin(), data.end(), data_.begin());
    state_.store(State::Posted, std::memory_order_release);
    return true;
  }
  /// Answered: `data` and `working_counter` are the reply's. Lost: the frame did not come back. Both free the slot.
  Taken take(std::span<std::byte> data, std::uint16_t& working_counter) noexcept {
    const State now = state_.load(std::memory_order_acquire);
    if (now != State::Answered && now != State::Lost) return Taken::Pending;
    if (now == State::Answered) std::copy_n(data_.begin(), std::min(length_, data.size()), data.begin());
    working_counter = working_counter_;
    state_.store(State::Free, std::memory_order_release);
    return now == State::Answered ? Taken::Answered : Taken::Lost;
  }
  /// Gives up on a datagram that the loop has not picked up (the loop stands). False when it is under way.
  bool withdraw() noexcept {
    State posted = State::Posted;
    return state_.compare_exchange_strong(posted, State::Free);
  }

  // --- the loop ------------------------------------------------------------------------------------------------------
  /// Appends the waiting datagram, if there is one and it fits.
  SlotIndex ride(Frame& frame) noexcept {
    State posted = State::Posted;
    if (state_.load(std::memory_order_acquire) != State::Posted || length_ > frame.room()) return kNoSlot;
    if (!state_.compare_exchange_strong(posted, State::Riding)) return kNoSlot;
    return frame.add(command_, address_, std::span<const std::byte>(data_).first(length_));
  }
  void answer(const Reply& reply, SlotIndex slot) noexcept {
    const auto data = reply.data(slot);
    std::copy(data.begin(), data.end(), data_.begin());
    working_counter_ = reply.working_counter(slot);
    state_.store(State::Answered, std::memory_order_release);
  }
  void lose() noexcept { state_.store(State::Lost, std::memory_order_release); }

 private:
  enum class State : std::uint8_t { Free, Posted, Riding, Answered, Lost };
  std::atomic<State> state_{State::Free};
  wire::Command command_ = wire::Command::Nop;
  std::uint16_t working_counter_ = 0;
  std::uint32_t address_ = 0;
  std::size_t length_ = 0;
  std::array<std::byte, wire::kMaxDatagramData> data_{};
};

}  // namespace gantry::devices
