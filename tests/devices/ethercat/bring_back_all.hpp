// What a recovery of the whole line is to the master: each station in turn, and the first that stays away.
#pragma once
#include "devices/ethercat/master.hpp"

namespace gantry::devices {

inline Result<void> bring_back_all(EthercatMaster& master) {
  Result<void> first;
  for (const StationRecord& station : master.stations())
    if (auto back = master.bring_back(station.id); !back && first) first = tl::unexpected(back.error());
  return first;
}

}  // namespace gantry::devices
