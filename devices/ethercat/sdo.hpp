// Reading and writing objects of a station by CoE SDO (ETG.1000.6, 5.6.2): expedited, normal and segmented, up and
// down.
//   auto value = sdo_upload(link, station, {0x6064, 0});
#pragma once
#include <cstdint>
#include <span>

#include "config/drive.hpp"
#include "core/error.hpp"
#include "devices/bus.hpp"
#include "devices/ethercat/link.hpp"
#include "devices/ethercat/station.hpp"

namespace gantry::devices {

/// One sub-index, or all of an object at once: sub-index 0 as two bytes, then the others one behind the other.
enum class SdoAccess : std::uint8_t { Single, Complete };

/// Errors name the station, the object and what was asked: "writing 08h to 6060h:00: ... (abort code 06010002h)".
/// `aborted`, where given, becomes the abort code with which the station has refused; 0: it did not.
///
/// The object's bytes as the station has them. Complete access that the station does not support falls back to one
/// sub-index after the other. `known_bytes`: of a value of 1 or 2 bytes, where the station does not say how many of the
/// four in its answer count. Fault::SdoAbort with the abort code as text, MailboxTimeout, MailboxProtocol.
Result<Bytes> sdo_upload(Link& link, StationRecord& station, config::ObjectAddress object,
                         SdoAccess access = SdoAccess::Single, std::uint32_t* aborted = nullptr,
                         std::size_t known_bytes = 4);
Result<void> sdo_download(Link& link, StationRecord& station, config::ObjectAddress object,
                          std::span<const std::byte> value, SdoAccess access = SdoAccess::Single,
                          std::uint32_t* aborted = nullptr);

/// A number. Manuals are ambiguous about sizes (6098h of 8 or 16 bits), so the station's counts, not that of `type`,
/// which says whether it has a sign. Fault::SdoSizeMismatch (R19) where it is no number of 1, 2 or 4 bytes, or the
/// value does not fit.
Result<std::int64_t> read_number(Link& link, StationRecord& station, config::ObjectAddress object,
                                 config::ObjectType type, std::uint32_t* aborted = nullptr);
Result<void> write_number(Link& link, StationRecord& station, config::ObjectAddress object, config::ObjectType type,
                          std::int64_t value, std::uint32_t* aborted = nullptr);

}  // namespace gantry::devices
