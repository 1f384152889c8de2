// What the master knows of one station: what was found on the bus, and the record that is written to it. The record is
// data: bring-up writes it in order, and recovery writes the same again after a power cycle. It comes from the machine
// file's profile, or for a station that the file does not know (a stranger) from the station's own EEPROM.
#pragma once
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "config/machine.hpp"
#include "devices/ethercat/sii.hpp"
#include "devices/station_bus.hpp"
#include "devices/wire/ethercat.hpp"

namespace gantry::devices {

/// What the ESC says of itself (0000h-0009h).
struct EscFacts {
  std::uint8_t type = 0, revision = 0;
  std::uint16_t build = 0;
  std::uint8_t fmmus = 0, sync_managers = 0, ram_kB = 0, port_descriptor = 0;
  std::uint16_t features = 0;
};

struct PortStatus {
  wire::PortKind kind = wire::PortKind::Absent;
  bool link = false;           ///< a cable with somebody at its end
  bool communication = false;  ///< and frames come back from there
  bool loop_closed = true;     ///< frames do not leave here
  [[nodiscard]] bool open() const { return link && !loop_closed; }
};
using Ports = std::array<PortStatus, wire::kPorts>;

/// One SyncManager as it is written, and what it is for.
struct SyncManagerPlan {
  wire::SyncManager registers;
  std::uint8_t kind = 0;  ///< 0: not used; else config::SyncManagerKind
  [[nodiscard]] bool is(config::SyncManagerKind k) const { return kind == static_cast<std::uint8_t>(k); }
  [[nodiscard]] bool is_mailbox() const {
    return is(config::SyncManagerKind::MailboxOut) || is(config::SyncManagerKind::MailboxIn);
  }
};

/// Counters of a mailbox: those of the request and of the reply run independently.
struct MailboxState {
  /// A station drops a request whose counter is that of the one before. Where another master has spoken with it
  /// (Foreign), that counter is not known: the first request goes out uncounted, and until a counted one is answered
  /// (Tried), one without an answer is sent again under the next counter.
  enum class Count : std::uint8_t { Ours, Foreign, Tried };
  Count count = Count::Ours;
  std::uint8_t request_counter = 0;
  std::uint8_t last_reply_counter = 0;
  bool repeat_toggle = false;
  bool repeats = true;                 ///< the station acknowledges repeat requests, as far as is known
  bool repeated = false;               ///< a repeat was asked for: the next reply may be one that we have
  bool clean = false;                  ///< nothing of an abandoned request can be in it
  bool talkative = false;              ///< answers came that nobody had asked for: it may hold one at any time
  std::vector<Emergency> emergencies;  ///< that came in and were not fetched yet; the oldest kMostEmergencies
  static constexpr std::size_t kMostEmergencies = 64;
};

/// An object of the profile's mapping that no PDO of the station carries: SDO does.
struct SlowObject {
  config::ObjectAddress address;  ///< in the profile's mapping
  config::ObjectAddress by;       ///< what SDO reads or writes: 6060h, where there is no 6061h
  std::uint8_t bits = 0;
  bool output = false, has_sign = false;
  bool is_mode = false;  ///< 6060h: CSP is set before anything else
};

/// An output of a station's own mapping that is not in the profile's: it is sent in every cycle, too.
struct ForeignOutput {
  std::size_t bit = 0;  ///< first one, of the station's outputs
  std::uint8_t bits = 0;
  std::uint64_t value = 0;  ///< what the object held when the station was brought up
};

/// What of a direction's mapping a station does not let be written.
struct FixedMapping {
  bool assignment = false, mapping = false;  ///< 1C12h or 1C13h; 16xxh or 1Axxh
};

/// How a station's clock makes its pulses, as 0980h and the registers behind it are written.
struct SyncPulses {
  std::uint16_t activate = 0x0300;        ///< 0980h and 0981h: SYNC0
  std::uint32_t cycle0_ns = 0;            ///< 0: that of the bus
  std::int32_t factor0 = 1, factor1 = 0;  ///< of the bus cycle; negative: parts of it
  std::int32_t shift0_ns = 0, shift1_ns = 0;
};

/// A start-up row that was written, and held another value when it was read back: written again it would wear the
/// station's EEPROM, and change nothing before its next power-up.
struct IgnoredWrite {
  config::ObjectAddress address;
  std::int64_t written = 0, read_back = 0;
};

struct StationRecord : BusStation {
  std::string title;  ///< "HCFA AMD530B"
  int position = 0;
  std::uint16_t address = 0;  ///< configured station address, 1001h + position

