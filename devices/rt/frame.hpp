// One EtherCAT frame: built in a fixed buffer, and matched against what comes back. The parser believes nothing: any
// bytes give an answer, and a reply is taken only when it has the shape of the frame that was sent.
//   Frame f;
//   f.start(sequence);
//   const auto lrw = f.add(wire::Command::Lrw, 0, length);      // f.data(lrw) to fill in
//   port.send(PortIndex::Primary, f.bytes());
//   Reply r;  if (match(f, received, r) == Match::Ours) use(r.data(lrw), r.working_counter(lrw));
// Lives in the RT loop.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "core/rt/fixed_vector.hpp"
#include "devices/frame_port.hpp"
#include "devices/wire/ethercat.hpp"

namespace gantry::devices {

/// Where a datagram lies in its frame.
struct Slot {
  std::uint16_t header = 0;  ///< offset of the datagram's header in the frame
  std::uint16_t length = 0;  ///< of its data
  [[nodiscard]] constexpr std::size_t data() const noexcept { return header + wire::kDatagramHeader; }
  [[nodiscard]] constexpr std::size_t end() const noexcept { return data() + length + wire::kWorkingCounter; }
};
using SlotIndex = std::size_t;
inline constexpr SlotIndex kNoSlot = static_cast<SlotIndex>(-1);
inline constexpr std::size_t kMaxDatagrams = 15;  ///< as the ESCs of the first generation take at most

class Frame {
 public:
  /// Empties the frame. Frames differ by `sequence`: the index fields of the first two datagrams are its low bytes,
  /// so that a reply that is 256 frames late is not mistaken for the present one; those of the next ones are scrambled
  /// of all of it, so that a changed bit does not make one frame look like another.
  void start(std::uint32_t sequence, PortIndex port = PortIndex::Primary) noexcept;
  /// Of the frames that are started from now on.
  void set_source(const SourceAddress& source) noexcept { source_ = source; }

  /// Appends a datagram with zeroed data; kNoSlot when the frame is full. `address`: see wire::DatagramHeader.
  SlotIndex add(wire::Command command, std::uint32_t address, std::size_t length) noexcept;
  /// Appends a datagram with data.
  SlotIndex add(wire::Command command, std::uint32_t address, std::span<const std::byte> data) noexcept;

  /// Appends an idle datagram that carries the whole sequence where no station and no changed header reaches it; for
  /// frames with few datagrams.
  SlotIndex add_sequence() noexcept;

  [[nodiscard]] std::span<std::byte> data(SlotIndex slot) noexcept;
  /// The whole Ethernet frame, padded to the least size.
  [[nodiscard]] std::span<const std::byte> bytes() const noexcept;
  [[nodiscard]] std::span<const Slot> slots() const noexcept { return {slots_.begin(), slots_.size()}; }
  /// Room for the data of one more datagram.
  [[nodiscard]] std::size_t room() const noexcept;

 private:
  std::array<std::byte, kMaxFrameBytes> buffer_{};
  SourceAddress source_ = kUsualSource;
  std::size_t size_ = wire::kFrameHeader;
  std::uint32_t sequence_ = 0;
  std::uint64_t scrambled_ = 0;
  rt::FixedVector<Slot, kMaxDatagrams> slots_;
};

enum class Match : std::uint8_t {
  Ours,         ///< the reply to this frame
  Unprocessed,  ///< our frame, but no station has seen it (looped back)
  Late,         ///< of this master, but of another frame: an earlier one, or another one of this cycle
  Foreign,      ///< not EtherCAT, or of another master
  Malformed,    ///< lengths that do not fit together, or a header with changed bits, also that of Ethernet
};

/// The reply to a frame; points into the received bytes.
class Reply {
 public:
  [[nodiscard]] std::span<const std::byte> data(SlotIndex slot) const noexcept;
  [[nodiscard]] std::uint16_t working_counter(SlotIndex slot) const noexcept;

 private:
  friend Match match(const Frame& sent, std::span<const std::byte> received, Reply& reply) noexcept;
  std::span<const std::byte> bytes_;
  std::span<const Slot> slots_;
};

/// Who has sent an EtherCAT frame, as its source address came in (stations set bit 1 of the first byte). Nothing where
/// it is no EtherCAT frame.
std::optional<MacAddress> sender_of(std::span<const std::byte> received) noexcept;

/// Judges what came in against what was sent. `reply` is filled in when the answer is Match::Ours or Unprocessed.
Match match(const Frame& sent, std::span<const std::byte> received, Reply& reply) noexcept;

}  // namespace gantry::devices
