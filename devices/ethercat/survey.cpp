#include "devices/ethercat/survey.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <utility>

#include "devices/ethercat/identity_object.hpp"
#include "devices/ethercat/scan.hpp"
#include "devices/ethercat/station_objects.hpp"
#include "devices/ethercat/station_registers.hpp"
#include "devices/wire/coe.hpp"

namespace gantry::devices {
namespace {

using namespace wire;

constexpr int kMostPdos = 64, kMostEntries = 254;

/// A number of 1, 2 or 4 bytes; a station may have another size than the standard says.
Result<std::uint32_t> read_small(Link& link, StationRecord& s, config::ObjectAddress object) {
  const auto bytes = sdo_upload(link, s, object);
  if (!bytes) return tl::unexpected(bytes.error());
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < std::min<std::size_t>(bytes->size(), 4); ++i)
    value |= std::to_integer<std::uint32_t>((*bytes)[i]) << (8 * i);
  return value;
}

std::string sii_name(const StationRecord& s, std::uint16_t index) {
  for (const auto* pdos : {&s.sii.rx_pdos, &s.sii.tx_pdos})
    for (const SiiPdo& pdo : *pdos)
      if (pdo.index == index) return pdo.name;
  return {};
}

PdoMap default_map(const StationRecord& s) {
  PdoMap map;
  const auto add = [&](const std::vector<SiiPdo>& pdos, bool outputs) {
    for (const SiiPdo& p : pdos) {
      if (p.sync_manager == sii::kNoSyncManager) continue;
      MappedPdo pdo{p.index, p.sync_manager, outputs, p.name, {}};
      for (const SiiPdoEntry& e : p.entries) pdo.entries.push_back({e.address, e.bit_length});
      map.pdos.push_back(std::move(pdo));
    }
  };
  add(s.sii.rx_pdos, true);
  add(s.sii.tx_pdos, false);
  return map;
}

}  // namespace

std::size_t MappedPdo::bits() const {
  std::size_t n = 0;
  for (const auto& e : entries) n += e.bit_length;
  return n;
}

Result<void> read_mapping(Link& link, StationRecord& s, std::uint16_t index, PdoMap& map) {
  MappedPdo pdo{.index = index, .sync_manager = 0, .outputs = false, .name = sii_name(s, index), .entries = {}};
  const auto entries = read_small(link, s, {index, 0});
  if (!entries) return tl::unexpected(entries.error());
  for (std::uint32_t e = 1; e <= std::min<std::uint32_t>(*entries, kMostEntries); ++e) {
    const auto row = read_small(link, s, {index, static_cast<std::uint8_t>(e)});
    if (!row) return tl::unexpected(row.error());
    pdo.entries.push_back({{static_cast<std::uint16_t>(*row >> 16), static_cast<std::uint8_t>(*row >> 8 & 0xFF)},
                           static_cast<std::uint8_t>(*row & 0xFF)});
  }
  map.pdos.push_back(std::move(pdo));
  return {};
}

Result<void> read_assigned(Link& link, StationRecord& s, std::uint8_t number, bool outputs, PdoMap& map) {
  const auto assign = static_cast<std::uint16_t>(object::kSyncManagerAssign0 + number);
  const auto count = read_small(link, s, {assign, 0});
  if (!count) return tl::unexpected(count.error());
  for (std::uint32_t i = 1; i <= std::min<std::uint32_t>(*count, kMostPdos); ++i) {
    const auto index = read_small(link, s, {assign, static_cast<std::uint8_t>(i)});
    if (!index) return tl::unexpected(index.error());
    if (*index == 0) continue;
    if (auto ok = read_mapping(link, s, static_cast<std::uint16_t>(*index), map); !ok) return ok;
    map.pdos.back().sync_manager = number;
    map.pdos.back().outputs = outputs;
  }
  return {};
}

Result<PdoMap> read_pdo_map(Link& link, StationRecord& s) {
  if (!s.has_coe()) return default_map(s);
  PdoMap map;
  map.from_objects = true;
  for (std::size_t i = 0; i < s.sync_managers.size(); ++i) {
    const SyncManagerPlan& sm = s.sync_managers[i];
    const bool outputs = sm.is(config::SyncManagerKind::ProcessOut);
    if (!outputs && !sm.is(config::SyncManagerKind::ProcessIn)) continue;
    auto ok = read_assigned(link, s, static_cast<std::uint8_t>(i), outputs, map);
    if (ok) continue;
    if (ok.error().fault != Fault::SdoAbort) return tl::unexpected(ok.error());
    return default_map(s);  // CoE without the assignment objects: the EEPROM says it
  }
  return map;
}

void Survey::give_back() { give_back_addresses(link_, stations_); }

