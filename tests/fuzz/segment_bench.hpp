// A short virtual line for the targets on the sim's side, and frames of one datagram put together byte by byte. It is
// built once; each input begins with renew(), after which it is as new (renew_test.cpp).
//   static SegmentBench line{"drives/id286.yaml", "devices/dio16.yaml"};
//   line.renew();   line.bring_up(AlState::PreOp);   line.datagram(1, 0, 0x0130, two_bytes);   line.round(payload);
#pragma once
#include <array>
#include <cstdlib>
#include <initializer_list>
#include <string>
#include <vector>

#include "config/machine.hpp"
#include "core/clock.hpp"
#include "devices/wire/bytes.hpp"
#include "devices/wire/ethercat.hpp"
#include "sim/objects/pdo_map.hpp"
#include "sim/objects/sii_image.hpp"
#include "sim/segment/segment.hpp"
#include "sim/station/station.hpp"
#include "tests/fuzz/input.hpp"

namespace gantry::fuzz {

/// Stations with these profiles (files under config/), one behind the other, with mailboxes of this length where they
/// have any (0: their own).
inline config::Machine machine_of(std::initializer_list<const char*> profiles, std::uint16_t mailbox_bytes) {
  config::Machine m;
  for (const char* file : profiles) {
    auto profile = config::load_profile(std::string(GANTRY_SOURCE_DIR "/config/") + file);
    if (!profile) std::abort();
    config::Station s;
    s.id = StationId{static_cast<std::uint16_t>(m.stations.size())};
    s.position = static_cast<int>(m.stations.size());
    s.profile = std::move(*profile);
    s.name = s.profile.name;
    for (auto& row : s.profile.sync_managers)
      if (mailbox_bytes != 0 && row.length != 0) row.length = mailbox_bytes;
    if (s.profile.slots == 0) s.profile.clock_bits = 32;  // both widths hang on the line
    m.stations.push_back(std::move(s));
  }
  return m;
}

class SegmentBench {
 public:
  using AlState = devices::wire::AlState;
  static constexpr std::uint16_t kFirstAddress = 0x1001;  ///< of the station at position 0, after bring_up()
  static constexpr Time kStep = microseconds(100);        ///< from one frame to the next

  SegmentBench(std::initializer_list<const char*> profiles, std::uint16_t mailbox_bytes = 0)
      : machine_(machine_of(profiles, mailbox_bytes)) {
    // Short, so that few cycles pass in waiting; long enough that a frame comes before the end.
    segment.set_timing({.al_up = microseconds(150),
                        .al_down = microseconds(50),
                        .al_up_max = milliseconds(2),
                        .sii_read = microseconds(50),
                        .sii_write = microseconds(150),
                        .sii_reload = microseconds(150)});
    for (const auto& station : machine_.stations) rows_.push_back(sim::sync_managers(station.profile));
    for (int i = 0; i < segment.station_count(); ++i) of_new_.push_back(layout(i));
  }

 private:
  config::Machine machine_;

 public:
  VirtualClock clock;
  sim::Segment segment{machine_, clock};

  void renew() {
    clock = VirtualClock{};
    segment.renew();
  }
  void wait(Time t) {
    clock.sleep_until(clock.now() + t);
    segment.advance();
  }

  /// Any bytes after the Ethernet header. The frame as it is behind the last station.
  std::vector<std::byte> round(std::span<const std::byte> payload) {
    std::vector<std::byte> frame(14 + payload.size());  // a heap block of the exact size
    frame[12] = std::byte{0x88}, frame[13] = std::byte{0xA4};
    std::copy(payload.begin(), payload.end(), frame.begin() + 14);
    clock.sleep_until(clock.now() + kStep);
    const bool back = segment.process(frame);
    note_said(back ? 1 : 0);
    note_said(frame);
    return frame;
  }
  /// What the working counter came to.
  unsigned datagram(unsigned command, std::uint32_t address, std::span<const std::byte> data) {
    using namespace devices::wire;
    constexpr std::size_t kMost = 1486;  // what a frame takes
    data = data.first(std::min(data.size(), kMost));
    std::vector<std::byte> p(2 + kDatagramHeader + data.size() + kWorkingCounter);
    put_le<std::uint16_t>(p, 0, static_cast<std::uint16_t>((p.size() - 2) | kTypeDatagrams << 12));
    DatagramHeader h;
    h.command = static_cast<Command>(command);
    h.address = address;
    h.length = static_cast<std::uint16_t>(data.size());
    put_datagram_header(std::span(p).subspan(2), h);
    std::copy(data.begin(), data.end(), p.begin() + 2 + kDatagramHeader);
    return get_le<std::uint16_t>(round(p), kFrameHeader + p.size() - 2 - kWorkingCounter);
  }
  /// The bus side of a station's ESC without a frame around it, for what is not about frames. False: it takes no part.
  bool read(unsigned position, unsigned ado, std::span<std::byte> data) {
    return access(position, [&](sim::Esc& esc) {
      const bool read = esc.read(static_cast<std::uint16_t>(ado), data, clock.now());
      note_said(data);
      return read;
    });
  }
  bool write(unsigned position, unsigned ado, std::span<const std::byte> data) {
    return access(position,
                  [&](sim::Esc& esc) { return esc.write(static_cast<std::uint16_t>(ado), data, clock.now()); });
  }
  template <class... B>
  void poke(unsigned position, unsigned ado, B... bytes) {
    const std::array<std::byte, sizeof...(B)> data{static_cast<std::byte>(bytes)...};
    write(position, ado, data);
  }
  /// ADP and ADO of a datagram.
  static std::uint32_t address(unsigned adp, unsigned ado) { return (adp & 0xFFFFu) | (ado & 0xFFFFu) << 16; }

