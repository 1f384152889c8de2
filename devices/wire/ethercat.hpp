// What EtherCAT puts on the wire: frame and datagram layout (ETG.1000.4), ESC registers (ETG.1000.4, Beckhoff ESC data
// sheet section II), application-layer states and their status codes (ETG.1000.6, ETG.1020). Constants and layouts
// only, shared by the master and by the virtual segment, which share nothing else.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "devices/wire/bytes.hpp"

namespace gantry::devices::wire {

// --- Frame: Ethernet header (14), EtherCAT header (2), datagrams
// ------------------------------------------------------

inline constexpr std::uint16_t kEtherType = 0x88A4;  ///< big-endian on the wire, at offset 12
inline constexpr std::size_t kEthernetHeader = 14;
inline constexpr std::size_t kEtherCatHeader = 2;  ///< bits 0..10 length, 12..15 type
inline constexpr std::size_t kFrameHeader = kEthernetHeader + kEtherCatHeader;
inline constexpr std::uint16_t kTypeDatagrams = 1;    ///< EtherCAT header: type 1, "EtherCAT command"
inline constexpr std::size_t kMinEthernetFrame = 60;  ///< without FCS; shorter ones are padded
inline constexpr std::uint8_t kProcessedMacBit =
    0x02;  ///< the first station sets it in the first byte of the source MAC

/// Datagram: header (10), data, working counter (2).
///   0 command, 1 index, 2 ADP, 4 ADO (or 2 logical address, 32 bit), 6 length | C | M, 8 IRQ
inline constexpr std::size_t kDatagramHeader = 10;
inline constexpr std::size_t kWorkingCounter = 2;
inline constexpr std::uint16_t kLengthMask = 0x07FF;
inline constexpr std::uint16_t kCirculating = 0x4000;  ///< this datagram has gone round once
inline constexpr std::uint16_t kMoreFollow = 0x8000;
inline constexpr std::size_t kMaxDatagramData = 1486;  ///< 1500 - 2 - 12

enum class Command : std::uint8_t {
  Nop = 0,
  Aprd = 1,  ///< by position: the station that sees ADP = 0 acts, each one adds 1
  Apwr = 2,
  Aprw = 3,
  Fprd = 4,  ///< by configured station address
  Fpwr = 5,
  Fprw = 6,
  Brd = 7,  ///< every station; reads are OR-ed into the data
  Bwr = 8,
  Brw = 9,
  Lrd = 10,  ///< by logical address through the FMMUs
  Lwr = 11,
  Lrw = 12,
  Armw = 13,  ///< one station reads, all others write
  Frmw = 14,
};

/// Working counter increments (ETG.1000.4, 5.4): read 1, write 1, read-write 1 + 2.
inline constexpr std::uint16_t kWkcRead = 1, kWkcWrite = 1, kWkcReadWriteRead = 1, kWkcReadWriteWrite = 2;

struct DatagramHeader {
  Command command = Command::Nop;
  std::uint8_t index = 0;
  std::uint32_t address = 0;  ///< ADP in the low half, ADO in the high half; or the logical address
  std::uint16_t length = 0;
  bool circulating = false, more = false;
  std::uint16_t irq = 0;

