// The SII EEPROM of a station: fixed words and categories (ETG.1000.6 tables 16-26, ETG.2010). Addresses are in words.
#pragma once
#include <cstdint>
#include <span>

#include "devices/wire/bytes.hpp"

namespace gantry::devices::wire {

namespace sii {
inline constexpr std::uint16_t kPdiControl = 0x0000, kPdiConfig = 0x0001, kSyncImpulse = 0x0002, kPdiConfig2 = 0x0003,
                               kAlias = 0x0004, kChecksum = 0x0007;
inline constexpr std::uint16_t kVendor = 0x0008, kProduct = 0x000A, kRevision = 0x000C, kSerial = 0x000E;
inline constexpr std::uint16_t kMailboxOutStart = 0x0018, kMailboxOutSize = 0x0019, kMailboxInStart = 0x001A,
                               kMailboxInSize = 0x001B, kMailboxProtocols = 0x001C;
inline constexpr std::uint16_t kSize = 0x003E;  ///< KiBit - 1
inline constexpr std::uint16_t kVersion = 0x003F, kFirstCategory = 0x0040;

// Mailbox protocols
inline constexpr std::uint16_t kProtocolAoe = 0x01, kProtocolEoe = 0x02, kProtocolCoe = 0x04, kProtocolFoe = 0x08,
                               kProtocolSoe = 0x10, kProtocolVoe = 0x20;

// Categories: type word, length in words, data
enum class Category : std::uint16_t {
  Nop = 0,
  Strings = 10,
  DataTypes = 20,
  General = 30,
  Fmmu = 40,
  SyncManager = 41,
  TxPdo = 50,
  RxPdo = 51,
  Dc = 60,
  End = 0xFFFF,
};

// Category General: byte offsets
inline constexpr std::size_t kGeneralGroup = 0, kGeneralImage = 1, kGeneralOrder = 2, kGeneralName = 3,
                             kGeneralCoeDetails = 5, kGeneralFoe = 6, kGeneralEoe = 7, kGeneralFlags = 11,
                             kGeneralEbusCurrent = 12, kGeneralPorts = 16, kGeneralBytes = 32;
inline constexpr std::uint8_t kFlagSafeOp = 0x01, kFlagNoLrw = 0x02;
inline constexpr std::uint8_t kCoeSdo = 0x01, kCoeSdoInfo = 0x02, kCoePdoAssign = 0x04, kCoePdoConfig = 0x08,
                              kCoeUploadAtStart = 0x10, kCoeCompleteAccess = 0x20;

// Category Fmmu: one byte each
inline constexpr std::uint8_t kFmmuOutputs = 1, kFmmuInputs = 2, kFmmuMailboxState = 3;

// Category SyncManager: 8 bytes each: start, length, control, status, enable, type
inline constexpr std::size_t kSmStart = 0, kSmLength = 2, kSmControl = 4, kSmStatus = 5, kSmEnable = 6, kSmType = 7,
                             kSmBytes = 8;

// Category TxPdo/RxPdo: header (index, entries, SM, sync, name, flags), then entries (index, sub, name, type, bits,
// flags)
inline constexpr std::size_t kPdoIndex = 0, kPdoEntries = 2, kPdoSyncManager = 3, kPdoSync = 4, kPdoName = 5,
                             kPdoFlags = 6, kPdoHeader = 8;
inline constexpr std::size_t kEntryIndex = 0, kEntrySub = 2, kEntryName = 3, kEntryType = 4, kEntryBits = 5,
                             kEntryFlags = 6, kEntryBytes = 8;
inline constexpr std::uint8_t kNoSyncManager = 0xFF;  ///< of a PDO that is not assigned by default

// Category Dc: 24 bytes a mode: SYNC0 cycle and shift, SYNC1 shift, SYNC1 factor, AssignActivate, SYNC0 factor, name
inline constexpr std::size_t kDcCycle0 = 0, kDcShift0 = 4, kDcShift1 = 8, kDcFactor1 = 12, kDcActivate = 14,
                             kDcFactor0 = 16, kDcName = 18, kDcBytes = 24;
}  // namespace sii

/// Checksum over the first 14 bytes, in the low byte of word 7: polynomial x^8 + x^2 + x + 1, start value FFh.
constexpr std::uint8_t sii_checksum(std::span<const std::byte> first_14) noexcept {
  std::uint8_t crc = 0xFF;
  for (const auto b : first_14) {
    crc = static_cast<std::uint8_t>(crc ^ std::to_integer<std::uint8_t>(b));
    for (int bit = 0; bit < 8; ++bit) crc = static_cast<std::uint8_t>((crc & 0x80) != 0 ? crc << 1 ^ 0x07 : crc << 1);
  }
  return crc;
}

}  // namespace gantry::devices::wire
