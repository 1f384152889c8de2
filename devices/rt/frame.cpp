#include "devices/rt/frame.hpp"

#include <algorithm>

namespace gantry::devices {
namespace {

using namespace wire;

constexpr std::size_t kSourceOffset = 6, kEtherTypeOffset = 12;

/// Spreads every bit of the sequence over all of the word (the finaliser of splitmix64, Steele et al. 2014).
constexpr std::uint64_t scramble(std::uint64_t x) noexcept {
  x = (x + 0x9E3779B97F4A7C15u) * 0xBF58476D1CE4E5B9u;
  x = (x ^ x >> 27) * 0x94D049BB133111EBu;
  return x ^ x >> 31;
}

/// Fields that stations leave as they are. ADP of positional and broadcast commands is counted up by every station.
bool same_target(const DatagramHeader& sent, const DatagramHeader& got) noexcept {
  switch (sent.command) {
    case Command::Aprd:
    case Command::Apwr:
    case Command::Aprw:
    case Command::Armw:
    case Command::Brd:
    case Command::Bwr:
    case Command::Brw: return sent.ado() == got.ado();
    default: return sent.address == got.address;
  }
}

}  // namespace

void Frame::start(std::uint32_t sequence, PortIndex port) noexcept {
  std::fill_n(buffer_.begin(), kSourceOffset, std::byte{0xFF});  // to everybody
  std::copy(source_.begin(), source_.end(), buffer_.begin() + kSourceOffset);
  buffer_[kSourceOffset + source_.size()] = static_cast<std::byte>(port);
  buffer_[kEtherTypeOffset] = static_cast<std::byte>(kEtherType >> 8);
  buffer_[kEtherTypeOffset + 1] = static_cast<std::byte>(kEtherType & 0xFF);
  std::fill_n(buffer_.begin() + kEthernetHeader, kMinEthernetFrame - kEthernetHeader, std::byte{0});
  size_ = kFrameHeader;
  sequence_ = sequence;
  scrambled_ = scramble(sequence);
  slots_.clear();
}

std::size_t Frame::room() const noexcept {
  const std::size_t need = size_ + kDatagramHeader + kWorkingCounter;
  return slots_.size() == kMaxDatagrams || need >= buffer_.size() ? 0 : buffer_.size() - need;
}

SlotIndex Frame::add(Command command, std::uint32_t address, std::size_t length) noexcept {
  if (slots_.size() == kMaxDatagrams || size_ + kDatagramHeader + length + kWorkingCounter > buffer_.size())
    return kNoSlot;
  const Slot slot{static_cast<std::uint16_t>(size_), static_cast<std::uint16_t>(length)};
  if (!slots_.empty()) {  // the one before is no longer the last
    const std::span last(buffer_.data() + slots_.back().header, kDatagramHeader);
    auto h = get_datagram_header(last);
    h.more = true;
    put_datagram_header(last, h);
  }
  DatagramHeader h;
  h.command = command;
  const std::size_t n = slots_.size();
  h.index = static_cast<std::uint8_t>(n < 2 ? sequence_ >> (8 * n) : scrambled_ >> (8 * (n % 8)));
  h.address = address;
  h.length = slot.length;
  put_datagram_header(std::span(buffer_).subspan(slot.header), h);
  std::fill_n(buffer_.begin() + static_cast<std::ptrdiff_t>(slot.data()), length + kWorkingCounter, std::byte{0});
  size_ = slot.end();
  slots_.push_back(slot);
  put_le<std::uint16_t>(std::span(buffer_), kEthernetHeader,
                        static_cast<std::uint16_t>((size_ - kFrameHeader) | kTypeDatagrams << 12));
  return slots_.size() - 1;
}

SlotIndex Frame::add(Command command, std::uint32_t address, std::span<const std::byte> data_in) noexcept {
  const SlotIndex slot = add(command, address, data_in.size());
  if (slot != kNoSlot) std::copy(data_in.begin(), data_in.end(), data(slot).begin());
  return slot;
}

SlotIndex Frame::add_sequence() noexcept {
  std::array<std::byte, 4> raw{};
  put_le<std::uint32_t>(raw, 0, sequence_);
  return add(Command::Nop, 0, std::span<const std::byte>(raw));
}

std::span<std::byte> Frame::data(SlotIndex slot) noexcept {
  return std::span(buffer_).subspan(slots_[slot].data(), slots_[slot].length);
}

std::span<const std::byte> Frame::bytes() const noexcept {
  return std::span(buffer_).first(std::max(size_, kMinEthernetFrame));
}

std::span<const std::byte> Reply::data(SlotIndex slot) const noexcept {
  return bytes_.subspan(slots_[slot].data(), slots_[slot].length);
}

std::uint16_t Reply::working_counter(SlotIndex slot) const noexcept {
  return get_le<std::uint16_t>(bytes_, slots_[slot].end() - kWorkingCounter);
}

std::optional<MacAddress> sender_of(std::span<const std::byte> received) noexcept {
  if (received.size() < kEthernetHeader || received[kEtherTypeOffset] != static_cast<std::byte>(kEtherType >> 8) ||
      received[kEtherTypeOffset + 1] != static_cast<std::byte>(kEtherType & 0xFF))
    return std::nullopt;
  MacAddress sender{};
  std::copy_n(received.begin() + kSourceOffset, sender.size(), sender.begin());
  return sender;
}

namespace {

/// Of a frame that has a frame header at least, behind its Ethernet header.
Match match_datagrams(const Frame& sent, std::span<const std::byte> received, bool processed) noexcept {
  const auto out = sent.bytes();
  // Another frame of this master may have another shape; its first index shows that it is another one.
  const auto slots = sent.slots();
  if (slots.empty() || received.size() < kFrameHeader + kDatagramHeader) return Match::Malformed;
  if (get_datagram_header(received.subspan(kFrameHeader)).index != get_datagram_header(out.subspan(kFrameHeader)).index)
    return Match::Late;

  // The lengths first, so that nothing is read past the end.
  if (received.size() < slots.back().end()) return Match::Malformed;
  if (get_le<std::uint16_t>(received, kEthernetHeader) != get_le<std::uint16_t>(out, kEthernetHeader))
    return Match::Malformed;

  bool index_differs = false, seen_by_a_station = processed;
  for (const Slot& slot : slots) {
    const auto want = get_datagram_header(out.subspan(slot.header));
    const auto got = get_datagram_header(received.subspan(slot.header));
    if (got.command != want.command || got.length != want.length || got.more != want.more || !same_target(want, got))
      return Match::Malformed;
    index_differs |= got.index != want.index;
    if (want.command == Command::Nop) {
      const auto data = out.subspan(slot.data(), slot.length);
      index_differs |=
          !std::equal(data.begin(), data.end(), received.begin() + static_cast<std::ptrdiff_t>(slot.data()));
    }
    seen_by_a_station |= get_le<std::uint16_t>(received, slot.end() - kWorkingCounter) != 0;
  }
  if (index_differs) return Match::Late;
  return seen_by_a_station ? Match::Ours : Match::Unprocessed;
}

}  // namespace

Match match(const Frame& sent, std::span<const std::byte> received, Reply& reply) noexcept {
  if (received.size() < kFrameHeader) return Match::Malformed;
  const auto out = sent.bytes();
  const auto processed_bit = std::byte{kProcessedMacBit};
  const bool processed = (received[kSourceOffset] & processed_bit) != std::byte{0};
  const bool of_this_master = (received[kSourceOffset] & ~processed_bit) == out[kSourceOffset] &&
                              std::equal(received.begin() + kSourceOffset + 1, received.begin() + kEthernetHeader,
                                         out.begin() + kSourceOffset + 1);
  const Match datagrams = match_datagrams(sent, received, processed);
  const bool ours = datagrams == Match::Ours || datagrams == Match::Unprocessed;
  // Nobody else sends these datagrams: its source or its EtherType was changed.
  if (!of_this_master) return ours ? Match::Malformed : Match::Foreign;
  if (!ours) return datagrams;
  reply.bytes_ = received;
  reply.slots_ = sent.slots();
  return datagrams;
}

}  // namespace gantry::devices
