// What the project knows of a drive or of any other station: cited data rows from config/drives/*.yaml and
// config/devices/*.yaml. The master brings stations up from them and the virtual stations behave by them; neither holds
// a drive's number in code. What no manual states is marked `assumed`: `check` lists it, `commission` confirms it, docs
// never tell it as a fact.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/error.hpp"

namespace gantry::config {

enum class BusKind { EtherCat, CanOpen };

enum class ObjectType : std::uint8_t { Bool, I8, U8, I16, U16, I32, U32, String };
/// Bits on the wire; 0 for String.
int bits(ObjectType type);
constexpr bool is_signed(ObjectType type) noexcept {
  return type == ObjectType::I8 || type == ObjectType::I16 || type == ObjectType::I32;
}

/// index:sub of the CoE or CANopen object dictionary.
struct ObjectAddress {
  std::uint16_t index = 0;
  std::uint8_t sub = 0;
  constexpr auto operator<=>(const ObjectAddress&) const = default;
};
/// As people write it: "605Ah", "2190h:1".
std::string to_text(ObjectAddress address);

struct ObjectRow {
  ObjectAddress address;  ///< of the station's first axis; see StationProfile::slot_stride
  std::string name;
  ObjectType type = ObjectType::U16;
  bool readable = true, writable = false;
  bool mappable = true;  ///< may stand in a PDO
  std::optional<std::int64_t> initial, min, max;
  std::string unit;     ///< the vendor's: "pulse", "P/S", "rpm"
  std::string section;  ///< where the manual says so; may be empty when assumed
  bool assumed = false;
};

/// One PDO: its mapping object (1600h.., 1A00h..) and what is mapped, in order.
struct PdoEntry {
  ObjectAddress address;  ///< as it goes over the wire: a slot's stride is already in it
  std::uint8_t bit_length = 0;
};
struct PdoRow {
  std::uint16_t index = 0;
  int slot = 0;  ///< axis within the station that it serves
  std::vector<PdoEntry> entries;
};

enum class SyncManagerKind : std::uint8_t { MailboxOut = 1, MailboxIn = 2, ProcessOut = 3, ProcessIn = 4 };
struct SyncManagerRow {
  SyncManagerKind kind{};
  std::uint16_t start = 0;   ///< physical address in the ESC
  std::uint16_t length = 0;  ///< bytes; of process data it is computed from the PDOs
};

/// When a written value acts.
enum class ActsAt : std::uint8_t {
  Once,
  Standstill,  ///< without torque; so it is whenever start-up writes
  PowerUp,     ///< when the supply comes the next time: start-up compares only, `gantry commission` writes and saves
};
enum class ParameterRule : std::uint8_t {
  Write,
  MustEqual,  ///< never written: a fact of the hardware (motor type), which the station must know already
};
/// An object that holds a value before the station may have torque. In PRE_OP it is read, compared, written where it
/// differs and may be written, and read back; 2xxxh objects of some drives wear an EEPROM with every write.
struct StartupRow {
  ObjectAddress address;  ///< as it goes over the wire: a slot's stride is already in it
  ObjectType type = ObjectType::U16;
  std::int64_t value = 0;
  std::string why;
  std::string name{};  ///< by which the machine file calls it: "run_current"
  ParameterRule rule = ParameterRule::Write;
  ActsAt acts = ActsAt::Once;
  bool declared = false;  ///< the machine file vouches for a value that the station does not show
};

/// A parameter of a drive as its profile has it; machine files state other values under `stations.NAME.parameters`.
struct Parameter {
  std::string name;
  ObjectAddress address;  ///< of the first axis; it stands in every slot
  ObjectType type = ObjectType::U16;
  std::optional<std::int64_t> value;  ///< none: only what the machine file states is written
  bool must_be_stated = false;        ///< by the machine file: a wrong one burns a motor
  std::string unit;                   ///< in which a machine file writes it: "A"; empty: a whole number
  double per_unit = 1;                ///< of the object's value
  ParameterRule rule = ParameterRule::Write;
  ActsAt acts = ActsAt::Once;
  bool assumed = false;  ///< no manual says when it acts, or where it is
  std::string why;
};

enum class DriveErrorKind { Fault, Warning, EmergencyInput, Limit, Undervoltage, PowerCycle };
struct DriveErrorRow {
  std::uint32_t code = 0;  ///< as it stands in 603Fh
  DriveErrorKind kind = DriveErrorKind::Fault;
  std::string text;
  std::string remedy;
  std::string section;  ///< empty: assumed
};

/// A bit of an alarm word of the vendor's (AMD530B: 213Fh), which names a cause more narrowly than 603Fh. Nothing reads
/// the word in the loop; `gantry explain` knows its bits.
struct AlarmBitRow {
  ObjectAddress address;
  int bit = 0;
  std::uint32_t code = 0;  ///< 603Fh that stands beside it; 0: the manual states none
  std::string text;
  std::string remedy;
  std::string section;  ///< empty: assumed
};

/// What the virtual drive answers in 6041h in a mode (bits above the CiA 402 state), from the manual's table of typical
/// values.
struct StatuswordRow {
  std::int8_t mode = 8;
  std::uint16_t ready = 0x0231, switched_on = 0x0233, enabled = 0x0237, running = 0x0237, reached = 0x0637,
                fault = 0x0238;
};

/// What becomes of a 2xxxh value that was written by SDO when the supply goes.
enum class Storage : std::uint8_t {
  None,    ///< it is lost
  AtOnce,  ///< every write is kept
  OnSave,  ///< kept when "save" is written to 1010h
};

struct Identity {
  std::uint32_t vendor = 0, product = 0, revision = 0;
  bool assumed = true;  ///< no manual states it: it counts until `gantry commission --accept` has taken what was found
};

/// The parameter that gives an input to probe 1, and the value that does; empty where the input has no other function.
struct ProbeInput {
  std::string parameter;
  std::int64_t value = 0;
};

/// Facts of one axis of a drive, alike for all its slots.
struct DriveFacts {
  bool closed_loop = false;                   ///< false: 6064h is the command, following error is not available
  std::vector<std::int8_t> modes;             ///< values of 6060h that work
  std::vector<std::uint32_t> cycle_times_us;  ///< SYNC cycles the manual lists
  std::vector<std::int8_t> homing_methods;
  std::uint32_t counts_per_rev = 10000;  ///< command pulses per revolution as configured by `parameters`
  double velocity_counts_s = 1;          ///< counts/s in one unit of 6081h, 6099h, 606Ch (vendors differ: P/S, rpm)
  double acceleration_counts_s2 = 1;     ///< counts/s^2 in one unit of 6083h, 6084h, 609Ah
  std::uint32_t quick_stop_options = 0;  ///< bit n: value n of 605Ah is documented; 0: unknown or absent
  std::uint32_t quick_stop_coasts = 0;   ///< bit n: by the manual, value n takes the torque and brakes nothing
  std::int8_t input_neg_limit = -1, input_pos_limit = -1, input_home = -1;  ///< bit in 60FDh; -1: must be configured
  /// Bits of 6041h by the manual, -1: not stated. In CSP, that the drive follows its targets; that a limit is active.
  std::int8_t status_follows = -1, status_limit = -1;
  std::int8_t probe_level_bit = 6;  ///< bit of 60B9h that shows probe 1's level
  /// AMD530B: 60B8h = 0, then the value again; the others take a new edge of bit 0. The loop does both with every
  /// drive; the virtual one heeds it.
  bool probe_rearm_needs_zero = false;
  ProbeInput probe_input;                   ///< without that value the drive latches nothing
  bool probe_takes_emergency_stop = false;  ///< AMD530B: probe 1 can be DI4 alone, which is its emergency stop
  /// AMD530B with 605Ah 5..7: see manual 8.4. The loop leads every drive out through 0000h; the virtual one heeds it.
  bool quick_stop_needs_toggle = false;
  /// What 603Fh of the virtual drive shows in these cases; 0: nothing is stated.
  std::uint16_t deviation_code = 0, bus_loss_code = 0, homing_code = 0;
  std::vector<StatuswordRow> statuswords;
  std::vector<DriveErrorRow> errors;
  std::vector<AlarmBitRow> alarm_bits;
};

/// A terminal of an I/O station by the name that is printed on it: where its value lies in the process image.
struct Terminal {
  std::string name;
  bool output = false;
  int bit = 0;   ///< its first, of the station's outputs or inputs
  int bits = 1;  ///< width of its value; an analogue terminal has more than one
};

struct StationProfile {
  std::string name;    ///< file name without .yaml: "amd530b"
  std::string title;   ///< "HCFA AMD530B"
  std::string manual;  ///< "AMD530B manual" with version
  BusKind bus = BusKind::EtherCat;
  Identity identity;
  int slots = 1;                             ///< axes of the station; 0 for I/O
  std::uint16_t slot_stride = 0x800;         ///< added to 6xxx per slot (STD402EC 10.1)
  std::uint16_t slot_stride_vendor = 0x200;  ///< added to 2xxx per slot
  std::vector<SyncManagerRow> sync_managers;
  std::vector<PdoRow> rx_pdos, tx_pdos;  ///< what we map: station's outputs (to it) and inputs (from it)
  int max_pdo_entries = 8;               ///< per PDO; 0: not stated
  int max_pdo_bytes = 32;
  bool pdo_fixed = false;  ///< I/O stations: mapping is not written
  std::vector<Terminal> terminals;
  std::vector<ObjectRow> objects;
  std::vector<Parameter> parameters;    ///< as the file has them, in order
  std::vector<StartupRow> startup;      ///< of one station: what its parameters and its machine file ask of it
  std::vector<std::string> not_stated;  ///< parameters that the machine file must state and does not
  std::vector<std::string> declared;    ///< names of rows that the station does not have: the machine file vouches
  Storage storage = Storage::None;
  std::optional<DriveFacts> drive;       ///< absent for stations that are no drive
  bool dc = true;                        ///< supports SYNC0
  int clock_bits = 64;                   ///< width of its ESC's times: 32 or 64
  std::uint16_t watchdog_ms = 100;       ///< process-data watchdog that we set
  std::vector<std::string> assumptions;  ///< sentences for `check`
  std::string file, sha256;              ///< where it was read from, and of those bytes
};

/// The object of the first axis that `address` of slot `slot` stands for (6864h of slot 1 -> 6064h).
ObjectAddress first_slot(const StationProfile& profile, ObjectAddress address, int slot);
/// The same object of another slot: 6064h -> 6864h.
ObjectAddress in_slot(const StationProfile& profile, ObjectAddress address, int slot);
const ObjectRow* find_object(const StationProfile& profile, ObjectAddress address_of_first_slot);

/// Bits of all outputs to the station, or of all inputs from it, one behind the other.
int image_bits(const StationProfile& profile, bool outputs);

/// Reads config/drives/*.yaml or config/devices/*.yaml; the profile's name is the file's.
Checked<StationProfile> load_profile(const std::string& path);

/// Where profiles lie that a machine file names: drives/ or devices/ beside its folder.
std::string profiles_beside(const std::string& machine_folder, const char* kind);

}  // namespace gantry::config