  // found
  StationSii sii;
  bool sii_whole = false;  ///< with its categories
  EscFacts esc;
  bool eeprom_given = false;  ///< 0500h: its processor has the EEPROM
  std::uint16_t alias = 0;
  std::uint32_t mailbox_repeats = 0;  ///< replies that were asked for once more, and requests that were sent again
  bool restarted =
      false;  ///< since it went away it was found without its address: it has lost its supply, or was reset
  Ports ports;
  int parent = -1;       ///< position of the station before it; -1: the master
  int parent_port = -1;  ///< the parent's port that leads here

  // written in INIT, before PRE_OP
  std::vector<SyncManagerPlan> sync_managers;  ///< by number; those of process data are written in PRE_OP
  // written by SDO in PRE_OP
  std::vector<config::StartupRow> startup;
  std::vector<IgnoredWrite> ignored;             ///< since its power-up
  std::vector<config::PdoRow> rx_pdos, tx_pdos;  ///< the station's outputs (to it) and inputs (from it)
  /// SyncManager of each of these PDOs, by its number; empty: all in the first of their kind.
  std::vector<std::uint8_t> rx_sync_managers, tx_sync_managers;
  bool writes_mapping = false;  ///< 1C12h, 1C13h, 16xxh, 1Axxh are ours to write
  // What the station has made of that (pdo_agreement.hpp).
  bool bent = false;  ///< its mapping is another than the profile's
  FixedMapping outputs_fixed, inputs_fixed;
  std::vector<SlowObject> slow;
  std::vector<ForeignOutput> foreign_outputs;
  std::vector<config::ObjectAddress> left_out;  ///< of the profile's mapping
  int max_pdo_entries = 0, max_pdo_bytes = 0;   ///< 0: not stated
  // written in PRE_OP, before SAFE_OP
  std::vector<wire::Fmmu> fmmus;
  std::uint16_t watchdog_ms = 0;
  bool dc = false;                ///< takes part in distributed clocks
  bool sync0 = false;             ///< and gets SYNC0
  std::uint32_t dc_delay_ns = 0;  ///< from the reference clock
  SyncPulses sync;

  // its part of a cycle
  std::size_t output_offset = 0, output_bytes = 0;  ///< in the image of all stations
  std::size_t input_offset = 0, input_bytes = 0;
  std::uint32_t logical = 0;     ///< first address of its region in the logical map
  std::size_t region_bytes = 0;  ///< of it
  std::size_t input_at = 0;      ///< where the inputs begin in it
  bool lrw = true;               ///< takes LRW; otherwise LWR and LRD

  MailboxState mailbox;

  [[nodiscard]] FixedMapping& fixed(bool outputs) { return outputs ? outputs_fixed : inputs_fixed; }
  [[nodiscard]] bool has_mailbox() const;
  [[nodiscard]] bool has_coe() const;
};

/// First sync manager of a kind, by number; nullptr when the station has none.
const wire::SyncManager* find_sync_manager(const StationRecord& station, config::SyncManagerKind kind, int* number);

/// Object that says which PDOs a direction has: 1C10h and the number of its SyncManager.
std::uint16_t pdo_assignment(const StationRecord& station, bool outputs);

/// Fills in what the profile says. Where mailboxes and process data lie, and how clocks are activated, the station's
/// EEPROM says better, where it does.
void plan_from_profile(StationRecord& station, const config::StationProfile& profile);
/// Fills in what the station's own EEPROM says (read whole).
void plan_from_sii(StationRecord& station);

}  // namespace gantry::devices