  /// All stations, with addresses, SyncManagers and FMMUs as a new one's profile and mapping have them. Logical
  /// addresses: station n's outputs and inputs both begin at n * 1000h.
  void bring_up(AlState state) {
    for (int i = 0; i < segment.station_count(); ++i) {
      const unsigned address = kFirstAddress + static_cast<unsigned>(i);
      poke(static_cast<unsigned>(i), 0x0010, address & 0xFF, address >> 8);
      put(i, of_new_[static_cast<std::size_t>(i)]);
    }
    for (const auto step : {AlState::PreOp, AlState::SafeOp, AlState::Op}) {
      if (step > state) return;
      if (step == AlState::Op)
        for (int i = 0; i < segment.station_count(); ++i) put_outputs(i, of_new_[static_cast<std::size_t>(i)]);
      for (int i = 0; i < segment.station_count(); ++i) poke(static_cast<unsigned>(i), 0x0120, step, 0);
      wait(microseconds(200));
    }
  }
  /// SyncManagers and FMMUs of a station for what its PDOs hold now, and outputs at zero.
  void lay_out(int position) {
    const auto& rows = rows_[static_cast<std::size_t>(position)];
    for (unsigned i = 0; i < rows.size(); ++i)  // where one lies changes only while it is off
      if (rows[i].kind == config::SyncManagerKind::ProcessOut || rows[i].kind == config::SyncManagerKind::ProcessIn)
        poke(static_cast<unsigned>(position), 0x0806 + 8 * i, 0);
    put(position, layout(position));
  }
  void write_outputs(int position) { put_outputs(position, layout(position)); }

 private:
  template <class F>
  bool access(unsigned position, F&& f) {
    wait(kStep);
    sim::Station& station = segment.station(static_cast<int>(position));
    const bool part = station.powered() && f(station.esc());
    note_said(part ? 1 : 0);
    station.serve(clock.now());
    return part;
  }
  struct Layout {
    std::array<std::byte, 4 * devices::wire::kSyncManagerBytes> managers{};
    std::array<std::byte, 2 * devices::wire::kFmmuBytes> fmmus{};
    std::uint16_t outputs_start = 0;
    std::size_t output_bytes = 0;
  };
  void put(int position, const Layout& layout) {
    write(static_cast<unsigned>(position), 0x0800, layout.managers);
    write(static_cast<unsigned>(position), 0x0600, layout.fmmus);
  }
  void put_outputs(int position, const Layout& layout) {
    if (layout.output_bytes > 0)
      write(static_cast<unsigned>(position), layout.outputs_start, std::vector<std::byte>(layout.output_bytes));
  }
  [[nodiscard]] Layout layout(int position) {
    using namespace devices::wire;
    using Kind = config::SyncManagerKind;
    Layout l;
    const auto& rows = rows_[static_cast<std::size_t>(position)];
    for (std::size_t i = 0; i < std::min<std::size_t>(rows.size(), 4); ++i) {
      const bool mailbox = rows[i].kind == Kind::MailboxOut || rows[i].kind == Kind::MailboxIn;
      const bool out = rows[i].kind == Kind::MailboxOut || rows[i].kind == Kind::ProcessOut;
      const std::size_t bytes = mailbox ? rows[i].length : process_bytes(position, out);
      const auto row = std::span(l.managers).subspan(i * kSyncManagerBytes);
      put_le<std::uint16_t>(row, 0, rows[i].start);
      put_le<std::uint16_t>(row, 2, static_cast<std::uint16_t>(bytes));
      put_le<std::uint8_t>(row, 4, static_cast<std::uint8_t>(mailbox ? (out ? 0x26 : 0x22) : (out ? 0x64 : 0x20)));
      put_le<std::uint8_t>(row, 6, bytes > 0 ? 1 : 0);
      if (mailbox) continue;
      const auto fmmu = std::span(l.fmmus).subspan(out ? 0 : kFmmuBytes);
      put_le<std::uint32_t>(fmmu, 0, static_cast<std::uint32_t>(position) << 12);
      put_le<std::uint16_t>(fmmu, 4, static_cast<std::uint16_t>(bytes));
      put_le<std::uint8_t>(fmmu, 7, 7);
      put_le<std::uint16_t>(fmmu, 8, rows[i].start);
      put_le<std::uint8_t>(fmmu, 11, out ? 2 : 1);
      put_le<std::uint8_t>(fmmu, 12, bytes > 0 ? 1 : 0);
      if (out) l.outputs_start = rows[i].start, l.output_bytes = bytes;
    }
    return l;
  }
  [[nodiscard]] std::size_t process_bytes(int position, bool out) {
    return sim::PdoMap::build(segment.station(position).objects(), out ? sim::PdoDirection::Rx : sim::PdoDirection::Tx)
        .bytes();
  }
  std::vector<std::vector<config::SyncManagerRow>> rows_;  ///< by position
  std::vector<Layout> of_new_;                             ///< the same
};

}  // namespace gantry::fuzz
