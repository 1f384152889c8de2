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

/// What is kept of `found` today. What was said of the very same device before counts on: that a person has compared
/// it, and what its walk has shown.
template <class Found>
Accepted kept_of(const Station& station, const Found& found, const std::string& date) {
  const std::optional<Accepted>& before = station.accepted;
  const bool same = before && same_device(*before, found) && before->serial == found.serial;
  return {.vendor = found.vendor,
          .product = found.product,
          .revision = found.revision,
          .serial = found.serial,
          .date = date,
          .compared = same && before->compared,
          .walked = same ? before->walked : "",
          .walked_as = same ? before->walked_as : ""};
}

}  // namespace gantry::config
