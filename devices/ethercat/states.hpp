// EtherCAT states of a station (ETG.1000.6, 6.4): asks for them and waits for them; a refusal carries the AL status
// code and its text.
#pragma once
#include "core/error.hpp"
#include "devices/ethercat/link.hpp"
#include "devices/ethercat/station.hpp"

namespace gantry::devices {

struct AlStatus {
  wire::AlState state = wire::AlState::None;
  bool error = false;
  std::uint16_t code = 0;
};
/// "in SAFE_OP: AL status code 001Bh, sync manager watchdog"; without a code only the state.
std::string in_words(const AlStatus& status);
/// What to do about a code (ETG.1020); never empty.
std::string_view remedy_of_al_code(std::uint16_t code);
Result<AlStatus> read_al_status(Link& link, const StationRecord& station);

/// Asks without waiting.
Result<void> request_state(Link& link, const StationRecord& station, wire::AlState state);

/// Acknowledges an error that the station shows, and stays in its state.
Result<void> acknowledge(Link& link, const StationRecord& station);

/// Waits until the station is there, at most kStateTimeout. One that refuses is acknowledged and asked again, as other
/// masters do: some stations refuse while they are still busy. Fault::StateChangeRefused with the AL status code as
/// text.
inline constexpr int kStateAttempts = 3;
inline constexpr Time kStateTimeout = milliseconds(5000);
Result<void> wait_for_state(Link& link, const StationRecord& station, wire::AlState state);

}  // namespace gantry::devices
