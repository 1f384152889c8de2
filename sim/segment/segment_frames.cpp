// Segment: a frame goes through the stations.
#include <array>
#include <cstring>

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
  for (std::size_t at = begin; at < begin + length;) {
    const DatagramHeader h = get_datagram_header(frame.subspan(at));
    const std::size_t data = at + kDatagramHeader, counter = data + h.length;
    serve_datagram(frame.subspan(at, kDatagramHeader), frame.subspan(data, h.length),
                   frame.subspan(counter, kWorkingCounter), now);
    at = counter + kWorkingCounter;
    if (!h.more) break;
  }
  bool way_changed = false;
  for (const Hop& hop : route_) way_changed |= hop.station->serve(now);
  const bool back = !route_ends_nowhere_;
  if (way_changed) {
    for (int i = 0; i < station_count(); ++i)
      if (const auto dark = station(i).take_restart()) power_cycle(ids_[static_cast<std::size_t>(i)], *dark);
    update_links();
  }
  ++frames_;
  if (fate_.header) spoil_header(frame.first(begin + length));
  return back;
}

void Segment::serve_datagram(std::span<std::byte> header, std::span<std::byte> data, std::span<std::byte> counter,
                             Time now) noexcept {
  DatagramHeader h = get_datagram_header(header);
  auto wkc = get_le<std::uint16_t>(counter, 0);
  std::uint16_t adp = h.adp();
  const std::uint16_t ado = h.ado();
  std::array<std::byte, devices::kMaxFrameBytes> copy;  // what a station had
  const auto mine = std::span(copy).first(data.size());

  const auto read = [&](Esc& esc, Time at) {
    wkc = static_cast<std::uint16_t>(wkc + (esc.read(ado, data, at) ? kWkcRead : 0));
  };
  const auto write = [&](Esc& esc, Time at) {
    wkc = static_cast<std::uint16_t>(wkc + (esc.write(ado, data, at) ? kWkcWrite : 0));
  };
  const auto shifted = [&](const Esc& esc) { return static_cast<std::uint16_t>(ado + esc.read_write_offset()); };
  // Reads what was there and writes what came.
  const auto exchange = [&](Esc& esc, Time at) {
    std::memcpy(mine.data(), data.data(), data.size());
    if (esc.read(ado, data, at)) wkc = static_cast<std::uint16_t>(wkc + kWkcReadWriteRead);
    if (esc.write(shifted(esc), mine, at)) wkc = static_cast<std::uint16_t>(wkc + kWkcReadWriteWrite);
  };
  const auto read_or = [&](Esc& esc, Time at) {
    std::memset(mine.data(), 0, mine.size());  // what lies under a closed SyncManager adds nothing
    if (!esc.read(ado, mine, at)) return;
    for (std::size_t i = 0; i < data.size(); ++i) data[i] |= mine[i];
    wkc = static_cast<std::uint16_t>(wkc + kWkcRead);
  };

  for (const Hop& hop : route_) {
    Esc& esc = hop.station->esc();
    const Time at = now + hop.entry;
    h.irq |= esc.irq();
    switch (h.command) {
      case Command::Aprd:
        if (adp++ == 0) read(esc, at);
        break;
      case Command::Apwr:
        if (adp++ == 0) write(esc, at);
        break;
      case Command::Aprw:
        if (adp++ == 0) exchange(esc, at);
        break;
      case Command::Fprd:
        if (esc.answers_to(adp)) read(esc, at);
        break;
      case Command::Fpwr:
        if (esc.answers_to(adp)) write(esc, at);
        break;
      case Command::Fprw:
        if (esc.answers_to(adp)) exchange(esc, at);
        break;
      case Command::Brd:
        ++adp;
        read_or(esc, at);
        break;
      case Command::Bwr:
        ++adp;
        write(esc, at);
        break;
      case Command::Brw: {
        ++adp;
        std::array<std::byte, devices::kMaxFrameBytes> came;
        std::memcpy(came.data(), data.data(), data.size());
        read_or(esc, at);
        if (esc.write(shifted(esc), std::span(came).first(data.size()), at))
          wkc = static_cast<std::uint16_t>(wkc + kWkcReadWriteWrite);
        break;
      }
      case Command::Lrd:
      case Command::Lwr:
      case Command::Lrw: wkc = static_cast<std::uint16_t>(wkc + esc.logical(h.command, h.address, data, at)); break;
      case Command::Armw:
        if (adp++ == 0)
          read(esc, at);
        else
          write(esc, at);
        break;
      case Command::Frmw:
        if (esc.answers_to(adp))
          read(esc, at);
        else
          write(esc, at);
        break;
      case Command::Nop:
      default: break;
    }
  }
  const bool logical = h.command == Command::Lrd || h.command == Command::Lwr || h.command == Command::Lrw;
  if (!logical) h.address = physical_address(adp, ado);
  put_datagram_header(header, h);
  put_le<std::uint16_t>(counter, 0, wkc);
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
