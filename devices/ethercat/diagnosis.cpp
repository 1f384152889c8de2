#include "devices/ethercat/diagnosis.hpp"

#include <algorithm>

namespace gantry::devices {

using namespace wire;

bool ErrorCounters::any() const {
  return processing_unit != 0 || pdi != 0 || std::any_of(ports.begin(), ports.end(), [](const Port& p) {
           return (p.invalid_frames | p.rx_errors | p.forwarded | p.lost_links) != 0;
         });
}

ErrorCounters decode_error_counters(std::span<const std::byte, reg::kErrorCounterBytes> raw) {
  const auto at = [&](std::size_t r) { return std::to_integer<std::uint8_t>(raw[r - reg::kRxErrorCounters]); };
  ErrorCounters c;
  for (std::size_t i = 0; i < c.ports.size(); ++i)
    c.ports[i] = {at(reg::kRxErrorCounters + 2 * i), at(reg::kRxErrorCounters + 2 * i + 1),
                  at(reg::kForwardedErrorCounters + i), at(reg::kLostLinkCounters + i)};
  c.processing_unit = at(reg::kProcessingUnitErrors);
  c.pdi = at(reg::kPdiErrors);
  return c;
}

ErrorCounts counts_of(const ErrorCounters& c) noexcept {
  constexpr std::array<std::string_view, kPorts> kNames{"port 0", "port 1", "port 2", "port 3"};
  ErrorCounts counts;
  for (std::size_t p = 0; p < c.ports.size(); ++p) {
    counts.push_back({kNames[p], "frames with a wrong checksum", c.ports[p].invalid_frames});
    counts.push_back({kNames[p], "wrong symbols", c.ports[p].rx_errors});
    counts.push_back({kNames[p], "lost links", c.ports[p].lost_links});
  }
  counts.push_back({"inside", "frames that are no EtherCAT", c.processing_unit});
  counts.push_back({"inside", "errors towards its own processor", c.pdi});
  return counts;
}

Result<ErrorCounters> read_error_counters(Link& link, const StationRecord& station) {
  std::array<std::byte, reg::kErrorCounterBytes> raw{};
  if (auto ok = link.read(station.address, reg::kRxErrorCounters, raw); !ok) return tl::unexpected(ok.error());
  return decode_error_counters(raw);
}

Result<DcStatus> read_dc_status(Link& link, const StationRecord& station) {
  DcStatus s;
  s.present = (station.esc.features & kFeatureDc) != 0;
  s.wide = (station.esc.features & kFeatureDc64) != 0;
  if (!s.present) return s;
  std::array<std::byte, 8> time{}, offset{}, start{};
  std::array<std::byte, 4> delay{}, difference{}, cycle{};
  std::array<std::byte, 1> activation{};
  std::array batch{
      Datagram{Command::Fprd, physical_address(station.address, reg::kDcSystemTime), time},
      Datagram{Command::Fprd, physical_address(station.address, reg::kDcSystemTimeOffset), offset},
      Datagram{Command::Fprd, physical_address(station.address, reg::kDcSystemTimeDelay), delay},
      Datagram{Command::Fprd, physical_address(station.address, reg::kDcSystemTimeDifference), difference},
      Datagram{Command::Fprd, physical_address(station.address, reg::kDcActivation), activation},
      Datagram{Command::Fprd, physical_address(station.address, reg::kDcStartTime), start},
      Datagram{Command::Fprd, physical_address(station.address, reg::kDcSync0Cycle), cycle},
  };
  if (auto ok = link.transact(batch); !ok) return tl::unexpected(ok.error());
  if (batch.front().working_counter != kWkcRead)
    return fail(Fault::StationMissing, "the station does not answer (0910h)", station.where);
  s.system_time_ns = s.wide ? get_le<std::uint64_t>(time, 0) : get_le<std::uint32_t>(time, 0);
  s.offset_ns = get_le<std::uint64_t>(offset, 0);
  s.delay_ns = get_le<std::uint32_t>(delay, 0);
  s.difference_ns = dc_difference_ns(get_le<std::uint32_t>(difference, 0));
  s.activation = get_le<std::uint8_t>(activation, 0);
  s.next_sync0_ns = get_le<std::uint64_t>(start, 0);
  s.sync0_cycle_ns = get_le<std::uint32_t>(cycle, 0);
  return s;
}

}  // namespace gantry::devices
