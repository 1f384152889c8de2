// What a station's firmware says it is (1018h; CiA 301, 7.5.2.18), against what its EEPROM says. Where they differ, one
// of the two was made for another device, and its objects may mean something else.
//   if (auto ok = check_identity_object(link, station); !ok) return ok;   // in PRE_OP, before anything is written
#pragma once
#include "config/same_device.hpp"
#include "core/error.hpp"
#include "devices/ethercat/link.hpp"
#include "devices/ethercat/station.hpp"

namespace gantry::devices {

/// 1018h:1 and 1018h:2, two reads. 0 is "not said": what the station shows as 0, refuses or does not have, and all of a
/// station without CoE. Fault::SdoSizeMismatch where it is no number, MailboxTimeout ... where it does not answer.
Result<config::ObjectIdentity> read_identity_object(Link& link, StationRecord& station);

/// Of a station of the machine file: Fault::IdentityMismatch where what it says is neither what its EEPROM says nor
/// what was accepted with it.
Result<void> check_identity_object(Link& link, StationRecord& station);

}  // namespace gantry::devices
