// Segment: a frame goes through the stations.
#include "devices/frame_port.hpp"
#include "devices/wire/ethercat.hpp"
#include "sim/segment/segment.hpp"
#include "sim/station/station.hpp"

namespace gantry::sim {

using namespace devices::wire;

namespace {

constexpr std::size_t kTag = 4;            // IEEE 802.1Q
constexpr std::uint16_t kTagged = 0x8100;  // big-endian on the wire

bool has_type(std::span<const std::byte> frame, std::size_t at, std::uint16_t type) noexcept {
  return frame.size() >= at + 4 && frame[at] == static_cast<std::byte>(type >> 8) &&
         frame[at + 1] == static_cast<std::byte>(type & 0xFF);
}

/// Where the datagrams of an EtherCAT frame begin; 0: it is none. A VLAN tag is passed over and not looked at (ESC data
/// sheet I, 2.1).
std::size_t datagrams_at(std::span<const std::byte> frame) noexcept {
  constexpr std::size_t kType = kEthernetHeader - 2;
  if (has_type(frame, kType, kEtherType)) return kFrameHeader;
  if (has_type(frame, kType, kTagged) && has_type(frame, kType + kTag, kEtherType)) return kFrameHeader + kTag;
  return 0;
}

/// Bytes of the datagrams from `begin` on; 0: no ring would answer this.
std::size_t datagram_bytes(std::span<const std::byte> frame, std::size_t begin) noexcept {
  if (frame.size() < begin + kDatagramHeader + kWorkingCounter ||
      frame.size() - begin > devices::kMaxFrameBytes - kFrameHeader)
    return 0;
  const auto header = get_le<std::uint16_t>(frame, begin - kEtherCatHeader);
  const std::size_t length = header & kLengthMask;
  if (header >> 12 != kTypeDatagrams || length > frame.size() - begin) return 0;
  std::size_t at = begin;
  const std::size_t end = begin + length;
  for (bool more = true; more;) {
    if (end - at < kDatagramHeader + kWorkingCounter) return 0;
    const DatagramHeader h = get_datagram_header(frame.subspan(at));
    if (end - at < kDatagramHeader + h.length + kWorkingCounter) return 0;
    at += kDatagramHeader + h.length + kWorkingCounter;
    more = h.more;
  }
  return length;
}

}  // namespace

bool Segment::process(std::span<std::byte> frame) noexcept {
  const std::size_t begin = datagrams_at(frame);
  const std::size_t length = begin > 0 ? datagram_bytes(frame, begin) : 0;
  const Time now = clock_.now();
  if (length == 0) {
    fate_ = {};
    if (begin == 0) return frame.size() >= kEthernetHeader && passes_foreign_frames_ && !route_ends_nowhere_;
    for (const Hop& hop : route_) hop.station->esc().count_error(Esc::FrameError::ProcessingUnit, 0);
    return false;
  }
  advance_to(now);
  if (route_.empty()) return false;
  fate_ = faults_.next(2 * static_cast<int>(route_.size()));
  if (fate_.lost) return false;
  if (fate_.hit_at >= 0) {
    count_hit(fate_.hit_at);
    return false;
  }
  if (!passes_foreign_frames_) frame[6] |= std::byte{kProcessedMacBit};
  datagrams_.clear();
  for (std::size_t at = begin; at < begin + length;) {
    const Datagram& d = datagrams_.emplace_back(frame.subspan(at));
    at += d.size();
    if (!d.more()) break;
  }
  bool route_changed = false;
  for (const Hop& hop : route_) {
    for (Datagram& d : datagrams_) d.pass(hop.station->esc(), now + hop.entry);
    route_changed |= hop.station->serve(now);
  }
  for (const Datagram& d : datagrams_) d.put_back();
  const bool back = !route_ends_nowhere_;
  if (route_changed) {
    for (int i = 0; i < station_count(); ++i)
      if (const auto dark = station(i).take_restart()) power_cycle(ids_[static_cast<std::size_t>(i)], *dark);
    update_links();
  }
  ++frames_;
  if (fate_.header) spoil_header(frame.first(begin + length));
  return back;
}

/// Bits are hit on one of the cables, counted there and back: the station behind it sees a wrong FCS, those after it
/// see that somebody else did (ESC data sheet I, 13). None of them acts on the frame.
void Segment::count_hit(int place) noexcept {
  const int n = static_cast<int>(route_.size());
  const auto esc = [&](int i) -> Esc& { return route_[static_cast<std::size_t>(i)].station->esc(); };
  int i = place;
  if (i < n) {
    esc(i).count_error(Esc::FrameError::Invalid, 0);
    for (++i; i < n; ++i) esc(i).count_error(Esc::FrameError::Forwarded, 0);
    i = n;
    for (; i < 2 * n - 1; ++i) esc(2 * n - 2 - i).count_error(Esc::FrameError::Forwarded, 1);
    return;
  }
  // On the way back the last station is passed already; its neighbour hears it at port 1.
  for (bool first = true; i < 2 * n - 1; ++i, first = false)
    esc(2 * n - 2 - i).count_error(first ? Esc::FrameError::Invalid : Esc::FrameError::Forwarded, 1);
}

void Segment::spoil_header(std::span<std::byte> frame) noexcept {
  const auto at = static_cast<std::size_t>(faults_.below(static_cast<int>(kFrameHeader + kDatagramHeader)));
  frame[at] ^= static_cast<std::byte>(1 + faults_.below(255));
}

}  // namespace gantry::sim