Result<std::vector<FoundStation>> Survey::scan() {
  give_back();
  stations_.clear();
  auto records = find_stations(link_);
  if (!records) return tl::unexpected(records.error());
  std::vector<FoundStation> found;
  for (StationRecord& r : *records) {
    if (auto whole = r.sii.read ? read_whole_sii(link_, r) : Result<void>{}; !whole) {
      if (whole.error().fault != Fault::SiiInvalid) return tl::unexpected(whole.error());
      r.sii.add_damage(whole.error().message);
    }
    plan_from_sii(r);
    const auto al = read_al_status(link_, r);
    if (!al) return tl::unexpected(al.error());
    found.push_back({r, *al});
  }
  stations_ = std::move(*records);
  return found;
}

Result<StationRecord*> Survey::station(int position) {
  if (stations_.empty())
    if (auto found = scan(); !found) return tl::unexpected(found.error());
  if (position < 0 || position >= static_cast<int>(stations_.size()))
    return fail(Fault::StationMissing,
                fmt::format("there is no station {}; {} answer, the first is 0", position, stations_.size()));
  return &stations_[static_cast<std::size_t>(position)];
}

Result<StationRecord*> Survey::with_mailbox(int position) {
  auto s = station(position);
  if (!s) return s;
  StationRecord& r = **s;
  if (!r.has_mailbox())
    return fail(Fault::MailboxProtocol, "the station has no mailbox, so it has no objects to read", r.where);
  const auto al = read_al_status(link_, r);
  if (!al) return tl::unexpected(al.error());
  if (al->state == AlState::Boot)
    return fail(Fault::MailboxProtocol, "the station is in BOOT; take it to INIT first", r.where);
  if (al->state != AlState::Init) {
    // Somebody has opened the mailbox: it is where they put it, and they have counted requests.
    if (r.mailbox.request_counter == 0 && r.mailbox.count == MailboxState::Count::Ours)
      r.mailbox.count = MailboxState::Count::Foreign;
    for (std::size_t i = 0; i < r.sync_managers.size(); ++i) {
      if (!r.sync_managers[i].is_mailbox()) continue;
      std::array<std::byte, kSyncManagerBytes> raw{};
      const auto at = static_cast<std::uint16_t>(reg::kSyncManager0 + kSyncManagerBytes * i);
      if (auto ok = link_.read(r.address, at, raw); !ok) return tl::unexpected(ok.error());
      const SyncManager now = get_sync_manager(raw);
      r.sync_managers[i].registers.start = now.start;
      r.sync_managers[i].registers.length = now.length;
      if (!r.sync_managers[i].is(config::SyncManagerKind::MailboxIn)) continue;
      r.mailbox.repeat_toggle = (now.activate & kSmActivateRepeatRequest) != 0;
    }
    return s;
  }
  if (al->error)
    if (auto ok = acknowledge(link_, r); !ok) return tl::unexpected(ok.error());
  r.mailbox = {};
  if (auto ok = write_mailbox_setup(link_, r); !ok) return tl::unexpected(ok.error());
  if (auto ok = hand_over_eeprom(link_, r); !ok) return tl::unexpected(ok.error());
  if (auto ok = request_state(link_, r, AlState::PreOp); !ok) return tl::unexpected(ok.error());
  if (auto ok = wait_for_state(link_, r, AlState::PreOp); !ok) return tl::unexpected(ok.error());
  const std::size_t capacity = find_sync_manager(r, config::SyncManagerKind::MailboxOut, nullptr)->length;
  if (capacity < kMailboxHeader)
    return fail(Fault::MailboxProtocol, "the station's mailbox is smaller than a header", r.where);
  return s;
}

Result<PdoMap> Survey::read_pdo_map(int position) {
  auto s = station(position);
  if (!s) return tl::unexpected(s.error());
  if ((*s)->has_coe()) s = with_mailbox(position);
  if (!s) return tl::unexpected(s.error());
  return devices::read_pdo_map(link_, **s);
}

Result<std::vector<ObjectDescription>> Survey::object_list(int position, bool with_entries) {
  auto s = with_mailbox(position);
  if (!s) return tl::unexpected(s.error());
  return read_object_list(link_, **s, with_entries);
}

Result<EntryDescription> Survey::describe_entry(int position, config::ObjectAddress object) {
  auto s = with_mailbox(position);
  if (!s) return tl::unexpected(s.error());
  return devices::describe_entry(link_, **s, object);
}

Result<Bytes> Survey::read_object(int position, config::ObjectAddress object, SdoAccess access) {
  auto s = with_mailbox(position);
  if (!s) return tl::unexpected(s.error());
  return sdo_upload(link_, **s, object, access);
}

Result<void> Survey::write_object(int position, config::ObjectAddress object, std::span<const std::byte> value,
                                  SdoAccess access) {
  auto s = with_mailbox(position);
  if (!s) return tl::unexpected(s.error());
  return sdo_download(link_, **s, object, value, access);
}

Result<config::ObjectIdentity> Survey::read_identity_object(int position) {
  auto s = station(position);
  if (!s) return tl::unexpected(s.error());
  if (!(*s)->has_coe()) return config::ObjectIdentity{};
  s = with_mailbox(position);
  if (!s) return tl::unexpected(s.error());
  return devices::read_identity_object(link_, **s);
}

