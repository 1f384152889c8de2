// A station of the machine file and what was found in its place: whether it is that one, and what is kept of it when it
// is taken for it.
#pragma once
#include "app/cli/today.hpp"
#include "config/machine.hpp"
#include "devices/ethercat/sii.hpp"

namespace gantry::cli {

inline bool accepted_or_assumed(const config::Station& station, const devices::StationSii& sii) {
  const auto& id = station.profile.identity;
  return station.accepted ? station.accepted->vendor == sii.vendor && station.accepted->product == sii.product
                          : id.vendor == sii.vendor && id.product == sii.product;
}

/// A walk counts for the same device only; a restart that it waits for is waited for on.
inline config::Accepted accepted_today(const config::Station& station, const devices::StationSii& sii) {
  const auto& before = station.accepted;
  const bool pending = before && before->restart_pending;
  const bool same =
      before && before->vendor == sii.vendor && before->product == sii.product && before->serial == sii.serial;
  return {.vendor = sii.vendor,
          .product = sii.product,
          .revision = sii.revision,
          .serial = sii.serial,
          .date = today(),
          .restart_pending = pending,
          .walked = same ? before->walked : "",
          .walked_as = same ? before->walked_as : ""};
}

}  // namespace gantry::cli
