// The lowest seam of EtherCAT: raw Ethernet frames out and in, on one or two ports. The network card and the virtual
// segment stand behind it; nothing above it knows which. Non-blocking send; receive waits until a deadline at most.
// Several frames may be in flight.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "core/clock.hpp"
#include "devices/frame_bytes.hpp"

namespace gantry::devices {

enum class PortIndex : std::uint8_t { Primary = 0, Secondary = 1 };

struct Received {
  std::size_t size = 0;  ///< bytes written; 0: nothing came until the deadline
  PortIndex port = PortIndex::Primary;
  Time rx_time{};  ///< when it arrived, on the machine's clock
};

/// An Ethernet address as it stands in a frame.
using MacAddress = std::array<std::byte, 6>;
/// Source address of a master's frames but for its last byte, which is the port. Bit 1 of the first byte is clear:
/// stations set it.
using SourceAddress = std::array<std::byte, 5>;
inline constexpr SourceAddress kUsualSource{std::byte{0x10}, std::byte{0x67}, std::byte{0x61}, std::byte{0x6E},
                                            std::byte{0x74}};

class FramePort {
 public:
  virtual ~FramePort() = default;
  /// Whole Ethernet frame from the destination address on, without FCS. False when it could not be sent (link down,
  /// queue full).
  virtual bool send(PortIndex port, std::span<const std::byte> frame) noexcept = 0;
  /// The next frame that has arrived, waiting until `deadline` at most (a past deadline only looks). A frame whose FCS
  /// was wrong never shows.
  virtual Received receive(std::span<std::byte> buffer, Time deadline) noexcept = 0;
  /// A receive() that waits until exactly `deadline` is to come: what its wait needs is made ready now, while no answer
  /// is waited for. Only saves time, and only for the deadline of the last call.
  virtual void arm(Time /*deadline*/) noexcept {}
  [[nodiscard]] virtual bool link_up(PortIndex port) const noexcept = 0;
  /// By which this master's frames are told from those of another one on the same line.
  [[nodiscard]] virtual SourceAddress source() const noexcept { return kUsualSource; }
  /// A socket on which one `::send` puts a whole frame on the wire, from any thread and from a signal handler: by it
  /// a program that hangs or dies sends its last frame. -1: there is none (a virtual segment belongs to one thread).
  [[nodiscard]] virtual int descriptor() const noexcept { return -1; }
};

}  // namespace gantry::devices
