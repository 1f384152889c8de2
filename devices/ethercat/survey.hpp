// A segment as it is, asked without a machine file: what tools show. Works on any FramePort, real or virtual.
//   Survey survey(port, clock);
//   auto stations = survey.scan();                   // identity, names, ports, parents, AL state; changes no state
//   auto pdos = survey.read_pdo_map(3);              // stations are named by their position, 0 first
//   auto value = survey.read_object(3, {0x1018, 0}, SdoAccess::Complete);
// Scanning gives every station its configured address (1001h + position), ends alias addressing and takes the EEPROM
// for as long as it reads; nothing else is written. A station that had no address has none again when the survey ends,
// so that the machine's next start still knows that its supply was off. Object access needs a mailbox: a station in
// INIT is taken to PRE_OP for it and stays there. Every call ends in bounded time with a named error. Not beside a
// running EthercatMaster: that one answers the same questions itself.
#pragma once
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "config/machine.hpp"
#include "core/clock.hpp"
#include "core/error.hpp"
#include "devices/ethercat/diagnosis.hpp"
#include "devices/ethercat/link.hpp"
#include "devices/ethercat/parameters.hpp"
#include "devices/ethercat/sdo.hpp"
#include "devices/ethercat/sdo_info.hpp"
#include "devices/ethercat/states.hpp"
#include "devices/ethercat/station.hpp"

namespace gantry::devices {

struct FoundStation {
  StationRecord record;  ///< position, address, alias, esc, ports, parent and parent_port, sii (whole)
  AlStatus al;
  [[nodiscard]] const std::string& name() const { return record.sii.name.empty() ? record.sii.order : record.sii.name; }
};

struct MappedPdo {
  std::uint16_t index = 0;
  std::uint8_t sync_manager = 0;
  bool outputs = false;  ///< to the station
  std::string name;      ///< as the EEPROM has it
  std::vector<config::PdoEntry> entries;
  [[nodiscard]] std::size_t bits() const;
};
/// What a station exchanges, in the order in which it lies in its SyncManagers.
struct PdoMap {
  std::vector<MappedPdo> pdos;
  bool from_objects = false;  ///< read from 1C1xh; otherwise the EEPROM's defaults
};

/// What became of a survey's frames, each counted as what it was.
struct WireCheck {
  CyclicCounts frames;                         ///< working counters: of reads that every station answers
  std::vector<std::uint32_t> mailbox_repeats;  ///< by position: what had to be asked for once more
  std::optional<OtherMaster> other_master;     ///< whose frames came in
};

class Survey {
 public:
  Survey(FramePort& port, Clock& clock) : link_(port, clock) {}
  ~Survey() { give_back(); }
  Survey(const Survey&) = delete;
  Survey& operator=(const Survey&) = delete;

  /// Fault::BusDown when nobody answers, StationMissing. A station whose EEPROM cannot be read or parsed is listed
  /// with what could be read, and record.sii.damage.
  Result<std::vector<FoundStation>> scan();

  Result<PdoMap> read_pdo_map(int position);
  Result<std::vector<ObjectDescription>> object_list(int position, bool with_entries = false);
  Result<EntryDescription> describe_entry(int position, config::ObjectAddress object);
  Result<Bytes> read_object(int position, config::ObjectAddress object, SdoAccess access = SdoAccess::Single);
  Result<void> write_object(int position, config::ObjectAddress object, std::span<const std::byte> value,
                            SdoAccess access = SdoAccess::Single);
  /// What 1018h says (identity_object.hpp); nothing of a station without CoE.
  Result<config::ObjectIdentity> read_identity_object(int position);
  /// Whether a start would take it for this station: by its EEPROM, its alias, and its firmware.
  /// Fault::IdentityMismatch.
  Result<void> confirm(int position, const config::Machine& machine, const config::Station& station);
  /// The start-up rows that a start asks of this station there: those that it may do without and does not have are left
  /// out, with a note.
  Result<std::vector<config::StartupRow>> asked_of(int position, const config::Station& station,
                                                   std::vector<std::string>& notes);
  /// Parameters; devices/ethercat/parameters.hpp.
  Result<HeldObject> read_held(int position, const config::StartupRow& row);
  /// Before a value that acts at power-up is written: what is known of an earlier restart of the station says nothing
  /// any more. It keeps its address, and is seen to have restarted when it has lost that.
  Result<void> forget_restart(int position);
  Result<void> write_held(int position, const config::StartupRow& row, std::size_t bytes);
  Result<void> save_parameters(int position, const config::StationProfile& profile,
                               std::span<const config::ObjectAddress> written);
  Result<AlStatus> al_status(int position);
  /// Of all stations, by position.
  Result<std::vector<ErrorCounters>> error_counters();
  Result<std::vector<DcStatus>> dc_status();
  /// Sends `frames` reads of all AL states, and where a mailbox is open some of 1000h; nothing is changed. With them,
  /// every frame of this survey is counted. Bounded: 20 ms for a frame that is lost.
  Result<WireCheck> check_wire(int frames);
  /// Emergencies that came in while objects were read.
  std::vector<Emergency> take_emergencies(int position);

 private:
  void give_back();
  Result<StationRecord*> station(int position);
  Result<StationRecord*> with_mailbox(int position);

  Link link_;
  std::vector<StationRecord> stations_;  ///< by position; empty until the first scan
};

/// One mapping object (16xxh, 1Axxh), and one SyncManager's assignment (1C10h and its number) with the mapping of each
/// PDO; added to `map`.
Result<void> read_mapping(Link& link, StationRecord& station, std::uint16_t index, PdoMap& map);
Result<void> read_assigned(Link& link, StationRecord& station, std::uint8_t sync_manager, bool outputs, PdoMap& map);
/// The PDO map of a station with an open mailbox (or of its EEPROM, where it has no CoE).
Result<PdoMap> read_pdo_map(Link& link, StationRecord& station);

}  // namespace gantry::devices