  [[nodiscard]] constexpr std::uint16_t adp() const noexcept { return static_cast<std::uint16_t>(address & 0xFFFF); }
  [[nodiscard]] constexpr std::uint16_t ado() const noexcept { return static_cast<std::uint16_t>(address >> 16); }
};

constexpr std::uint32_t physical_address(std::uint16_t adp, std::uint16_t ado) noexcept {
  return static_cast<std::uint32_t>(ado) << 16 | adp;
}
/// ADP of the station at `position` (0 first): stations count up, the one that sees 0 acts.
constexpr std::uint16_t auto_increment(int position) noexcept { return static_cast<std::uint16_t>(-position); }

constexpr DatagramHeader get_datagram_header(std::span<const std::byte> bytes) noexcept {
  DatagramHeader h;
  h.command = static_cast<Command>(get_le<std::uint8_t>(bytes, 0));
  h.index = get_le<std::uint8_t>(bytes, 1);
  h.address = get_le<std::uint32_t>(bytes, 2);
  const auto length = get_le<std::uint16_t>(bytes, 6);
  h.length = length & kLengthMask;
  h.circulating = (length & kCirculating) != 0;
  h.more = (length & kMoreFollow) != 0;
  h.irq = get_le<std::uint16_t>(bytes, 8);
  return h;
}
constexpr void put_datagram_header(std::span<std::byte> bytes, const DatagramHeader& h) noexcept {
  put_le<std::uint8_t>(bytes, 0, static_cast<std::uint8_t>(h.command));
  put_le<std::uint8_t>(bytes, 1, h.index);
  put_le<std::uint32_t>(bytes, 2, h.address);
  put_le<std::uint16_t>(bytes, 6,
                        static_cast<std::uint16_t>((h.length & kLengthMask) | (h.circulating ? kCirculating : 0) |
                                                   (h.more ? kMoreFollow : 0)));
  put_le<std::uint16_t>(bytes, 8, h.irq);
}

// --- ESC registers
// ----------------------------------------------------------------------------------------------------

namespace reg {
inline constexpr std::uint16_t kType = 0x0000, kRevision = 0x0001, kBuild = 0x0002, kFmmuCount = 0x0004,
                               kSyncManagerCount = 0x0005, kRamKilobytes = 0x0006, kPortDescriptor = 0x0007,
                               kFeatures = 0x0008;
inline constexpr std::uint16_t kStationAddress = 0x0010, kStationAlias = 0x0012;
inline constexpr std::uint16_t kDlControl = 0x0100, kDlStatus = 0x0110;
inline constexpr std::uint16_t kAlControl = 0x0120, kAlStatus = 0x0130, kAlStatusCode = 0x0134;
inline constexpr std::uint16_t kRxErrorCounters = 0x0300;         ///< 2 bytes a port: invalid frames, RX errors
inline constexpr std::uint16_t kForwardedErrorCounters = 0x0308;  ///< 1 byte a port
inline constexpr std::uint16_t kProcessingUnitErrors = 0x030C, kPdiErrors = 0x030D;
inline constexpr std::uint16_t kLostLinkCounters = 0x0310;  ///< 1 byte a port
inline constexpr std::size_t kErrorCounterBytes = 0x14;     ///< all of them, from 0300h
inline constexpr std::uint16_t kWatchdogDivider = 0x0400;   ///< (value + 2) * 40 ns is the watchdog's unit
inline constexpr std::uint16_t kWatchdogTimePdi = 0x0410, kWatchdogTimeProcessData = 0x0420;  ///< in that unit; 0: off
inline constexpr std::uint16_t kWatchdogStatusProcessData = 0x0440;  ///< bit 0: 1 alive, 0 expired
inline constexpr std::uint16_t kWatchdogCounterProcessData = 0x0442;
inline constexpr std::uint16_t kSiiConfig = 0x0500, kSiiPdiAccess = 0x0501, kSiiControl = 0x0502, kSiiAddress = 0x0504,
                               kSiiData = 0x0508;
inline constexpr std::uint16_t kFmmu0 = 0x0600;
inline constexpr std::uint16_t kSyncManager0 = 0x0800;
inline constexpr std::uint16_t kDcReceiveTimePort0 = 0x0900;  ///< 4 bytes a port; a write latches all of them
inline constexpr std::uint16_t kDcSystemTime = 0x0910, kDcReceiveTimeUnit = 0x0918, kDcSystemTimeOffset = 0x0920,
                               kDcSystemTimeDelay = 0x0928, kDcSystemTimeDifference = 0x092C,
                               kDcSpeedCounterStart = 0x0930;
inline constexpr std::uint16_t kDcCyclicUnitControl = 0x0980, kDcActivation = 0x0981, kDcPulseLength = 0x0982,
                               kDcStartTime = 0x0990, kDcSync0Cycle = 0x09A0, kDcSync1Cycle = 0x09A4;
inline constexpr std::uint16_t kProcessRam = 0x1000;
}  // namespace reg

// kFeatures
inline constexpr std::uint16_t kFeatureDc = 0x0004, kFeatureDc64 = 0x0008, kFeatureNoLrw = 0x0200,
                               kFeatureNoReadWrite = 0x0400, kFeatureFixedMapping = 0x0800;
// kPortDescriptor: two bits a port
enum class PortKind : std::uint8_t { Absent = 0, NotConfigured = 1, Ebus = 2, Mii = 3 };
constexpr PortKind port_kind(std::uint8_t descriptor, int port) noexcept {
  return static_cast<PortKind>(descriptor >> (2 * port) & 3);
}
inline constexpr int kPorts = 4;
// kDlStatus
constexpr bool dl_communicates(std::uint16_t dl_status, int port) noexcept {
  return (dl_status >> (9 + 2 * port) & 1) != 0;
}
constexpr bool dl_link(std::uint16_t dl_status, int port) noexcept { return (dl_status >> (4 + port) & 1) != 0; }
constexpr bool dl_loop_closed(std::uint16_t dl_status, int port) noexcept {
  return (dl_status >> (8 + 2 * port) & 1) != 0;
}
// kWatchdogDivider
inline constexpr std::uint16_t kWatchdogDivider100us = 2498;  ///< power-on value: a unit of 100 us
// kDcActivation
inline constexpr std::uint8_t kDcActivateCyclic = 0x01, kDcActivateSync0 = 0x02, kDcActivateSync1 = 0x04;
// kDcSystemTimeDifference: sign (bit 31) and magnitude of local minus received time, filtered by the ESC
constexpr std::int32_t dc_difference_ns(std::uint32_t raw) noexcept {
  const auto magnitude = static_cast<std::int32_t>(raw & 0x7FFFFFFFu);
  return (raw & 0x80000000u) != 0 ? -magnitude : magnitude;
}

// kSiiControl (16 bit): 0 write enable, 6 eight bytes a read, 8 read, 9 write, 10 reload, 11 checksum error, 12 not
// loaded, 13 no acknowledge, 14 write not enabled, 15 busy
// kSiiConfig: who has the EEPROM; taking it away is a pulse
inline constexpr std::uint8_t kSiiToStation = 0x01, kSiiTakeAway = 0x02;
inline constexpr std::uint16_t kSiiWriteEnable = 0x0001, kSiiReads8 = 0x0040, kSiiRead = 0x0100, kSiiWrite = 0x0200,
                               kSiiReload = 0x0400, kSiiChecksumError = 0x0800, kSiiNotLoaded = 0x1000,
                               kSiiNoAcknowledge = 0x2000, kSiiWriteDenied = 0x4000, kSiiBusy = 0x8000,
                               kSiiErrors = 0x7800;

// --- FMMU (16 bytes each from 0600h)
// ----------------------------------------------------------------------------------

inline constexpr std::size_t kFmmuBytes = 16;
enum class FmmuType : std::uint8_t { Read = 1, Write = 2 };
struct Fmmu {
  std::uint32_t logical_start = 0;
  std::uint16_t length = 0;
  std::uint8_t logical_start_bit = 0, logical_stop_bit = 7;
  std::uint16_t physical_start = 0;
  std::uint8_t physical_start_bit = 0;
  std::uint8_t type = 0;  ///< FmmuType bits
  bool active = false;
};
constexpr std::array<std::byte, kFmmuBytes> to_bytes(const Fmmu& f) noexcept {
  std::array<std::byte, kFmmuBytes> b{};
  put_le<std::uint32_t>(b, 0, f.logical_start);
  put_le<std::uint16_t>(b, 4, f.length);
  put_le<std::uint8_t>(b, 6, f.logical_start_bit);
  put_le<std::uint8_t>(b, 7, f.logical_stop_bit);
  put_le<std::uint16_t>(b, 8, f.physical_start);
  put_le<std::uint8_t>(b, 10, f.physical_start_bit);
  put_le<std::uint8_t>(b, 11, f.type);
  put_le<std::uint8_t>(b, 12, f.active ? 1 : 0);
  return b;
}
constexpr Fmmu get_fmmu(std::span<const std::byte> b) noexcept {
  return {get_le<std::uint32_t>(b, 0), get_le<std::uint16_t>(b, 4),           get_le<std::uint8_t>(b, 6),
          get_le<std::uint8_t>(b, 7),  get_le<std::uint16_t>(b, 8),           get_le<std::uint8_t>(b, 10),
          get_le<std::uint8_t>(b, 11), (get_le<std::uint8_t>(b, 12) & 1) != 0};
}

// --- SyncManager (8 bytes each from 0800h)
// ----------------------------------------------------------------------------

inline constexpr std::size_t kSyncManagerBytes = 8;
inline constexpr std::size_t kSmControlOffset = 4, kSmStatusOffset = 5, kSmPdiControlOffset = 7;
// Control byte: bits 0-1 buffer (0 three buffers, 2 mailbox), 2-3 direction (0 ECAT reads, 1 ECAT writes), 5 PDI
// interrupt, 6 watchdog trigger. Values as ESI files carry them.
inline constexpr std::uint8_t kSmControlMailboxOut = 0x26, kSmControlMailboxIn = 0x22, kSmControlOutputs = 0x64,
                              kSmControlInputs = 0x20;
inline constexpr std::uint8_t kSmBufferMask = 0x03, kSmMailboxMode = 0x02, kSmEcatWrites = 0x04,
                              kSmWatchdogTrigger = 0x40;
inline constexpr std::uint8_t kSmStatusMailboxFull = 0x08;
inline constexpr std::uint8_t kSmActivateEnable = 0x01, kSmActivateRepeatRequest = 0x02;
inline constexpr std::uint8_t kSmPdiRepeatAck = 0x02;
struct SyncManager {
  std::uint16_t start = 0, length = 0;
  std::uint8_t control = 0, status = 0, activate = 0, pdi_control = 0;
};
constexpr std::array<std::byte, kSyncManagerBytes> to_bytes(const SyncManager& s) noexcept {
  std::array<std::byte, kSyncManagerBytes> b{};
  put_le<std::uint16_t>(b, 0, s.start);
  put_le<std::uint16_t>(b, 2, s.length);
  put_le<std::uint8_t>(b, 4, s.control);
  put_le<std::uint8_t>(b, 5, s.status);
  put_le<std::uint8_t>(b, 6, s.activate);
  put_le<std::uint8_t>(b, 7, s.pdi_control);
  return b;
}
constexpr SyncManager get_sync_manager(std::span<const std::byte> b) noexcept {
  return {get_le<std::uint16_t>(b, 0), get_le<std::uint16_t>(b, 2), get_le<std::uint8_t>(b, 4),
          get_le<std::uint8_t>(b, 5),  get_le<std::uint8_t>(b, 6),  get_le<std::uint8_t>(b, 7)};
}

// --- Application layer
// ------------------------------------------------------------------------------------------------

enum class AlState : std::uint8_t { None = 0, Init = 1, PreOp = 2, Boot = 3, SafeOp = 4, Op = 8 };
inline constexpr std::uint16_t kAlStateMask = 0x000F;
inline constexpr std::uint16_t kAlError = 0x0010;  ///< AL status: error; AL control: acknowledge
/// Of the AL states of all stations OR-ed (BRD 0130h): everybody is in OP, and nobody shows an error. What stands above
/// these bits is an application's own (ETG.1000.6, AL status), and an identification (ETG.1020).
constexpr bool all_in_op(std::uint16_t al_states) noexcept {
  return (al_states & (kAlStateMask | kAlError)) == static_cast<std::uint16_t>(AlState::Op);
}

constexpr std::string_view name(AlState s) noexcept {
  switch (s) {
    case AlState::Init: return "INIT";
    case AlState::PreOp: return "PRE_OP";
    case AlState::Boot: return "BOOT";
    case AlState::SafeOp: return "SAFE_OP";
    case AlState::Op: return "OP";
    case AlState::None: break;
  }
  return "unknown state";
}

struct AlStatusText {
  std::uint16_t code;
  std::string_view text;
};
/// ETG.1000.6 table 11 and ETG.1020.
inline constexpr std::array kAlStatusCodes{
    AlStatusText{0x0000, "no error"},
    AlStatusText{0x0001, "unspecified error"},
    AlStatusText{0x0002, "no memory"},
    AlStatusText{0x0003, "invalid device setup"},
    AlStatusText{0x0011, "invalid requested state change"},
    AlStatusText{0x0012, "unknown requested state"},
    AlStatusText{0x0013, "bootstrap not supported"},
    AlStatusText{0x0014, "no valid firmware"},
    AlStatusText{0x0015, "invalid mailbox configuration (bootstrap)"},
    AlStatusText{0x0016, "invalid mailbox configuration (PRE_OP)"},
    AlStatusText{0x0017, "invalid SyncManager configuration"},
    AlStatusText{0x0018, "no valid inputs available"},
    AlStatusText{0x0019, "no valid outputs"},
    AlStatusText{0x001A, "synchronisation error"},
    AlStatusText{0x001B, "SyncManager watchdog: outputs came too late or not at all"},
    AlStatusText{0x001C, "invalid SyncManager types"},
    AlStatusText{0x001D, "invalid output configuration"},
    AlStatusText{0x001E, "invalid input configuration"},
    AlStatusText{0x001F, "invalid watchdog configuration"},
    AlStatusText{0x0020, "station needs a cold start"},
    AlStatusText{0x0021, "station needs INIT"},
    AlStatusText{0x0022, "station needs PRE_OP"},
    AlStatusText{0x0023, "station needs SAFE_OP"},
    AlStatusText{0x0024, "invalid input mapping"},
    AlStatusText{0x0025, "invalid output mapping"},
    AlStatusText{0x0026, "inconsistent settings"},
    AlStatusText{0x0027, "free run not supported"},
    AlStatusText{0x0028, "synchronisation not supported"},
    AlStatusText{0x0029, "free run needs three-buffer mode"},
    AlStatusText{0x002A, "background watchdog"},
    AlStatusText{0x002B, "no valid inputs and outputs"},
    AlStatusText{0x002C, "fatal synchronisation error: SYNC0 is missing"},
    AlStatusText{0x002D, "no SYNC0 pulse since the start"},
    AlStatusText{0x002E, "cycle time too small"},
    AlStatusText{0x0030, "invalid DC SYNC configuration"},
    AlStatusText{0x0031, "invalid DC latch configuration"},
    AlStatusText{0x0032, "DC phase-locked loop error"},
    AlStatusText{0x0033, "DC SYNC input/output error"},
    AlStatusText{0x0034, "DC SYNC timeout"},
    AlStatusText{0x0035, "invalid DC SYNC cycle time"},
    AlStatusText{0x0036, "invalid DC SYNC0 cycle time"},
    AlStatusText{0x0037, "invalid DC SYNC1 cycle time"},
    AlStatusText{0x0041, "AoE mailbox error"},
    AlStatusText{0x0042, "EoE mailbox error"},
    AlStatusText{0x0043, "CoE mailbox error"},
    AlStatusText{0x0044, "FoE mailbox error"},
    AlStatusText{0x0045, "SoE mailbox error"},
    AlStatusText{0x004F, "VoE mailbox error"},
    AlStatusText{0x0050, "EEPROM not assigned to the PDI"},
    AlStatusText{0x0051, "EEPROM error"},
    AlStatusText{0x0060, "station restarted locally"},
    AlStatusText{0x0061, "device identification value changed"},
    AlStatusText{0x00F0, "application controller available"},
};
constexpr std::string_view al_status_text(std::uint16_t code) noexcept {
  for (const auto& row : kAlStatusCodes)
    if (row.code == code) return row.text;
  return code >= 0x8000 ? "vendor-specific AL status code" : "unknown AL status code";
}

}  // namespace gantry::devices::wire
