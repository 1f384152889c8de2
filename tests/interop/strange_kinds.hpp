// The strange stations (strange_stations.py) as a machine file would have them.
//   machine.stations.push_back(strange_station(0, "big_box"));
#pragma once
#include <cstdint>
#include <map>
#include <string>

#include "config/machine.hpp"

namespace gantry::interop {

using config::SyncManagerKind;

struct Kind {
  std::uint32_t product;
  bool mailbox;
  std::uint16_t out_at, in_at;
  int bytes;
  bool dc;
  bool split = false;  ///< each half of the bytes in a SyncManager and a PDO of its own, 20h apart
};
inline const std::map<std::string, Kind>& kinds() {
  static const std::map<std::string, Kind> all{
      {"big_box", {0x101, true, 0x1100, 0x1400, 4, false}},
      {"slow", {0x102, true, 0x1100, 0x1400, 4, true}},
      {"capricious", {0x103, true, 0x1100, 0x1400, 4, false}},
      {"no_lrw", {0x104, true, 0x1100, 0x1400, 4, true}},
      {"nervous", {0x105, true, 0x1100, 0x1400, 4, false}},
      {"simple", {0x106, false, 0x0F00, 0x1000, 2, true}},
      {"wary", {0x10D, true, 0x1100, 0x1400, 4, false}},  // its data sheet is wrong about these two
      {"hushed", {0x10C, true, 0x1100, 0x1400, 4, false}},
      {"split", {0x10B, false, 0x0F00, 0x1000, 4, false, true}},
  };
  return all;
}

/// As somebody would write config/devices/KIND.yaml from the stations' data sheet.
inline config::Station strange_station(int position, const std::string& name) {
  const Kind& kind = kinds().at(name);
  config::Station s;
  s.id = StationId{static_cast<std::uint16_t>(position)};
  s.position = position;
  s.name = s.profile.name = s.profile.title = name;
  s.profile.identity = {0x5A5A, kind.product, 3, false};
  s.profile.slots = 0;
  s.profile.pdo_fixed = true;
  s.profile.dc = kind.dc;
  s.profile.watchdog_ms = 1000;
  if (kind.mailbox)
    s.profile.sync_managers = {{SyncManagerKind::MailboxOut, 0x1000, 128}, {SyncManagerKind::MailboxIn, 0x1080, 128}};
  const int halves = kind.split ? 2 : 1;
  for (int n = 0; n < halves; ++n)
    s.profile.sync_managers.push_back(
        {SyncManagerKind::ProcessOut, static_cast<std::uint16_t>(kind.out_at + 0x20 * n), 0});
  for (int n = 0; n < halves; ++n)
    s.profile.sync_managers.push_back(
        {SyncManagerKind::ProcessIn, static_cast<std::uint16_t>(kind.in_at + 0x20 * n), 0});
  for (int n = 0; n < halves; ++n) {
    config::PdoRow rx{static_cast<std::uint16_t>(0x1600 + n), 0, {}}, tx{static_cast<std::uint16_t>(0x1A00 + n), 0, {}};
    for (int k = n * kind.bytes / halves + 1; k <= (n + 1) * kind.bytes / halves; ++k) {
      rx.entries.push_back({{0x7000, static_cast<std::uint8_t>(k)}, 8});
      tx.entries.push_back({{0x6000, static_cast<std::uint8_t>(k)}, 8});
    }
    s.profile.rx_pdos.push_back(rx);
    s.profile.tx_pdos.push_back(tx);
  }
  return s;
}

}  // namespace gantry::interop
