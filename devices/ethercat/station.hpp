// What the master knows of one station while it brings it up: its place in the machine file, what was found on the bus,
// and the record that is written to it. The record is data, so that the same can be written again after a power cycle.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "config/machine.hpp"
#include "devices/wire/ethercat.hpp"

namespace gantry::devices {

/// The part of a station's SII that bring-up needs.
struct StationSii {
  std::uint32_t vendor = 0, product = 0, revision = 0, serial = 0;
  std::uint16_t mailbox_out_start = 0, mailbox_out_bytes = 0, mailbox_in_start = 0, mailbox_in_bytes = 0;
};

/// Counters of a mailbox: those of the request and of the reply run independently.
struct MailboxState {
  std::uint8_t request_counter = 0;
  std::uint8_t last_reply_counter = 0;
  bool repeat_toggle = false;
};

struct StationRecord {
  const config::Station* config = nullptr;
  std::string where;          ///< "station 3 'y1'": position from 0 and name
  std::uint16_t address = 0;  ///< configured station address, 1001h + position

  // found
  StationSii sii;
  std::uint16_t alias = 0;
  std::uint16_t features = 0;  ///< 0008h

  // to be written
  std::vector<wire::SyncManager> sync_managers;  ///< by number
  std::vector<wire::Fmmu> fmmus;
  std::size_t output_offset = 0, output_bytes = 0;  ///< in the image of all stations
  std::size_t input_offset = 0, input_bytes = 0;
  bool dc = false;                ///< takes part in distributed clocks
  std::uint32_t dc_delay_ns = 0;  ///< from the reference clock

  MailboxState mailbox;

  [[nodiscard]] const config::StationProfile& profile() const { return config->profile; }
  [[nodiscard]] bool has_mailbox() const;
};

/// First sync manager of a kind, by number; nullptr when the station has none.
const wire::SyncManager* find_sync_manager(const StationRecord& station, config::SyncManagerKind kind, int* number);

}  // namespace gantry::devices
