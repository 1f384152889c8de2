// What objects a station has, by its own word: SDO information (ETG.1000.6, 5.6.3), with answers in fragments.
//   auto indices = read_object_indices(link, station, wire::sdo_info::kListAll);
//   auto object = describe_object(link, station, 0x6040);       auto entry = describe_entry(link, station, {0x6040,
//   0});
// Off the RT side.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "config/drive.hpp"
#include "core/error.hpp"
#include "devices/ethercat/link.hpp"
#include "devices/ethercat/station.hpp"

namespace gantry::devices {

struct EntryDescription {
  config::ObjectAddress address;
  std::string name;
  std::uint16_t data_type = 0;  ///< ETG.1020: 1 BOOLEAN, 2 INTEGER8, 5 UNSIGNED8, 9 VISIBLE_STRING ...
  std::uint16_t bit_length = 0;
  std::uint16_t access = 0;  ///< wire::sdo_info::kAccess...
};
struct ObjectDescription {
  std::uint16_t index = 0;
  std::string name;
  std::uint16_t data_type = 0;
  std::uint8_t max_sub = 0, code = 0;     ///< wire::sdo_info::kCode...
  std::vector<EntryDescription> entries;  ///< empty unless asked for
  std::string refused;                    ///< why the station lists the object and does not describe it
};

/// Fault::SdoAbort when the station refuses (a sub-index that does not exist ...), MailboxTimeout, MailboxProtocol
/// (also of a station without SDO information).
Result<std::vector<std::uint16_t>> read_object_indices(Link& link, StationRecord& station, std::uint16_t list);
Result<ObjectDescription> describe_object(Link& link, StationRecord& station, std::uint16_t index);
Result<EntryDescription> describe_entry(Link& link, StationRecord& station, config::ObjectAddress address);
/// All objects; with their entries (gaps in the sub-indices are left out). One that the station lists and then refuses
/// to describe stays in the list with what it says.
Result<std::vector<ObjectDescription>> read_object_list(Link& link, StationRecord& station, bool with_entries);

}  // namespace gantry::devices
