// One datagram out and its answer back, blocking: what bring-up is made of. While the loop owns the port, the datagram
// rides along in its frames instead.
//   Link link(port, clock);
//   auto states = link.read<std::uint16_t>(0x1001, wire::reg::kAlStatus);
// Every call ends within attempts x kReplyTimeout.
#pragma once
#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>

#include "core/clock.hpp"
#include "core/error.hpp"
#include "devices/frame_port.hpp"
#include "devices/rt/acyclic.hpp"
#include "devices/rt/cyclic_counts.hpp"
#include "devices/rt/frame.hpp"
#include "devices/rt/sender_watch.hpp"

namespace gantry::devices {

class SideBySide;

class Link {
 public:
  static constexpr Time kReplyTimeout = milliseconds(20);  ///< of one frame; also a busy host answers within it
  static constexpr Time kRideTimeout = milliseconds(200);  ///< until the loop has taken a datagram along and back
  static constexpr int kAttempts = 3;

  Link(FramePort& port, Clock& clock) noexcept : port_(port), clock_(clock) { frame_.set_source(port.source()); }

  /// From now on the loop exchanges, and datagrams ride in `slot`; nullptr: the port is ours again.
  void ride_in(AcyclicSlot* slot) noexcept { slot_ = slot; }
  /// How time passes while datagrams ride: by sleeping, or in virtual time by letting the loop step.
  void step_by(std::function<void()> step) { step_ = std::move(step); }

  /// Whether whoever waits for a station is to stop waiting; asked in every wait that a station can make long.
  void heed(std::function<bool()> ends) { ends_ = std::move(ends); }
  /// Fault::Interrupted where it is.
  [[nodiscard]] Result<void> goes_on() const;

  /// Sends the data and replaces them by what came back; the working counter. Fault::BusDown when no attempt was
  /// answered.
  Result<std::uint16_t> transact(wire::Command command, std::uint32_t address, std::span<std::byte> data,
                                 int attempts = kAttempts);

  /// Many at once, in as few frames as hold them. The caller judges the working counters. Fault::BusDown.
  Result<void> transact(std::span<Datagram> batch);

  /// Registers of one station by its configured address. Fault::StationMissing when it does not take part.
  Result<void> read(std::uint16_t station, std::uint16_t reg, std::span<std::byte> data);
  Result<void> write(std::uint16_t station, std::uint16_t reg, std::span<const std::byte> data);

  template <class T>
  Result<T> read(std::uint16_t station, std::uint16_t reg) {
    std::array<std::byte, sizeof(T)> raw{};
    if (auto ok = read(station, reg, raw); !ok) return tl::unexpected(ok.error());
    return wire::get_le<T>(raw, 0);
  }
  template <class T>
  Result<void> write(std::uint16_t station, std::uint16_t reg, std::type_identity_t<T> value) {
    std::array<std::byte, sizeof(T)> raw{};
    wire::put_le<T>(raw, 0, value);
    return write(station, reg, std::span<const std::byte>(raw));
  }
  /// Writes a register of every station; how many took part.
  Result<std::uint16_t> write_all(std::uint16_t reg, std::span<const std::byte> data);

  /// What became of the frames that it has sent by itself, each counted as what it was.
  [[nodiscard]] const CyclicCounts& counts() const noexcept { return counts_; }
  /// Another master whose frames came in meanwhile.
  [[nodiscard]] const std::optional<OtherMaster>& other_master() const noexcept { return senders_.other(); }

  [[nodiscard]] FramePort& port() noexcept { return port_; }
  [[nodiscard]] Clock& clock() noexcept { return clock_; }
  void pause(Time duration);

  // --- For SideBySide ---
  /// Until further notice who calls is one of several: it waits while the others go on. nullptr: alone again.
  void beside(SideBySide* others) noexcept { beside_ = others; }
  /// How many of these go out at once: in one frame beside the idle datagram, or together in the slot.
  [[nodiscard]] std::size_t fitting(std::span<const Datagram> batch) const;
  /// Sends these in one frame; false: it did not come back, and the data are what they have become.
  [[nodiscard]] bool attempt_now(std::span<Datagram> at_once);

 private:
  [[nodiscard]] bool attempt(std::span<Datagram> of_one_frame);
  void count(Match match, std::span<const std::byte> received);
  [[nodiscard]] bool exchange(std::span<Datagram> at_once, int attempts);
  [[nodiscard]] Error silent() const;
  [[nodiscard]] bool attempt_riding(std::span<Datagram> at_once);

  FramePort& port_;
  Clock& clock_;
  AcyclicSlot* slot_ = nullptr;
  SideBySide* beside_ = nullptr;
  std::function<void()> step_;
  std::function<bool()> ends_;
  std::uint32_t sequence_ = 0;
  Frame frame_;
  std::array<bool, 256> answered_{};  ///< by the low byte of the sequence: of the last frames
  CyclicCounts counts_;
  SenderWatch senders_;
};

}  // namespace gantry::devices
