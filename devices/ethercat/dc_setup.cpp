#include "devices/ethercat/dc_setup.hpp"

#include <algorithm>
#include <fmt/format.h>

namespace gantry::devices {
namespace {

using namespace wire;

constexpr std::uint16_t kSpeedCounterStart = 0x1000;  // power-on value of 0930h; writing it resets the filters
constexpr int kDriftFrames = 1000;
constexpr int kFramesPerLook = 20;
constexpr Time kFrameSpacing = microseconds(500);
constexpr std::uint32_t kLockedBelow = 1024;  // ns; a power of two, so that OR-ed magnitudes can be judged

struct Latched {
  std::uint32_t round_trip_ns = 0;
  std::uint64_t local_ns = 0;
};

/// Times of the latching frame at one station.
Result<Latched> read_latched(Link& link, const StationRecord& s) {
  std::array<std::byte, 16> ports{};
  if (auto ok = link.read(s.address, reg::kDcReceiveTimePort0, ports); !ok) return tl::unexpected(ok.error());
  const auto local = link.read<std::uint64_t>(s.address, reg::kDcReceiveTimeUnit);
  if (!local) return tl::unexpected(local.error());
  const auto dl = link.read<std::uint16_t>(s.address, reg::kDlStatus);
  if (!dl) return tl::unexpected(dl.error());
  Latched l;
  l.local_ns = *local;
  const auto in = get_le<std::uint32_t>(ports, 0);
  // Frames leave through ports 3, 1, 2 in this order; on a line only one of them is open.
  for (const int port : {3, 1, 2})
    if (dl_link(*dl, port) && !dl_loop_closed(*dl, port))
      l.round_trip_ns = get_le<std::uint32_t>(ports, static_cast<std::size_t>(4 * port)) - in;
  return l;
}

/// Sends the reference time round until the clocks agree; the OR of all magnitudes of 092Ch, ns.
Result<std::uint32_t> take_out_drift(Link& link, std::uint16_t reference) {
  std::uint32_t apart = 0;
  for (int i = 1; i <= kDriftFrames; ++i) {
    std::array<std::byte, 8> time{};
    if (auto ok = link.transact(Command::Frmw, physical_address(reference, reg::kDcSystemTime), time); !ok)
      return tl::unexpected(ok.error());
    if (i % kFramesPerLook == 0) {
      std::array<std::byte, 4> difference{};
      if (auto ok = link.transact(Command::Brd, physical_address(0, reg::kDcSystemTimeDifference), difference); !ok)
        return tl::unexpected(ok.error());
      apart = get_le<std::uint32_t>(difference, 0) & 0x7FFFFFFFu;
      if (apart < kLockedBelow) break;
    }
    link.pause(kFrameSpacing);
  }
  return apart;
}

}  // namespace

std::vector<std::uint32_t> line_delays(const std::vector<std::uint32_t>& round_trip_ns) {
  std::vector<std::uint32_t> delays(round_trip_ns.size(), 0);
  for (std::size_t i = 1; i < delays.size(); ++i) {
    const auto before = round_trip_ns[i - 1], behind = round_trip_ns[i];
    delays[i] = delays[i - 1] + (before > behind ? (before - behind) / 2 : 0);
  }
  return delays;
}

Result<DcSetup> set_up_clocks(Link& link, std::vector<StationRecord>& stations, std::vector<std::string>& notes) {
  std::vector<StationRecord*> clocks;
  for (auto& s : stations) {
    const bool wanted = s.dc;
    s.dc = wanted && (s.esc.features & kFeatureDc) != 0;
    s.sync0 = s.sync0 && s.dc;
    if (wanted && !s.dc && s.config != nullptr) notes.push_back(s.where + ": its ESC has no distributed clock");
    if (s.dc) clocks.push_back(&s);
  }
  if (clocks.empty()) return DcSetup{};

  constexpr std::array<std::byte, 4> latch{};
  const auto master_time = static_cast<std::uint64_t>(link.clock().now().count());
  if (auto ok = link.write_all(reg::kDcReceiveTimePort0, latch); !ok) return tl::unexpected(ok.error());

  std::vector<std::uint64_t> local;
  std::vector<std::uint32_t> round_trip;
  for (auto* s : clocks) {
    const auto l = read_latched(link, *s);
    if (!l) return tl::unexpected(l.error());
    local.push_back(l->local_ns);
    round_trip.push_back(l->round_trip_ns);
  }
  const auto delays = line_delays(round_trip);
  for (std::size_t i = 0; i < clocks.size(); ++i) {
    StationRecord& s = *clocks[i];
    s.dc_delay_ns = delays[i];
    // The frame passed station i `delay` after the reference, which then had the master's time.
    const std::uint64_t offset = master_time + delays[i] - local[i];
    if (auto ok = link.write<std::uint64_t>(s.address, reg::kDcSystemTimeOffset, offset); !ok)
      return tl::unexpected(ok.error());
    if (auto ok = link.write<std::uint32_t>(s.address, reg::kDcSystemTimeDelay, delays[i]); !ok)
      return tl::unexpected(ok.error());
    if (auto ok = link.write<std::uint16_t>(s.address, reg::kDcSpeedCounterStart, kSpeedCounterStart); !ok)
      return tl::unexpected(ok.error());
  }
  const auto apart = take_out_drift(link, clocks.front()->address);
  if (!apart) return tl::unexpected(apart.error());
  if (*apart >= kLockedBelow) notes.push_back(fmt::format("the stations' clocks are still up to {} ns apart", *apart));
  return DcSetup{clocks.front()->address};
}

Result<void> start_sync0(Link& link, const std::vector<StationRecord>& stations, const DcSetup& dc, Time cycle) {
  if (dc.reference_address == 0) return {};
  const auto period = static_cast<std::uint64_t>(cycle.count());
  const auto reference_time = [&] { return link.read<std::uint64_t>(dc.reference_address, reg::kDcSystemTime); };

  // On a slow host the start may be past before the last station knows of it; then the same with more time.
  for (const Time ahead : {milliseconds(20), milliseconds(200), milliseconds(1000)}) {
    const auto now = reference_time();
    if (!now) return tl::unexpected(now.error());
    const std::uint64_t start = (*now + static_cast<std::uint64_t>(ahead.count())) / period * period + period;
    for (const auto& s : stations) {
      if (!s.sync0) continue;
      for (const auto& ok :
           {link.write<std::uint8_t>(s.address, reg::kDcActivation, 0),
            link.write<std::uint8_t>(s.address, reg::kDcCyclicUnitControl, 0),
            link.write<std::uint32_t>(s.address, reg::kDcSync0Cycle, static_cast<std::uint32_t>(period)),
            link.write<std::uint32_t>(s.address, reg::kDcSync1Cycle, 0),
            link.write<std::uint64_t>(s.address, reg::kDcStartTime, start),
            link.write<std::uint8_t>(s.address, reg::kDcActivation, kDcActivateCyclic | kDcActivateSync0)})
        if (!ok) return ok;
    }
    const auto after = reference_time();
    if (!after) return tl::unexpected(after.error());
    if (*after < start) return {};
  }
  return fail(Fault::DcLost, "the stations could not be told the start of SYNC0 in time; the bus is too slow");
}

}  // namespace gantry::devices
