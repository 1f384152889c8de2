// A master for tests that shares nothing with the project's own: every byte is put where ETG.1000.4 and ETG.1000.6 have
// it. It sends one datagram a frame straight into the segment and checks what a ring must give back.
//   RawMaster bus(segment, clock);
//   auto [data, wkc] = bus.read(0x1001, 0x0130, 2);      // FPRD
//   bus.bring_up(0, pre_op) ...
#pragma once
#include <algorithm>
#include <cstdint>
#include <cstring>
#include <gtest/gtest.h>
#include <optional>
#include <vector>

#include "core/clock.hpp"
#include "sim/segment/segment.hpp"

namespace gantry::sim::test {

using Raw = std::vector<std::uint8_t>;

struct Answer {
  Raw data;
  int wkc = -1;  ///< -1: the frame did not come back
};

inline std::uint64_t value(const Raw& bytes, std::size_t at = 0, std::size_t size = 8) {
  std::uint64_t v = 0;
  for (std::size_t i = 0; i < size && at + i < bytes.size(); ++i) v |= std::uint64_t{bytes[at + i]} << (8 * i);
  return v;
}
inline Raw bytes(std::uint64_t v, std::size_t size) {
  Raw out;
  for (std::size_t i = 0; i < size; ++i) out.push_back(static_cast<std::uint8_t>(v >> (8 * i)));
  return out;
}
inline Raw operator+(Raw a, const Raw& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

class RawMaster {
 public:
  RawMaster(Segment& segment, VirtualClock& clock) : segment_(segment), clock_(clock) {}

  /// Commands by number: 1 APRD, 2 APWR, 3 APRW, 4 FPRD, 5 FPWR, 6 FPRW, 7 BRD, 8 BWR, 9 BRW, 10 LRD, 11 LWR, 12 LRW,
  /// 13 ARMW, 14 FRMW.
  static Raw datagram(std::uint8_t command, std::uint16_t adp, std::uint16_t ado, const Raw& data, bool more = false) {
    Raw d{command, 0x5A};
    d = d + bytes(adp, 2) + bytes(ado, 2) + bytes(data.size() | (more ? 0x8000u : 0u), 2) + bytes(0, 2);
    return d + data + bytes(0, 2);
  }
  static Raw frame(const Raw& datagrams) {
    Raw f{0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0x10, 0x20, 0x30, 0x40, 0x50, 0x60, 0x88, 0xA4};
    f = f + bytes(datagrams.size() | 0x1000u, 2) + datagrams;
    if (f.size() < 60) f.resize(60);
    return f;
  }
  bool process(Raw& f) {
    if (recorded != nullptr) recorded->push_back(f);
    const bool back = segment_.process(std::as_writable_bytes(std::span(f)));
    if (recorded != nullptr && back) recorded->push_back(f);
    return back;
  }

  Answer send(std::uint8_t command, std::uint16_t adp, std::uint16_t ado, const Raw& data) {
    Raw f = frame(datagram(command, adp, ado, data));
    if (!process(f)) return {};
    EXPECT_EQ(f[6], 0x12);  // the first station has set bit 1
    last_adp = static_cast<std::uint16_t>(value(f, 18, 2));
    return {Raw(f.begin() + 26, f.begin() + 26 + static_cast<std::ptrdiff_t>(data.size())),
            static_cast<int>(value(f, 26 + data.size(), 2))};
  }
  Answer read(std::uint16_t station, std::uint16_t ado, std::size_t size) { return send(4, station, ado, Raw(size)); }
  int write(std::uint16_t station, std::uint16_t ado, const Raw& data) { return send(5, station, ado, data).wkc; }
  int write(std::uint16_t station, std::uint16_t ado, std::uint64_t v, std::size_t size) {
    return write(station, ado, bytes(v, size));
  }
  Answer logical(std::uint8_t command, std::uint32_t address, const Raw& data) {
    return send(command, static_cast<std::uint16_t>(address), static_cast<std::uint16_t>(address >> 16), data);
  }

  /// Station addresses 1001h, 1002h ... by position.
  int address_all() {
    const int n = send(7, 0, 0, Raw(1)).wkc;
    for (int i = 0; i < n; ++i)
      EXPECT_EQ(send(2, static_cast<std::uint16_t>(-i), 0x0010, bytes(0x1001u + static_cast<unsigned>(i), 2)).wkc, 1);
    return n;
  }
  std::uint16_t state(std::uint16_t station) {
    return static_cast<std::uint16_t>(value(read(station, 0x0130, 2).data));
  }
  std::uint16_t status_code(std::uint16_t station) {
    return static_cast<std::uint16_t>(value(read(station, 0x0134, 2).data));
  }
  /// Asks for a state and gives the station 1 ms; AL status then.
  std::uint16_t request(std::uint16_t station, unsigned state_wanted) {
    write(station, 0x0120, state_wanted, 2);
    wait(milliseconds(1));
    return state(station);
  }
  /// Off first: where it lies changes only then.
  void sync_manager(std::uint16_t station, unsigned n, std::uint16_t start, std::size_t size, std::uint8_t control,
                    bool on = true) {
    write(station, static_cast<std::uint16_t>(0x0806 + 8 * n), 0, 1);
    write(station, static_cast<std::uint16_t>(0x0800 + 8 * n),
          bytes(start, 2) + bytes(size, 2) + Raw{control, 0, static_cast<std::uint8_t>(on ? 1 : 0), 0});
  }
  void fmmu(std::uint16_t station, unsigned n, std::uint32_t logical_start, std::size_t size, std::uint16_t physical,
            std::uint8_t type) {
    write(station, static_cast<std::uint16_t>(0x0600 + 16 * n),
          bytes(logical_start, 4) + bytes(size, 2) + Raw{0, 7} + bytes(physical, 2) + Raw{0, type, 1, 0, 0, 0});
  }
  void mailboxes(std::uint16_t station) {
    sync_manager(station, 0, 0x1000, 128, 0x26);
    sync_manager(station, 1, 0x1080, 128, 0x22);
  }

  std::uint32_t sii(std::uint16_t station, std::uint16_t word) {
    write(station, 0x0502, bytes(0x0100, 2) + bytes(word, 4));
    EXPECT_EQ(value(read(station, 0x0502, 2).data) & 0x8000u, 0x8000u);
    wait(microseconds(200));
    EXPECT_EQ(value(read(station, 0x0502, 2).data) & 0xF800u, 0u);
    return static_cast<std::uint32_t>(value(read(station, 0x0508, 8).data, 0, 4));
  }

  /// One mailbox there and one back (CoE, without the mailbox header); nothing: none came.
  std::optional<Raw> mailbox(std::uint16_t station, const Raw& coe) {
    counter_ = static_cast<std::uint8_t>(counter_ % 7 + 1);
    Raw out = bytes(coe.size(), 2) + bytes(0, 2) + Raw{0, static_cast<std::uint8_t>(0x03 | counter_ << 4)} + coe;
    out.resize(128);
    if (write(station, 0x1000, out) != 1) return std::nullopt;
    return fetch(station);
  }
  std::optional<Raw> fetch(std::uint16_t station) {
    if ((value(read(station, 0x080D, 1).data) & 0x08) == 0) return std::nullopt;
    const Answer in = read(station, 0x1080, 128);
    EXPECT_EQ(in.wkc, 1);
    const auto size = static_cast<std::ptrdiff_t>(value(in.data, 0, 2));
    mailbox_type = in.data[5] & 0x0F;
    return Raw(in.data.begin() + 6, in.data.begin() + 6 + size);
  }
  /// 0, or the abort code. Expedited.
  std::uint32_t sdo_write(std::uint16_t station, std::uint16_t index, std::uint8_t sub, std::uint64_t v,
                          std::size_t size) {
    const auto command = static_cast<std::uint8_t>(0x23 | (4 - size) << 2);
    const auto reply = mailbox(station, bytes(0x2000, 2) + Raw{command} + bytes(index, 2) + Raw{sub} + bytes(v, 4));
    if (!reply || reply->size() < 10) return 0xFFFFFFFF;
    if ((*reply)[2] == 0x80) return static_cast<std::uint32_t>(value(*reply, 6, 4));
    EXPECT_EQ((*reply)[2], 0x60);
    return 0;
  }
  /// Value of a short object; nothing when it was refused (then `abort` says why).
  std::optional<std::uint32_t> sdo_read(std::uint16_t station, std::uint16_t index, std::uint8_t sub) {
    const auto reply = mailbox(station, bytes(0x2000, 2) + Raw{0x40} + bytes(index, 2) + Raw{sub} + bytes(0, 4));
    if (!reply || reply->size() < 10) return std::nullopt;
    if ((*reply)[2] == 0x80) {
      abort = static_cast<std::uint32_t>(value(*reply, 6, 4));
      return std::nullopt;
    }
    EXPECT_EQ((*reply)[2] & 0xE3, 0x43);
    return static_cast<std::uint32_t>(value(*reply, 6, 4u - ((*reply)[2] >> 2 & 3u)));
  }
  /// Replaces what a PDO holds: entries as 16xxh has them.
  void map(std::uint16_t station, std::uint16_t assignment, std::uint16_t pdo,
           const std::vector<std::uint32_t>& entries) {
    EXPECT_EQ(sdo_write(station, assignment, 0, 0, 1), 0u);
    EXPECT_EQ(sdo_write(station, pdo, 0, 0, 1), 0u);
    for (std::size_t i = 0; i < entries.size(); ++i)
      EXPECT_EQ(sdo_write(station, pdo, static_cast<std::uint8_t>(i + 1), entries[i], 4), 0u);
    EXPECT_EQ(sdo_write(station, pdo, 0, entries.size(), 1), 0u);
    EXPECT_EQ(sdo_write(station, assignment, 1, pdo, 2), 0u);
    EXPECT_EQ(sdo_write(station, assignment, 0, 1, 1), 0u);
  }

  void wait(Time t) { clock_.sleep_until(clock_.now() + t); }

  std::vector<Raw>* recorded = nullptr;  ///< every frame, there and back
  std::uint32_t abort = 0;
  std::uint8_t mailbox_type = 0;
  std::uint16_t last_adp = 0;

 private:
  Segment& segment_;
  VirtualClock& clock_;
  std::uint8_t counter_ = 0;
};

}  // namespace gantry::sim::test
