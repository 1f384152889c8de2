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

/// The object's bytes as the station has them. Complete access that the station does not support falls back to one
/// sub-index after the other. Fault::SdoAbort with the abort code as text, MailboxTimeout, MailboxProtocol.
Result<Bytes> sdo_upload(Link& link, StationRecord& station, config::ObjectAddress object,
                         SdoAccess access = SdoAccess::Single);
Result<void> sdo_download(Link& link, StationRecord& station, config::ObjectAddress object,
                          std::span<const std::byte> value, SdoAccess access = SdoAccess::Single);

/// A number, checked to have its type's size: Fault::SdoSizeMismatch (R19).
Result<std::int64_t> read_number(Link& link, StationRecord& station, config::ObjectAddress object,
                                 config::ObjectType type);
Result<void> write_number(Link& link, StationRecord& station, config::ObjectAddress object, config::ObjectType type,
                          std::int64_t value);

}  // namespace gantry::devices
