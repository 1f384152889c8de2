// What stations count and measure of their own bus: errors by port, clocks. Registers only, so that it can be asked at
// any time and in any state.
//   auto errors = read_error_counters(link, station);     auto clock = read_dc_status(link, station);
// Off the RT side.
#pragma once
#include <array>
#include <cstdint>
#include <span>

#include "core/error.hpp"
#include "devices/ethercat/link.hpp"
#include "devices/ethercat/station.hpp"

namespace gantry::devices {

/// 0300h-0313h (ETG.1000.4 table 43 and on). They count up to 255 and stay there.
struct ErrorCounters {
  struct Port {
    std::uint8_t invalid_frames = 0;  ///< wrong FCS: the cable before this port
    std::uint8_t rx_errors = 0;       ///< symbols that are none
    std::uint8_t forwarded = 0;       ///< errors that a station further up has seen already
    std::uint8_t lost_links = 0;
    bool operator==(const Port&) const = default;
  };
  std::array<Port, wire::kPorts> ports;
  std::uint8_t processing_unit = 0, pdi = 0;
  [[nodiscard]] bool any() const;
  bool operator==(const ErrorCounters&) const = default;
};
ErrorCounters decode_error_counters(std::span<const std::byte, wire::reg::kErrorCounterBytes> raw);
/// Those that tell of trouble at this station, without errors that it has only passed on: the station where they came
/// in counts them too.
ErrorCounts counts_of(const ErrorCounters& counters) noexcept;
Result<ErrorCounters> read_error_counters(Link& link, const StationRecord& station);

struct DcStatus {
  bool present = false, wide = false;  ///< it has clocks; of 64 bits
  std::uint64_t system_time_ns = 0;    ///< 0910h
  std::uint64_t offset_ns = 0;         ///< 0920h
  std::uint32_t delay_ns = 0;          ///< 0928h
  std::int32_t difference_ns = 0;      ///< 092Ch: the local copy minus what came by
  std::uint8_t activation = 0;         ///< 0981h
  std::uint64_t next_sync0_ns = 0;     ///< 0990h
  std::uint32_t sync0_cycle_ns = 0;    ///< 09A0h
};
Result<DcStatus> read_dc_status(Link& link, const StationRecord& station);

}  // namespace gantry::devices
