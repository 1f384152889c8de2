// Whether two of a machine file's identity, an accepted one and one that was found on a bus are of the same product.
//   if (config::same_device(station.profile.identity, record.sii)) ...
#pragma once
#include "config/machine.hpp"

namespace gantry::config {

template <class A, class B>
bool same_device(const A& a, const B& b) {
  return a.vendor == b.vendor && a.product == b.product;
}

/// What stands at the station's position is what was accepted there; where nothing was, what its profile says.
template <class Found>
bool as_expected(const Station& station, const Found& found) {
  return station.accepted ? same_device(*station.accepted, found) : same_device(station.profile.identity, found);
}

/// Any alias will do where the machine file states none.
inline bool alias_fits(const Station& station, std::uint16_t found) {
  return station.alias == 0 || station.alias == found;
}

inline bool says_something(const ObjectIdentity& id) { return id.vendor != 0 || id.product != 0; }

/// What 1018h has to say where it says something: what it said when the station was accepted, else what its EEPROM
/// says.
template <class Eeprom>
ObjectIdentity expected_object(const std::optional<Accepted>& accepted, const Eeprom& eeprom) {
  const ObjectIdentity kept = accepted ? accepted->object : ObjectIdentity{};
  return {kept.vendor != 0 ? kept.vendor : eeprom.vendor, kept.product != 0 ? kept.product : eeprom.product};
}
inline bool agrees(const ObjectIdentity& said, const ObjectIdentity& expected) {
  return (said.vendor == 0 || said.vendor == expected.vendor) &&
         (said.product == 0 || said.product == expected.product);
}

/// What is kept of `found` today. What was said of the very same device before counts on: that a person has compared
/// it, and what its walk has shown.
template <class Found>
Accepted kept_of(const Station& station, const Found& found, const std::string& date) {
  const std::optional<Accepted>& before = station.accepted;
  const bool same_product = before && same_device(*before, found);
  const bool same = same_product && before->serial == found.serial;
  return {.vendor = found.vendor,
          .product = found.product,
          .revision = found.revision,
          .serial = found.serial,
          .date = date,
          .compared = same && before->compared,
          .walked = same ? before->walked : "",
          .walked_as = same ? before->walked_as : "",
          .object = same_product ? before->object : ObjectIdentity{}};
}

}  // namespace gantry::config