Result<void> Survey::confirm(int position, const config::Machine& machine, const config::Station& station) {
  auto s = this->station(position);
  if (!s) return tl::unexpected(s.error());
  if (auto ok = check_identity(machine, station, (*s)->sii); !ok) return tl::unexpected(ok.error());
  if (auto ok = check_alias(machine, station, **s); !ok) return ok;
  if (!(*s)->has_coe()) return {};
  s = with_mailbox(position);
  if (!s) return tl::unexpected(s.error());
  (*s)->config = &station;
  auto ok = check_identity_object(link_, **s);
  (*s)->config = nullptr;
  if (!ok) ok.error().where = where(station);
  return ok;
}

Result<HeldObject> Survey::read_held(int position, const config::StartupRow& row) {
  auto s = with_mailbox(position);
  if (!s) return tl::unexpected(s.error());
  return devices::read_held(link_, **s, row);
}

Result<std::vector<config::StartupRow>> Survey::asked_of(int position, const config::Station& station,
                                                         std::vector<std::string>& notes) {
  const auto s = with_mailbox(position);
  if (!s) return tl::unexpected(s.error());
  StationRecord& record = **s;
  record.config = &station;
  record.startup = station.profile.startup;
  const auto ok = leave_out_absent(link_, record, notes);
  record.config = nullptr;
  auto rows = std::exchange(record.startup, {});
  if (!ok) return tl::unexpected(ok.error());
  return rows;
}

Result<void> Survey::forget_restart(int position) {
  const auto s = with_mailbox(position);
  if (!s) return tl::unexpected(s.error());
  (*s)->since_power_up = false;
  return {};
}

Result<void> Survey::write_held(int position, const config::StartupRow& row, std::size_t bytes) {
  auto s = with_mailbox(position);
  if (!s) return tl::unexpected(s.error());
  if (row.acts == config::ActsAt::PowerUp)
    if (auto ok = forget_restart(position); !ok) return ok;
  return devices::write_held(link_, **s, row, bytes);
}

Result<void> Survey::save_parameters(int position, const config::StationProfile& profile,
                                     std::span<const config::ObjectAddress> written) {
  auto s = with_mailbox(position);
  if (!s) return tl::unexpected(s.error());
  return devices::save_parameters(link_, **s, profile, written);
}

Result<AlStatus> Survey::al_status(int position) {
  const auto s = station(position);
  if (!s) return tl::unexpected(s.error());
  return read_al_status(link_, **s);
}

Result<std::vector<ErrorCounters>> Survey::error_counters() {
  if (auto s = station(0); !s) return tl::unexpected(s.error());
  std::vector<ErrorCounters> all;
  for (const StationRecord& s : stations_) {
    const auto counters = read_error_counters(link_, s);
    if (!counters) return tl::unexpected(counters.error());
    all.push_back(*counters);
  }
  return all;
}

Result<std::vector<DcStatus>> Survey::dc_status() {
  if (auto s = station(0); !s) return tl::unexpected(s.error());
  std::vector<DcStatus> all;
  for (const StationRecord& s : stations_) {
    const auto status = read_dc_status(link_, s);
    if (!status) return tl::unexpected(status.error());
    all.push_back(*status);
  }
  return all;
}

Result<WireCheck> Survey::check_wire(int frames) {
  constexpr int kMailboxReads = 8;
  constexpr config::ObjectAddress kDeviceType{0x1000, 0};
  if (auto s = station(0); !s) return tl::unexpected(s.error());
  CyclicCounts counters;
  for (int i = 0; i < frames; ++i) {
    std::array<std::byte, 2> states{};
    const auto counter = link_.transact(Command::Brd, physical_address(0, reg::kAlStatus), states, 1);
    if (!counter) continue;  // it is counted as lost
    counters.wkc_zero += *counter == 0;
    counters.wkc_low += *counter != 0 && *counter < stations_.size();
    counters.wkc_high += *counter > stations_.size();
  }
  WireCheck check;
  for (const StationRecord& s : stations_) {
    const auto al = read_al_status(link_, s);
    const bool open = al && al->state != AlState::Init && al->state != AlState::Boot && s.sii.has_coe();
    for (int i = 0; open && i < kMailboxReads; ++i)
      if (!read_object(s.position, kDeviceType))
        break;  // what it refuses, or does not answer, is no matter of the wire
    check.mailbox_repeats.push_back(s.mailbox_repeats);
  }
  check.frames = link_.counts();
  check.frames.wkc_zero = counters.wkc_zero;
  check.frames.wkc_low = counters.wkc_low;
  check.frames.wkc_high = counters.wkc_high;
  check.other_master = link_.other_master();
  return check;
}

std::vector<Emergency> Survey::take_emergencies(int position) {
  if (position < 0 || position >= static_cast<int>(stations_.size())) return {};
  return std::exchange(stations_[static_cast<std::size_t>(position)].mailbox.emergencies, {});
}

}  // namespace gantry::devices
