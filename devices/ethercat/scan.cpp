#include "devices/ethercat/scan.hpp"

#include <algorithm>
#include <fmt/format.h>

#include "config/same_device.hpp"
#include "devices/ethercat/sii.hpp"
#include "devices/ethercat/states.hpp"
#include "devices/ethercat/topology.hpp"

namespace gantry::devices {
namespace {

using namespace wire;

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

}  // namespace

std::string where(const config::Station& s) { return fmt::format("station {} '{}'", s.position, s.name); }

Result<int> count_stations(Link& link) {
  std::array<std::byte, 1> type{};
  const auto wkc = link.transact(Command::Brd, physical_address(0, reg::kType), type);
  if (!wkc) return tl::unexpected(wkc.error());
  if (*wkc > kMaxStations)
    return fail(Fault::StationMissing, fmt::format("{} stations answer; at most {} are taken", *wkc, kMaxStations));
  return static_cast<int>(*wkc);
}

namespace {

constexpr std::size_t kEscFactsBytes = 0x14;  // 0000h up to the alias at 0012h
constexpr std::size_t kAliasOffset = 0x12;
constexpr std::uint16_t kDlAliasOffset = 3;  // 0103h: the station answers to its alias, too

std::string at_position(int position) { return fmt::format("station {}", position); }

/// Which of them have no address yet: a station forgets it with its supply.
Result<std::vector<bool>> without_address(Link& link, int count) {
  std::vector<std::array<std::byte, 2>> raw(static_cast<std::size_t>(count));
  std::vector<Datagram> batch;
  for (int i = 0; i < count; ++i)
    batch.push_back(
        {Command::Aprd, physical_address(auto_increment(i), reg::kStationAddress), raw[static_cast<std::size_t>(i)]});
  if (auto ok = link.transact(batch); !ok) return tl::unexpected(ok.error());
  std::vector<bool> none;
  for (const auto& address : raw) none.push_back(get_le<std::uint16_t>(address, 0) == 0);
  return none;
}

Result<void> give_addresses(Link& link, int count) {
  std::vector<std::array<std::byte, 2>> raw(static_cast<std::size_t>(count));
  std::vector<Datagram> batch;
  for (int i = 0; i < count; ++i) {
    auto& bytes = raw[static_cast<std::size_t>(i)];
    put_le<std::uint16_t>(bytes, 0, station_address(i));
    batch.push_back({Command::Apwr, physical_address(auto_increment(i), reg::kStationAddress), bytes});
  }
  if (auto ok = link.transact(batch); !ok) return ok;
  for (int i = 0; i < count; ++i)
    if (batch[static_cast<std::size_t>(i)].working_counter != kWkcWrite)
      return fail(Fault::StationMissing, "the station did not take its address; it went away during the scan",
                  at_position(i));
  return {};
}

/// What the ESC says of itself, its alias and its ports.
Result<void> read_facts(Link& link, std::vector<StationRecord>& stations) {
  struct Raw {
    std::array<std::byte, kEscFactsBytes> esc{};
    std::array<std::byte, 2> dl{};
    std::array<std::byte, 1> eeprom{};
  };
  constexpr std::size_t kQuestions = 3;
  std::vector<Raw> raw(stations.size());
  std::vector<Datagram> batch;
  for (std::size_t i = 0; i < stations.size(); ++i) {
    batch.push_back({Command::Fprd, physical_address(stations[i].address, reg::kType), raw[i].esc});
    batch.push_back({Command::Fprd, physical_address(stations[i].address, reg::kDlStatus), raw[i].dl});
    batch.push_back({Command::Fprd, physical_address(stations[i].address, reg::kSiiConfig), raw[i].eeprom});
  }
  if (auto ok = link.transact(batch); !ok) return ok;
  for (std::size_t i = 0; i < batch.size(); ++i)
    if (batch[i].working_counter != kWkcRead)
      return fail(Fault::StationMissing, "the station does not answer; it went away during the scan",
                  stations[i / kQuestions].where);
  for (std::size_t i = 0; i < stations.size(); ++i) {
    StationRecord& s = stations[i];
    const std::span<const std::byte> esc(raw[i].esc);
    s.esc = {get_le<std::uint8_t>(esc, reg::kType),
             get_le<std::uint8_t>(esc, reg::kRevision),
             get_le<std::uint16_t>(esc, reg::kBuild),
             get_le<std::uint8_t>(esc, reg::kFmmuCount),
             get_le<std::uint8_t>(esc, reg::kSyncManagerCount),
             get_le<std::uint8_t>(esc, reg::kRamKilobytes),
             get_le<std::uint8_t>(esc, reg::kPortDescriptor),
             get_le<std::uint16_t>(esc, reg::kFeatures)};
    s.alias = get_le<std::uint16_t>(esc, kAliasOffset);
    s.eeprom_given = (std::to_integer<std::uint8_t>(raw[i].eeprom[0]) & kSiiToStation) != 0;
    s.ports = decode_ports(get_le<std::uint16_t>(raw[i].dl, 0), s.esc.port_descriptor);
  }
  return {};
}

void find_parents(std::vector<StationRecord>& stations) {
  std::vector<Ports> ports;
  for (const auto& s : stations) ports.push_back(s.ports);
  const Tree tree = build_tree(ports);
  for (std::size_t i = 0; i < stations.size(); ++i) {
    stations[i].parent = tree.nodes[i].parent;
    stations[i].parent_port = tree.nodes[i].parent_port;
  }
}

/// Registers that are cleared at the beginning, of one station or of all.
struct Clear {
  std::uint16_t reg;
  std::span<const std::byte> data;
};
template <class Write>
Result<void> clear_registers(const Write& write) {
  // INIT first: what follows may be in use before. SYNC0 that stayed active across restarts is a classic.
  std::array<std::byte, 2> init{};
  put_le<std::uint16_t>(init, 0, static_cast<std::uint16_t>(AlState::Init) | kAlError);
  constexpr std::array<std::byte, 256> zeros{};
  const std::span<const std::byte> zero(zeros);
  for (const auto& c :
       {Clear{reg::kAlControl, init}, Clear{reg::kDcActivation, zero.first(1)}, Clear{reg::kFmmu0, zero.first(256)},
        Clear{reg::kSyncManager0, zero.first(128)}, Clear{reg::kRxErrorCounters, zero.first(8)},
        Clear{reg::kSiiConfig, zero.first(1)}, Clear{reg::kDlControl + kDlAliasOffset, zero.first(1)}})
    if (auto ok = write(c); !ok) return ok;
  return {};
}

}  // namespace

namespace {

/// EEPROMs of all, whole, at once. Where one of them cannot be read, each by itself, so that it keeps its error and the
/// others are known.
Result<void> read_eeproms(Link& link, std::vector<StationRecord>& stations) {
  const auto images = read_all_sii_images(link, stations.front().address, static_cast<int>(stations.size()));
  if (!images && images.error().fault != Fault::SiiInvalid) return tl::unexpected(images.error());
  for (std::size_t i = 0; i < stations.size(); ++i) {
    StationRecord& s = stations[i];
    const auto own = images ? Result<Bytes>((*images)[i]) : read_sii_image(link, s.address);
    auto sii = own ? parse_sii(*own) : tl::unexpected(own.error());
    s.sii_whole = sii.has_value();
    if (!sii && sii.error().fault == Fault::SiiInvalid) {
      const std::string damage = sii.error().message;
      sii = read_station_sii(link, s.address);
      if (sii) sii->add_damage(damage);
    }
    if (!sii && sii.error().fault != Fault::SiiInvalid) return tl::unexpected(sii.error());
    if (sii)
      s.sii = std::move(*sii);
    else
      s.sii.add_damage(sii.error().message);
  }
  return {};
}

}  // namespace

namespace {

/// What there is to know of stations that have their address now.
Result<void> learn(Link& link, std::vector<StationRecord>& stations) {
  if (auto ok = read_facts(link, stations); !ok) return ok;
  find_parents(stations);
  for (const std::uint8_t owner : {kSiiTakeAway, std::uint8_t{0}}) {
    const std::array raw{std::byte{owner}};
    if (auto ok = link.write_all(reg::kSiiConfig, raw); !ok) return tl::unexpected(ok.error());
  }
  auto read = read_eeproms(link, stations);
  for (const StationRecord& s : stations)
    if (s.eeprom_given)
      if (auto back = give_eeprom(link, s.address); read && !back) read = back;
  return read;
}

}  // namespace

void give_back_addresses(Link& link, const std::vector<StationRecord>& stations) {
  std::array<std::byte, 2> none{};
  for (const StationRecord& s : stations)
    if (s.since_power_up)
      static_cast<void>(link.transact(Command::Fpwr, physical_address(s.address, reg::kStationAddress), none));
}

Result<std::vector<StationRecord>> find_stations(Link& link) {
  const auto count = count_stations(link);
  if (!count) return tl::unexpected(count.error());
  std::vector<StationRecord> stations(static_cast<std::size_t>(*count));
  if (stations.empty()) return stations;
  // Somebody's alias may be the address that another one gets.
  constexpr std::array<std::byte, 1> no_alias{};
  if (auto ok = link.write_all(reg::kDlControl + kDlAliasOffset, no_alias); !ok) return tl::unexpected(ok.error());
  const auto fresh = without_address(link, *count);
  if (!fresh) return tl::unexpected(fresh.error());
  for (int i = 0; i < *count; ++i) {
    StationRecord& s = stations[static_cast<std::size_t>(i)];
    s.since_power_up = (*fresh)[static_cast<std::size_t>(i)];
    s.id = StationId{static_cast<std::uint16_t>(i)};
    s.position = i;
    s.address = station_address(i);
    s.where = at_position(i);
  }
  // Where not all have theirs, two may have the same one: then nothing is taken back by address.
  if (auto ok = give_addresses(link, *count); !ok) return tl::unexpected(ok.error());
  if (auto ok = learn(link, stations); !ok) {
    give_back_addresses(link, stations);
    return tl::unexpected(ok.error());
  }
  return stations;
}

Result<void> read_whole_sii(Link& link, StationRecord& s) {
  if (s.sii_whole) return {};
  if (s.eeprom_given)
    if (auto ok = take_eeprom(link, s.address); !ok) return ok;
  const auto image = read_sii_image(link, s.address);
  if (s.eeprom_given)
    if (auto ok = give_eeprom(link, s.address); !ok) return ok;
  const auto named = [&](Error error) {
    error.where = s.where;
    return tl::unexpected(std::move(error));
  };
  if (!image) return named(image.error());
  auto sii = parse_sii(*image);
  if (!sii) return named(sii.error());
  s.sii = std::move(*sii);
  s.sii_whole = true;
  return {};
}

Result<void> hand_over_eeprom(Link& link, StationRecord& s) {
  s.eeprom_given = true;
  return give_eeprom(link, s.address);
}

Result<void> reset_stations(Link& link) {
  return clear_registers([&](const Clear& c) -> Result<void> {
    if (auto wkc = link.write_all(c.reg, c.data); !wkc) return tl::unexpected(wkc.error());
    return {};
  });
}

Result<void> reset_station(Link& link, const StationRecord& station) {
  return clear_registers([&](const Clear& c) -> Result<void> {
    // Some of these a small ESC does not have; it does not count then, and nothing is missing.
    std::vector<std::byte> copy(c.data.begin(), c.data.end());
    if (auto wkc = link.transact(Command::Fpwr, physical_address(station.address, c.reg), copy); !wkc)
      return tl::unexpected(wkc.error());
    return {};
  });
}

namespace {

/// Against what was accepted at this place: the same product, and not the very device that belongs elsewhere.
Result<std::string> check_accepted(const config::Machine& machine, const config::Station& station,
                                   const config::Accepted& accepted, const StationSii& found) {
  if (!config::same_device(accepted, found))
    return fail(Fault::IdentityMismatch,
                fmt::format("'{}' has changed since {}: it was {}, found is {}; if this is right, `gantry "
                            "commission {} --accept`",
                            station.name, accepted.date, device(accepted.vendor, accepted.product, accepted.revision),
                            device(found.vendor, found.product, found.revision), station.name),
                where(station));
  if (accepted.serial == found.serial) return std::string{};
  const auto other = std::find_if(machine.stations.begin(), machine.stations.end(), [&](const auto& s) {
    return s.accepted && s.accepted->serial == found.serial && found.serial != 0 &&
           config::same_device(*s.accepted, found);
  });
  if (other != machine.stations.end())
    return fail(
        Fault::IdentityMismatch,
        fmt::format("position {} should be '{}' with serial {}, but has serial {}, which was kept as that of '{}'; "
                    "the cables are swapped. If they are right, `gantry commission --all --accept`",
                    station.position, station.name, accepted.serial, found.serial, other->name),
        where(station));
  if (accepted.serial == 0) return fmt::format("{}: serial {} was not accepted yet", where(station), found.serial);
  return fmt::format(
      "{}: another device of the same product: serial {} instead of {}{}", where(station), found.serial,
      accepted.serial,
      accepted.walked.empty() ? "" : "; nobody has seen yet which way it moves: `gantry commission --walk`");
}

}  // namespace

Result<std::string> check_identity(const config::Machine& machine, const config::Station& station,
                                   const StationSii& found) {
  if (station.accepted) return check_accepted(machine, station, *station.accepted, found);
  const config::Identity& expected = station.profile.identity;
  const std::string found_text = device(found.vendor, found.product, found.revision);
  if (config::same_device(expected, found)) {
    if (expected.revision == found.revision || expected.assumed) return std::string{};
    return fmt::format("{}: revision {:08X}h instead of {:08X}h", where(station), found.revision, expected.revision);
  }
  const auto other = std::find_if(machine.stations.begin(), machine.stations.end(), [&](const auto& s) {
    return s.bus == config::BusKind::EtherCat && config::same_device(s.profile.identity, found);
  });
  const std::string expected_text =
      fmt::format("{} ({})", station.profile.title, device(expected.vendor, expected.product, expected.revision));
  if (other != machine.stations.end())
    return fail(Fault::IdentityMismatch,
                fmt::format("position {} should be '{}', a {}, but a {} stands there ({}); correct the wiring or the "
                            "order in the machine file",
                            station.position, station.name, expected_text, other->profile.title, found_text),
                where(station));
  return fail(Fault::IdentityMismatch,
              fmt::format("position {} should be '{}', a {}, but has {}{}", station.position, station.name,
                          expected_text, found_text,
                          expected.assumed ? fmt::format("; the expected one is assumed: if this is the drive, `gantry "
                                                         "commission {} --accept`",
                                                         station.name)
                                           : ""),
              where(station));
}

Result<void> check_alias(const config::Machine& machine, const config::Station& station, const StationRecord& found) {
  if (config::alias_fits(station, found.alias)) return {};
  const auto other = std::find_if(machine.stations.begin(), machine.stations.end(), [&](const auto& s) {
    return s.bus == config::BusKind::EtherCat && s.alias != 0 && s.alias == found.alias;
  });
  const std::string whose =
      other != machine.stations.end()
          ? fmt::format(", which is that of '{}'; correct the wiring, or the switches", other->name)
          : "; set its switches, and what its page in docs/drives asks for besides, then switch its supply off and on: "
            "a "
            "station reads them as its supply comes";
  return fail(Fault::IdentityMismatch,
              fmt::format("position {} should be '{}' with alias {}, but has alias {}{}", station.position,
                          station.name, station.alias, found.alias, whose),
              where(station));
}

Result<void> check_count(const config::Machine& machine, std::size_t count) {
  const auto configured = on_ethercat(machine);
  if (count == configured.size()) return {};
  const std::string both = fmt::format("{} stations answer, the machine file has {}", count, configured.size());
  if (count > configured.size())
    return fail(Fault::StationMissing,
                both +
                    "; `gantry bus scan` shows which of them it does not have: take it out of the line, or write it "
                    "into the machine file",
                machine.file);
  return fail(Fault::StationMissing,
              fmt::format("{}; the first that is missing is '{}' at position {}: look at its supply and its cable",
                          both, configured[count]->name, count),
              where(*configured[count]));
}

namespace {

/// Whether they are what the machine file has in their places, and how they are to be set up. `configured` is empty
/// where anybody is taken.
Result<void> confirm(Link& link, const config::Machine& machine, const std::vector<const config::Station*>& configured,
                     std::vector<StationRecord>& records, std::vector<std::string>& notes) {
  const bool anybody = configured.empty();
  if (!anybody)
    if (auto ok = check_count(machine, records.size()); !ok) return ok;
  for (std::size_t i = 0; i < records.size(); ++i) {
    StationRecord& r = records[i];
    const auto located = [&](Error e) {
      if (e.where.empty()) e.where = r.where;
      return tl::unexpected(std::move(e));
    };
    if (!anybody) {
      r.config = configured[i];
      r.id = r.config->id;
      r.where = where(*r.config);
    }
    if (auto ok = wait_for_state(link, r, AlState::Init); !ok) return located(ok.error());
    if (!r.sii.read) return located({Fault::SiiInvalid, r.sii.damage, {}});
    if (anybody)
      if (auto ok = read_whole_sii(link, r); !ok) return located(ok.error());
    r.vendor = r.sii.vendor, r.product = r.sii.product, r.revision = r.sii.revision, r.serial = r.sii.serial;
    if (!r.sii.damage.empty()) notes.push_back(r.where + ": SII EEPROM: " + r.sii.damage);
    if (anybody) {
      plan_from_sii(r);
    } else {
      auto note = check_identity(machine, *r.config, r.sii);
      if (!note) return tl::unexpected(note.error());
      if (auto ok = check_alias(machine, *r.config, r); !ok) return tl::unexpected(ok.error());
      if (!note->empty()) notes.push_back(std::move(*note));
      plan_from_profile(r, r.config->profile);
      if (r.config->profile.dc && !r.sync0)
        notes.push_back(r.where +
                        ": its EEPROM names no mode with SYNC0, so it takes its outputs when they come in, and "
                        "not at the same instant as the others");
    }
    r.lrw = r.lrw && (r.esc.features & kFeatureNoLrw) == 0;
  }
  return {};
}

}  // namespace

Result<std::vector<StationRecord>> scan(Link& link, const config::Machine& machine, bool strangers,
                                        std::vector<std::string>& notes) {
  const auto configured = on_ethercat(machine);
  const bool anybody = strangers && configured.empty();
  // Counted before anything is written: a bus with another number of stations stays as it is.
  const auto count = count_stations(link);
  if (!count) return tl::unexpected(count.error());
  if (!anybody)
    if (auto ok = check_count(machine, static_cast<std::size_t>(*count)); !ok) return tl::unexpected(ok.error());
  if (auto ok = reset_stations(link); !ok) return tl::unexpected(ok.error());
  auto records = find_stations(link);
  if (!records) return records;
  if (auto ok = confirm(link, machine, configured, *records, notes); !ok) {
    give_back_addresses(link, *records);
    return tl::unexpected(ok.error());
  }
  return records;
}

}  // namespace gantry::devices
