#include "devices/ethercat/dc_setup.hpp"

#include <algorithm>
#include <fmt/format.h>

#include "devices/ethercat/topology.hpp"

namespace gantry::devices {
namespace {

using namespace wire;

constexpr std::uint16_t kSpeedCounterStart = 0x1000;  // power-on value of 0930h; writing it resets the filters
constexpr int kDriftFrames = 1000;
constexpr int kFramesPerLook = 20;
constexpr Time kFrameSpacing = microseconds(500);
constexpr Time kRejoinTimeout = milliseconds(500), kRejoinPoll = milliseconds(2);
constexpr std::uint32_t kLockedBelow = 1024;  // ns; a power of two, so that OR-ed magnitudes can be judged

struct Latched {
  PortTimes ports{};
  std::uint64_t local_ns = 0;
};

/// Times of the latching frame at the stations that have clocks.
Result<std::vector<Latched>> read_latched(Link& link, std::span<const StationRecord> stations) {
  struct Raw {
    std::array<std::byte, 16> ports{};
    std::array<std::byte, 8> local{};
  };
  std::vector<Raw> raw(stations.size());
  std::vector<Datagram> batch;
  for (std::size_t i = 0; i < stations.size(); ++i) {
    if (!stations[i].dc) continue;
    batch.push_back({Command::Fprd, physical_address(stations[i].address, reg::kDcReceiveTimePort0), raw[i].ports});
    batch.push_back({Command::Fprd, physical_address(stations[i].address, reg::kDcReceiveTimeUnit), raw[i].local});
  }
  if (auto ok = link.transact(batch); !ok) return tl::unexpected(ok.error());
  for (const Datagram& d : batch)
    if (d.working_counter != kWkcRead)
      return fail(Fault::StationMissing, "the station does not give its receive times (0900h)",
                  std::ranges::find(stations, d.address & 0xFFFF, &StationRecord::address)->where);
  std::vector<Latched> latched(stations.size());
  for (std::size_t i = 0; i < stations.size(); ++i) {
    for (std::size_t port = 0; port < latched[i].ports.size(); ++port)
      latched[i].ports[port] = get_le<std::uint32_t>(raw[i].ports, 4 * port);
    const bool wide = (stations[i].esc.features & kFeatureDc64) != 0;
    latched[i].local_ns = wide ? get_le<std::uint64_t>(raw[i].local, 0) : get_le<std::uint32_t>(raw[i].local, 0);
  }
  return latched;
}

/// How long each station lies behind the reference.
std::vector<std::uint32_t> find_delays(std::span<const StationRecord> stations, std::span<const Latched> latched) {
  std::vector<Ports> ports;
  std::vector<PortTimes> times;
  std::vector<bool> clocks;
  for (std::size_t i = 0; i < stations.size(); ++i) {
    ports.push_back(stations[i].ports);
    times.push_back(latched[i].ports);
    clocks.push_back(stations[i].dc);
  }
  return propagation_delays(build_tree(ports), ports, times, clocks);
}

Result<void> write_clock(Link& link, const StationRecord& s, std::uint64_t offset) {
  std::array<std::byte, 8> offset_raw{};
  std::array<std::byte, 4> delay_raw{};
  std::array<std::byte, 2> start_raw{};
  put_le<std::uint64_t>(offset_raw, 0, offset);
  put_le<std::uint32_t>(delay_raw, 0, s.dc_delay_ns);
  put_le<std::uint16_t>(start_raw, 0, kSpeedCounterStart);
  std::array batch{Datagram{Command::Fpwr, physical_address(s.address, reg::kDcSystemTimeOffset), offset_raw},
                   Datagram{Command::Fpwr, physical_address(s.address, reg::kDcSystemTimeDelay), delay_raw},
                   Datagram{Command::Fpwr, physical_address(s.address, reg::kDcSpeedCounterStart), start_raw}};
  if (auto ok = link.transact(batch); !ok) return ok;
  for (const Datagram& d : batch)
    if (d.working_counter != kWkcWrite)
      return fail(Fault::StationMissing, "the station does not take its clock's settings (0920h-0930h)", s.where);
  return {};
}

/// System time of the reference clock. DC time is the machine's clock, so a clock of 32 bits is continued with that.
Result<std::uint64_t> reference_time(Link& link, const DcSetup& dc) {
  std::array<std::byte, 8> raw{};
  const std::size_t size = dc.reference_wide ? 8 : 4;
  if (auto ok = link.read(dc.reference_address, reg::kDcSystemTime, std::span(raw).first(size)); !ok)
    return tl::unexpected(ok.error());
  if (dc.reference_wide) return get_le<std::uint64_t>(raw, 0);
  const auto about = static_cast<std::uint64_t>(link.clock().now().count());
  const auto off = static_cast<std::int32_t>(get_le<std::uint32_t>(raw, 0) - static_cast<std::uint32_t>(about));
  return about + static_cast<std::uint64_t>(std::int64_t{off});
}

/// Sends the reference time round until the clocks agree; the OR of all magnitudes of 092Ch, ns.
Result<std::uint32_t> take_out_drift(Link& link, const DcSetup& dc) {
  std::uint32_t apart = 0;
  for (int i = 1; i <= kDriftFrames; ++i) {
    std::array<std::byte, 8> raw{};
    const auto time = std::span(raw).first(dc.reference_wide ? 8 : 4);  // where the reference has less, all get less
    if (auto ok = link.transact(Command::Frmw, physical_address(dc.reference_address, reg::kDcSystemTime), time); !ok)
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

Result<DcSetup> set_up_clocks(Link& link, std::vector<StationRecord>& stations, std::vector<std::string>& notes) {
  StationRecord* reference = nullptr;
  for (auto& s : stations) {
    const bool wanted = s.dc;
    s.dc = wanted && (s.esc.features & kFeatureDc) != 0;
    s.sync0 = s.sync0 && s.dc;
    if (wanted && !s.dc && s.config != nullptr) notes.push_back(s.where + ": its ESC has no distributed clock");
    if (s.dc && reference == nullptr) reference = &s;
  }
  if (reference == nullptr) return DcSetup{};
  const DcSetup dc{reference->address, (reference->esc.features & kFeatureDc64) != 0};

  constexpr std::array<std::byte, 4> latch{};
  const auto master_time = static_cast<std::uint64_t>(link.clock().now().count());
  if (auto ok = link.write_all(reg::kDcReceiveTimePort0, latch); !ok) return tl::unexpected(ok.error());
  const auto latched = read_latched(link, stations);
  if (!latched) return tl::unexpected(latched.error());
  const auto delays = find_delays(stations, *latched);
  for (std::size_t i = 0; i < stations.size(); ++i) {
    StationRecord& s = stations[i];
    if (!s.dc) continue;
    s.dc_delay_ns = delays[i];
    // The frame passed station i `delay` after the reference, which then had the master's time.
    if (auto ok = write_clock(link, s, master_time + delays[i] - (*latched)[i].local_ns); !ok)
      return tl::unexpected(ok.error());
  }
  const auto apart = take_out_drift(link, dc);
  if (!apart) return tl::unexpected(apart.error());
  if (*apart >= kLockedBelow) notes.push_back(fmt::format("the stations' clocks are still up to {} ns apart", *apart));
  return dc;
}

Result<void> rejoin_clocks(Link& link, const StationRecord& s, const DcSetup& dc, std::uint16_t source) {
  if (!s.dc || dc.reference_address == 0) return {};
  if (auto ok = write_clock(link, s, 0); !ok) return ok;
  std::array<std::byte, 8> own{}, theirs{};
  std::array both{Datagram{Command::Fprd, physical_address(s.address, reg::kDcSystemTime), own},
                  Datagram{Command::Fprd, physical_address(source, reg::kDcSystemTime), theirs}};
  const auto machine_time = static_cast<std::uint64_t>(link.clock().now().count());
  if (auto ok = link.transact(std::span(both).first(source != 0 ? 2 : 1)); !ok) return ok;
  if (both[0].working_counter != kWkcRead || (source != 0 && both[1].working_counter != kWkcRead))
    return fail(Fault::StationMissing, "the station or the clock that it follows does not give its time (0910h)",
                s.where);
  const bool wide = dc.reference_wide && (s.esc.features & kFeatureDc64) != 0;
  const auto time = [&](std::span<const std::byte> raw) {
    return wide ? get_le<std::uint64_t>(raw, 0) : get_le<std::uint32_t>(raw, 0);
  };
  const std::uint64_t should = source != 0 ? time(theirs) : machine_time;
  if (auto ok = write_clock(link, s, should + s.dc_delay_ns - time(own)); !ok) return ok;
  if (s.address == dc.reference_address) return {};
  const Time deadline = link.clock().now() + kRejoinTimeout;
  for (;;) {
    link.pause(kRejoinPoll);
    const auto raw = link.read<std::uint32_t>(s.address, reg::kDcSystemTimeDifference);
    if (!raw) return tl::unexpected(raw.error());
    const std::uint32_t apart = *raw & 0x7FFFFFFFu;
    if (apart < kLockedBelow) return {};
    if (link.clock().now() >= deadline)
      return fail(Fault::DcNotLocked, fmt::format("its clock is still {} ns off", apart), s.where);
  }
}

namespace {

/// Times of a station's pulses: the bus cycle, a multiple, a part, or what its EEPROM states in ns.
std::int64_t pulse_period(std::int32_t factor, std::uint32_t stated_ns, Time cycle) {
  if (factor > 0) return cycle.count() * factor;
  if (factor < 0) return cycle.count() / -factor;
  return stated_ns != 0 ? stated_ns : cycle.count();
}

Result<void> write_pulses(Link& link, const StationRecord& s, Time cycle, std::uint64_t start) {
  const SyncPulses& p = s.sync;
  const std::int64_t period0 = pulse_period(p.factor0, p.cycle0_ns, cycle);
  // 09A4h counts from a SYNC0 to the SYNC1 that follows it.
  const std::int64_t period1 = p.factor1 != 0 ? pulse_period(p.factor1, 0, cycle) - period0 : 0;
  const std::int64_t behind = std::max<std::int64_t>(period1 + p.shift1_ns, 0);
  for (auto ok :
       {link.write<std::uint8_t>(s.address, reg::kDcActivation, 0),
        link.write<std::uint8_t>(s.address, reg::kDcCyclicUnitControl, static_cast<std::uint8_t>(p.activate & 0xFF)),
        link.write<std::uint32_t>(s.address, reg::kDcSync0Cycle, static_cast<std::uint32_t>(period0)),
        link.write<std::uint32_t>(s.address, reg::kDcSync1Cycle, static_cast<std::uint32_t>(behind)),
        link.write<std::uint64_t>(s.address, reg::kDcStartTime,
                                  start + static_cast<std::uint64_t>(std::int64_t{p.shift0_ns})),
        link.write<std::uint8_t>(s.address, reg::kDcActivation, static_cast<std::uint8_t>(p.activate >> 8))})
    if (!ok) {
      if (ok.error().where.empty()) ok.error().where = s.where;
      return ok;
    }
  return {};
}

}  // namespace

Result<void> start_sync0(Link& link, std::span<const StationRecord> stations, const DcSetup& dc, Time cycle) {
  if (dc.reference_address == 0) return {};
  const auto period = static_cast<std::uint64_t>(cycle.count());
  // On a slow host the start may be past before the last station knows of it; then the same with more time.
  for (const Time ahead : {milliseconds(20), milliseconds(200), milliseconds(1000)}) {
    const auto now = reference_time(link, dc);
    if (!now) return tl::unexpected(now.error());
    const std::uint64_t start = (*now + static_cast<std::uint64_t>(ahead.count())) / period * period + period;
    for (const auto& s : stations) {
      if (!s.sync0) continue;
      if (auto ok = write_pulses(link, s, cycle, start); !ok) return ok;
    }
    const auto after = reference_time(link, dc);
    if (!after) return tl::unexpected(after.error());
    if (*after < start) return {};
  }
  return fail(Fault::DcLost, "the stations could not be told the start of SYNC0 in time; the bus is too slow");
}

}  // namespace gantry::devices
