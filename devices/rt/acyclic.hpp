// Datagrams that ride along in the next cyclic frame: how the run thread reaches registers and mailboxes while the loop
// owns the bus, at no extra frame. One asker at a time; a few datagrams at once.
//   slot.post(datagrams);   ... slot.take(datagrams) -> Taken::Pending | Lost | Answered   (run thread)
// The loop's side is in Cyclic. No lock on either side.
#pragma once
#include <algorithm>
#include <array>
#include <atomic>
#include <cstdint>
#include <span>

#include "devices/rt/frame.hpp"

namespace gantry::devices {

/// One datagram that waits for its answer; `data` is replaced by what came back.
struct Datagram {
  wire::Command command = wire::Command::Nop;
  std::uint32_t address = 0;
  std::span<std::byte> data;
  std::uint16_t working_counter = 0;
};

class AcyclicSlot {
 public:
  enum class Taken : std::uint8_t { Pending, Lost, Answered };
  static constexpr std::size_t kMost = 8;  ///< datagrams at once
  /// Bytes of `n` datagrams' data that fit together beside nothing else.
  static constexpr std::size_t room(std::size_t n) noexcept {
    return wire::kMaxDatagramData - (n - 1) * (wire::kDatagramHeader + wire::kWorkingCounter);
  }

  // --- the asker -----------------------------------------------------------------------------------------------------
  /// False when they are too many or too long, or the ones before them have not been answered yet.
  bool post(std::span<const Datagram> datagrams) noexcept {
    if (datagrams.empty() || datagrams.size() > kMost || state_.load(std::memory_order_acquire) != State::Free)
      return false;
    std::size_t bytes = 0;
    for (const Datagram& d : datagrams) bytes += d.data.size();
    if (bytes > room(datagrams.size())) return false;
    bytes = 0;
    for (std::size_t i = 0; i < datagrams.size(); ++i) {
      const Datagram& d = datagrams[i];
      riders_[i] = {d.command, d.address, static_cast<std::uint16_t>(bytes), static_cast<std::uint16_t>(d.data.size())};
      std::copy(d.data.begin(), d.data.end(), data_.begin() + static_cast<std::ptrdiff_t>(bytes));
      bytes += d.data.size();
    }
    count_ = datagrams.size();
    state_.store(State::Posted, std::memory_order_release);
    return true;
  }
  /// Answered: data and working counters of `datagrams` are the replies'. Lost: the frame did not come back. Both free
  /// the slot. With an empty span, answers to a request that was given up are thrown away.
  Taken take(std::span<Datagram> datagrams) noexcept {
    const State now = state_.load(std::memory_order_acquire);
    if (now != State::Answered && now != State::Lost) return Taken::Pending;
    if (now == State::Answered)
      for (std::size_t i = 0; i < std::min(count_, datagrams.size()); ++i) {
        const Rider& r = riders_[i];
        Datagram& d = datagrams[i];
        std::copy_n(data_.begin() + r.at, std::min<std::size_t>(r.length, d.data.size()), d.data.begin());
        d.working_counter = r.working_counter;
      }
    state_.store(State::Free, std::memory_order_release);
    return now == State::Answered ? Taken::Answered : Taken::Lost;
  }
  /// Takes back datagrams that the loop has not picked up (the loop stands). False when they are in a frame already.
  bool withdraw() noexcept {
    State posted = State::Posted;
    return state_.compare_exchange_strong(posted, State::Free);
  }

  // --- the loop ------------------------------------------------------------------------------------------------------
  [[nodiscard]] bool waiting() const noexcept { return state_.load(std::memory_order_acquire) == State::Posted; }
  /// Appends what waits, if all of it fits.
  bool ride(Frame& frame) noexcept {
    State posted = State::Posted;
    if (!waiting() || !state_.compare_exchange_strong(posted, State::Riding)) return false;
    std::size_t bytes = 0;
    for (std::size_t i = 0; i < count_; ++i)
      bytes += riders_[i].length + (i > 0 ? wire::kDatagramHeader + wire::kWorkingCounter : 0);
    if (bytes > frame.room() || frame.slots().size() + count_ > kMaxDatagrams) {
      state_.store(State::Posted, std::memory_order_release);
      return false;
    }
    for (std::size_t i = 0; i < count_; ++i) {
      Rider& r = riders_[i];
      r.slot = frame.add(r.command, r.address, std::span<const std::byte>(data_).subspan(r.at, r.length));
    }
    return true;
  }
  void answer(const Reply& reply) noexcept {
    for (std::size_t i = 0; i < count_; ++i) {
      Rider& r = riders_[i];
      const auto data = reply.data(r.slot);
      std::copy(data.begin(), data.end(), data_.begin() + r.at);
      r.working_counter = reply.working_counter(r.slot);
    }
    state_.store(State::Answered, std::memory_order_release);
  }
  void lose() noexcept { state_.store(State::Lost, std::memory_order_release); }

 private:
  enum class State : std::uint8_t { Free, Posted, Riding, Answered, Lost };
  struct Rider {
    wire::Command command = wire::Command::Nop;
    std::uint32_t address = 0;
    std::uint16_t at = 0, length = 0;  ///< in data_
    SlotIndex slot = kNoSlot;
    std::uint16_t working_counter = 0;
  };
  std::atomic<State> state_{State::Free};
  std::size_t count_ = 0;
  std::array<Rider, kMost> riders_{};
  std::array<std::byte, wire::kMaxDatagramData> data_{};
};

}  // namespace gantry::devices
