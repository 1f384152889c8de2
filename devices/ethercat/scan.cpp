#include "devices/ethercat/scan.hpp"

#include <algorithm>
#include <fmt/format.h>

#include "devices/ethercat/sii.hpp"
#include "devices/ethercat/states.hpp"

namespace gantry::devices {
namespace {

using namespace wire;

bool same_device(const config::Identity& a, const StationSii& b) {
  return a.vendor == b.vendor && a.product == b.product;
}

std::string device(std::uint32_t vendor, std::uint32_t product, std::uint32_t revision) {
  return fmt::format("vendor {:08X}h, product {:08X}h, revision {:08X}h", vendor, product, revision);
}

std::vector<const config::Station*> on_ethercat(const config::Machine& machine) {
  std::vector<const config::Station*> stations;
  for (const auto& s : machine.stations)
    if (s.bus == config::BusKind::EtherCat) stations.push_back(&s);
  std::sort(stations.begin(), stations.end(), [](auto* a, auto* b) { return a->position < b->position; });
  return stations;
}

std::string where(const config::Station& s) { return fmt::format("station {} '{}'", s.position, s.name); }

}  // namespace

Result<int> count_stations(Link& link) {
  std::array<std::byte, 1> type{};
  const auto wkc = link.transact(Command::Brd, physical_address(0, reg::kType), type);
  if (!wkc) return tl::unexpected(wkc.error());
  return static_cast<int>(*wkc);
}

Result<void> reset_stations(Link& link, int count) {
  // INIT first: what follows may be in use before. SYNC0 that stayed active across restarts is a classic.
  std::array<std::byte, 2> init{};
  put_le<std::uint16_t>(init, 0, static_cast<std::uint16_t>(AlState::Init) | kAlError);
  constexpr std::array<std::byte, 256> zeros{};
  const std::span<const std::byte> zero(zeros);
  struct Clear {
    std::uint16_t reg;
    std::span<const std::byte> data;
  };
  for (const auto& c : {Clear{reg::kAlControl, init}, Clear{reg::kDcActivation, zero.first(1)},
                        Clear{reg::kFmmu0, zero.first(256)}, Clear{reg::kSyncManager0, zero.first(128)},
                        Clear{reg::kRxErrorCounters, zero.first(8)}, Clear{reg::kSiiConfig, zero.first(1)}}) {
    const auto wkc = link.write_all(c.reg, c.data);
    if (!wkc) return tl::unexpected(wkc.error());
  }
  for (int position = 0; position < count; ++position) {
    std::array<std::byte, 2> address{};
    put_le<std::uint16_t>(address, 0, station_address(position));
    const auto wkc =
        link.transact(Command::Apwr, physical_address(auto_increment(position), reg::kStationAddress), address);
    if (!wkc) return tl::unexpected(wkc.error());
    if (*wkc != kWkcWrite)
      return fail(Fault::StationMissing, "the station did not take its address; it went away during the scan",
                  fmt::format("station {}", position));
  }
  return {};
}

Result<std::string> check_identity(const config::Machine& machine, const config::Station& station,
                                   const StationSii& found) {
  const config::Identity& expected = station.profile.identity;
  const std::string found_text = device(found.vendor, found.product, found.revision);
  if (same_device(expected, found)) {
    if (expected.revision == found.revision || expected.assumed) return std::string{};
    return fmt::format("{}: revision {:08X}h instead of {:08X}h", where(station), found.revision, expected.revision);
  }
  const auto other = std::find_if(machine.stations.begin(), machine.stations.end(), [&](const auto& s) {
    return s.bus == config::BusKind::EtherCat && same_device(s.profile.identity, found);
  });
  const std::string expected_text =
      fmt::format("{} ({})", station.profile.title, device(expected.vendor, expected.product, expected.revision));
  if (other != machine.stations.end())
    return fail(Fault::IdentityMismatch,
                fmt::format("position {} should be '{}', a {}, but a {} stands there ({}); correct the wiring or the "
                            "order in the machine file",
                            station.position, station.name, expected_text, other->profile.title, found_text),
                where(station));
  if (!expected.assumed)
    return fail(Fault::IdentityMismatch,
                fmt::format("position {} should be '{}', a {}, but has {}", station.position, station.name,
                            expected_text, found_text),
                where(station));
  return fmt::format("{}: the identity of {} is assumed and differs: found {}; confirm it and enter it in the profile",
                     where(station), expected_text, found_text);
}

Result<std::vector<StationRecord>> scan(Link& link, const config::Machine& machine, std::vector<std::string>& notes) {
  const auto configured = on_ethercat(machine);
  const auto count = count_stations(link);
  if (!count) return tl::unexpected(count.error());
  const auto wanted = static_cast<int>(configured.size());
  if (*count != wanted) {
    const std::string first_missing = *count < wanted
                                          ? fmt::format("; the first that is missing is '{}' at position {}",
                                                        configured[static_cast<std::size_t>(*count)]->name, *count)
                                          : "";
    return fail(Fault::StationMissing,
                fmt::format("{} stations answer, the machine file has {}{}", *count, wanted, first_missing));
  }
  if (auto ok = reset_stations(link, *count); !ok) return tl::unexpected(ok.error());

  std::vector<StationRecord> records;
  for (const auto* station : configured) {
    StationRecord r;
    r.config = station;
    r.where = where(*station);
    r.address = station_address(station->position);
    const auto place = [&](Error e) {
      e.where = r.where;
      return tl::unexpected(std::move(e));
    };
    if (auto ok = wait_for_state(link, r, AlState::Init); !ok) return place(ok.error());
    const auto found = read_station_sii(link, r.address);
    if (!found) return place(found.error());
    r.sii = *found;
    const auto features = link.read<std::uint16_t>(r.address, reg::kFeatures);
    if (!features) return place(features.error());
    r.features = *features;
    const auto alias = link.read<std::uint16_t>(r.address, reg::kStationAlias);
    if (!alias) return place(alias.error());
    r.alias = *alias;
    if (station->alias != 0 && station->alias != r.alias)
      return fail(Fault::IdentityMismatch,
                  fmt::format("position {} should be '{}' with alias {}, but has alias {}", station->position,
                              station->name, station->alias, r.alias),
                  r.where);
    auto note = check_identity(machine, *station, r.sii);
    if (!note) return tl::unexpected(note.error());
    if (!note->empty()) notes.push_back(std::move(*note));
    records.push_back(std::move(r));
  }
  return records;
}

}  // namespace gantry::devices
