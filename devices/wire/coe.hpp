// Mailbox and CANopen over EtherCAT (ETG.1000.6, 5.6): headers, SDO commands, abort codes as text.
//   mailbox = header (6) + CoE header (2) + SDO (8, or 10 + data)
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "devices/wire/bytes.hpp"

namespace gantry::devices::wire {

// --- Mailbox header: 0 length, 2 address, 4 channel and priority, 5 type (bits 0-3) and counter (bits 4-6)
// ------------

inline constexpr std::size_t kMailboxHeader = 6;
enum class MailboxType : std::uint8_t { Error = 0, Aoe = 1, Eoe = 2, Coe = 3, Foe = 4, Soe = 5, Voe = 15 };
struct MailboxHeader {
  std::uint16_t length = 0;   ///< bytes after this header
  std::uint16_t address = 0;  ///< 0: the master
  std::uint8_t channel_priority = 0;
  MailboxType type = MailboxType::Coe;
  std::uint8_t counter = 0;  ///< 1..7 in turn; 0 is not counted
};
constexpr MailboxHeader get_mailbox_header(std::span<const std::byte> b) noexcept {
  const auto type = get_le<std::uint8_t>(b, 5);
  return {get_le<std::uint16_t>(b, 0), get_le<std::uint16_t>(b, 2), get_le<std::uint8_t>(b, 4),
          static_cast<MailboxType>(type & 0x0F), static_cast<std::uint8_t>(type >> 4 & 0x07)};
}
constexpr void put_mailbox_header(std::span<std::byte> b, const MailboxHeader& h) noexcept {
  put_le<std::uint16_t>(b, 0, h.length);
  put_le<std::uint16_t>(b, 2, h.address);
  put_le<std::uint8_t>(b, 4, h.channel_priority);
  put_le<std::uint8_t>(b, 5,
                       static_cast<std::uint8_t>((static_cast<std::uint8_t>(h.type) & 0x0F) | (h.counter & 0x07) << 4));
}
constexpr std::uint8_t next_counter(std::uint8_t last) noexcept {
  return static_cast<std::uint8_t>(last >= 7 ? 1 : last + 1);
}

// Mailbox error reply: type 1, detail.
enum class MailboxError : std::uint16_t {
  Syntax = 1,
  UnsupportedProtocol = 2,
  InvalidChannel = 3,
  ServiceNotSupported = 4,
  InvalidHeader = 5,
  SizeTooShort = 6,
  NoMoreMemory = 7,
  InvalidSize = 8,
};

// --- CoE header (2): number (bits 0-8), service (bits 12-15)
// ----------------------------------------------------------

inline constexpr std::size_t kCoeHeader = 2;
enum class CoeService : std::uint8_t {
  Emergency = 1,
  SdoRequest = 2,
  SdoResponse = 3,
  TxPdo = 4,
  RxPdo = 5,
  SdoInformation = 8,
};
constexpr CoeService coe_service(std::uint16_t header) noexcept { return static_cast<CoeService>(header >> 12); }
constexpr std::uint16_t coe_header(CoeService service) noexcept {
  return static_cast<std::uint16_t>(static_cast<unsigned>(service) << 12);
}

// --- SDO: 0 command, 1 index, 3 sub, 4 data (expedited) or complete size, 8 data (normal)
// -----------------------------

inline constexpr std::size_t kSdoBytes = 8;
namespace sdo {
// Upper three bits of the command byte.
inline constexpr std::uint8_t kCommandMask = 0xE0;
inline constexpr std::uint8_t kDownloadRequest = 0x20, kDownloadResponse = 0x60, kUploadRequest = 0x40,
                              kUploadResponse = 0x40, kDownloadSegmentRequest = 0x00, kDownloadSegmentResponse = 0x20,
                              kUploadSegmentRequest = 0x60, kUploadSegmentResponse = 0x00, kAbort = 0x80;
// Initiate
inline constexpr std::uint8_t kSizeIndicated = 0x01, kExpedited = 0x02, kCompleteAccess = 0x10;
/// Of an abort only these bits are fixed: stations send 80h as well as 83h.
constexpr bool is_abort(std::uint8_t command) noexcept { return (command & kCommandMask) == kAbort; }
constexpr std::uint8_t expedited_size_bits(std::size_t size) noexcept {
  return static_cast<std::uint8_t>((4 - size) << 2);
}
constexpr std::size_t expedited_size(std::uint8_t command) noexcept { return 4u - (command >> 2 & 3u); }
// Segment
inline constexpr std::uint8_t kLastSegment = 0x01, kToggle = 0x10;
constexpr std::uint8_t segment_size_bits(std::size_t size) noexcept {  // of segments shorter than 7 bytes
  return static_cast<std::uint8_t>(size < 7 ? (7 - size) << 1 : 0);
}
constexpr std::size_t short_segment_size(std::uint8_t command) noexcept { return 7u - (command >> 1 & 7u); }
}  // namespace sdo

struct SdoHeader {
  std::uint8_t command = 0;
  std::uint16_t index = 0;
  std::uint8_t sub = 0;
  std::uint32_t data = 0;  ///< expedited data, complete size, or abort code
};
constexpr SdoHeader get_sdo_header(std::span<const std::byte> b) noexcept {
  return {get_le<std::uint8_t>(b, 0), get_le<std::uint16_t>(b, 1), get_le<std::uint8_t>(b, 3),
          get_le<std::uint32_t>(b, 4)};
}
constexpr void put_sdo_header(std::span<std::byte> b, const SdoHeader& h) noexcept {
  put_le<std::uint8_t>(b, 0, h.command);
  put_le<std::uint16_t>(b, 1, h.index);
  put_le<std::uint8_t>(b, 3, h.sub);
  put_le<std::uint32_t>(b, 4, h.data);
}

// --- Emergency: 0 error code, 2 error register, 3 five bytes of the vendor's
// ------------------------------------------------------------------

inline constexpr std::size_t kEmergencyBytes = 8;

// --- SDO information (ETG.1000.6, 5.6.3): 0 opcode (bit 7: more follow), 2 fragments left, 4 data
// ------------------------------------------------------------------

namespace sdo_info {
inline constexpr std::size_t kHeader = 4;
inline constexpr std::uint8_t kOpcodeMask = 0x7F, kIncomplete = 0x80;
inline constexpr std::uint8_t kListRequest = 1, kListResponse = 2, kObjectRequest = 3, kObjectResponse = 4,
                              kEntryRequest = 5, kEntryResponse = 6, kError = 7;
// List types; the response's first fragment repeats it before the indices
inline constexpr std::uint16_t kListLengths = 0, kListAll = 1, kListRxMappable = 2, kListTxMappable = 3;
// Object response: index, data type, highest sub-index, object code, name
inline constexpr std::size_t kObjectIndex = 0, kObjectType = 2, kObjectMaxSub = 4, kObjectCode = 5, kObjectName = 6;
inline constexpr std::uint8_t kCodeVariable = 7, kCodeArray = 8, kCodeRecord = 9;
// Entry request and response: index, sub-index, value info; then data type, bit length, access, data
inline constexpr std::size_t kEntryIndex = 0, kEntrySub = 2, kEntryValueInfo = 3, kEntryType = 4, kEntryBits = 6,
                             kEntryAccess = 8, kEntryName = 10;
// Access bits: readable and writable in PRE_OP, SAFE_OP, OP; may stand in a received or in a transmitted PDO
inline constexpr std::uint16_t kAccessRead = 0x0007, kAccessWrite = 0x0038, kAccessRxPdo = 0x0040,
                               kAccessTxPdo = 0x0080;
}  // namespace sdo_info

// --- Abort codes (ETG.1000.6 table 41, CiA 301 7.2.4.3.17)
// ------------------------------------------------------------

namespace abort_code {
inline constexpr std::uint32_t kToggle = 0x05030000, kTimeout = 0x05040000, kCommand = 0x05040001,
                               kOutOfMemory = 0x05040005, kUnsupportedAccess = 0x06010000, kWriteOnly = 0x06010001,
                               kReadOnly = 0x06010002, kSubWriteSub0First = 0x06010003,
                               kCompleteAccessUnsupported = 0x06010004, kNoObject = 0x06020000,
                               kNotMappable = 0x06040041, kPdoTooLong = 0x06040042, kIncompatible = 0x06040043,
                               kHardware = 0x06060000, kSize = 0x06070010, kSizeTooLarge = 0x06070012,
                               kSizeTooSmall = 0x06070013, kNoSub = 0x06090011, kValueRange = 0x06090030,
                               kValueTooHigh = 0x06090031, kValueTooLow = 0x06090032, kMaxBelowMin = 0x06090036,
                               kGeneral = 0x08000000, kCannotStore = 0x08000020, kLocalControl = 0x08000021,
                               kDeviceState = 0x08000022;
}
struct AbortText {
  std::uint32_t code;
  std::string_view text;
};
inline constexpr std::array kAbortCodes{
    AbortText{abort_code::kToggle, "toggle bit did not change"},
    AbortText{abort_code::kTimeout, "SDO protocol timeout"},
    AbortText{abort_code::kCommand, "SDO command not valid or unknown"},
    AbortText{abort_code::kOutOfMemory, "out of memory"},
    AbortText{abort_code::kUnsupportedAccess, "unsupported access to the object"},
    AbortText{abort_code::kWriteOnly, "attempt to read a write-only object"},
    AbortText{abort_code::kReadOnly, "attempt to write a read-only object"},
    AbortText{abort_code::kSubWriteSub0First, "sub-index cannot be written; sub-index 0 must be 0 first"},
    AbortText{abort_code::kCompleteAccessUnsupported, "complete access not supported for this object"},
    AbortText{0x06010005, "object is larger than the mailbox"},
    AbortText{0x06010006, "object is mapped to a received PDO; SDO write refused"},
    AbortText{abort_code::kNoObject, "object does not exist in the dictionary"},
    AbortText{abort_code::kNotMappable, "object cannot be mapped to a PDO"},
    AbortText{abort_code::kPdoTooLong, "number and length of mapped objects exceed the PDO"},
    AbortText{abort_code::kIncompatible, "general parameter incompatibility"},
    AbortText{0x06040047, "general internal incompatibility in the device"},
    AbortText{abort_code::kHardware, "access failed because of a hardware error"},
    AbortText{abort_code::kSize, "data type or length does not match"},
    AbortText{abort_code::kSizeTooLarge, "length of the parameter too high"},
    AbortText{abort_code::kSizeTooSmall, "length of the parameter too low"},
    AbortText{abort_code::kNoSub, "sub-index does not exist"},
    AbortText{abort_code::kValueRange, "value out of range"},
    AbortText{abort_code::kValueTooHigh, "value too high"},
    AbortText{abort_code::kValueTooLow, "value too low"},
    AbortText{abort_code::kMaxBelowMin, "maximum is less than minimum"},
    AbortText{abort_code::kGeneral, "general error"},
    AbortText{abort_code::kCannotStore, "data cannot be transferred or stored"},
    AbortText{abort_code::kLocalControl, "data cannot be transferred because of local control"},
    AbortText{abort_code::kDeviceState, "data cannot be transferred in the present device state"},
    AbortText{0x08000023, "object dictionary is missing"},
};
constexpr std::string_view abort_text(std::uint32_t code) noexcept {
  for (const auto& row : kAbortCodes)
    if (row.code == code) return row.text;
  return "unknown abort code";
}

// --- Objects of the communication area that bring-up uses (ETG.1000.6 5.6.7) -----------------------------------------

namespace object {
inline constexpr std::uint16_t kDeviceType = 0x1000, kErrorRegister = 0x1001, kDeviceName = 0x1008, kIdentity = 0x1018,
                               kRxPdoMap0 = 0x1600, kTxPdoMap0 = 0x1A00, kSyncManagerType = 0x1C00,
                               kSyncManagerAssign0 = 0x1C10;  ///< + number of the SyncManager
inline constexpr std::uint16_t kRxPdoAssign = 0x1C12, kTxPdoAssign = 0x1C13;
}  // namespace object

/// One mapping entry as it stands in 1600h.., 1A00h..: index, sub, bits.
constexpr std::uint32_t mapping_entry(std::uint16_t index, std::uint8_t sub, std::uint8_t bit_length) noexcept {
  return static_cast<std::uint32_t>(index) << 16 | static_cast<std::uint32_t>(sub) << 8 | bit_length;
}

}  // namespace gantry::devices::wire
