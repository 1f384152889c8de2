#include "devices/ethercat/mapping.hpp"

#include <algorithm>
#include <fmt/format.h>

#include "devices/ethercat/layout_check.hpp"
#include "devices/ethercat/sdo.hpp"
#include "devices/profiles/map_pdos.hpp"
#include "devices/profiles/object_value.hpp"
#include "devices/rt/cyclic.hpp"
#include "devices/wire/coe.hpp"

namespace gantry::devices {
namespace {

using namespace wire;
using config::ObjectType;
using config::PdoRow;
using config::SyncManagerKind;

constexpr std::uint16_t kWatchdogUnitsPerMs = 10;  // of 100 us each

Result<void> check_limits(const StationRecord& s, std::span<const PdoRow> pdos) {
  for (const auto& pdo : pdos) {
    const std::size_t bytes = image_bytes(std::span(&pdo, 1));
    const bool entries_ok = s.max_pdo_entries <= 0 || pdo.entries.size() <= static_cast<std::size_t>(s.max_pdo_entries);
    const bool bytes_ok = s.max_pdo_bytes <= 0 || bytes <= static_cast<std::size_t>(s.max_pdo_bytes);
    if (!entries_ok || !bytes_ok)
      return fail(Fault::PdoMappingDiffers,
                  fmt::format("PDO {:04X}h has {} entries and {} bytes; {} takes {} and {}", pdo.index,
                              pdo.entries.size(), bytes, s.title, s.max_pdo_entries, s.max_pdo_bytes),
                  s.where);
  }
  return {};
}

/// What one SyncManager carries of a direction.
struct Part {
  std::size_t number, bits;
  [[nodiscard]] std::size_t bytes() const { return (bits + 7) / 8; }
};

/// PDOs by their SyncManagers, in the order of those. A station that tells no PDOs has its SyncManagers' lengths.
Result<std::vector<Part>> parts(const StationRecord& s, SyncManagerKind kind) {
  const bool out = kind == SyncManagerKind::ProcessOut;
  const auto& pdos = out ? s.rx_pdos : s.tx_pdos;
  const auto& assigned = out ? s.rx_sync_managers : s.tx_sync_managers;
  std::vector<Part> all;
  for (std::size_t i = 0; i < s.sync_managers.size(); ++i)
    if (s.sync_managers[i].is(kind))
      all.push_back(
          {i, pdos.empty() && s.config == nullptr ? 8 * std::size_t{s.sync_managers[i].registers.length} : 0});
  for (std::size_t n = 0; n < pdos.size(); ++n) {
    if (all.empty() && image_bytes(pdos) != 0)
      return fail(Fault::Inconsistent, fmt::format("'{}' maps PDOs but has no SyncManager for them", s.title), s.where);
    if (all.empty()) break;
    auto carrier = std::find_if(all.begin(), all.end(),
                                [&](const Part& p) { return n < assigned.size() && p.number == assigned[n]; });
    if (carrier == all.end()) carrier = all.begin();
    for (const auto& entry : pdos[n].entries) carrier->bits += entry.bit_length;
  }
  std::erase_if(all, [](const Part& p) { return p.bits == 0; });
  // The places of a profile's objects are counted over all PDOs, one behind the other.
  for (std::size_t i = 0; s.config != nullptr && i + 1 < all.size(); ++i)
    if (all[i].bits % 8 != 0)
      return fail(Fault::Inconsistent,
                  fmt::format("the PDOs of SM{} fill {} bits; those of several SyncManagers have to fill whole bytes",
                              all[i].number, all[i].bits),
                  s.where);
  return all;
}

std::size_t sum(const std::vector<Part>& all) {
  std::size_t bytes = 0;
  for (const Part& p : all) bytes += p.bytes();
  return bytes;
}

/// Each SyncManager of a direction gets its length and an FMMU.
void map_direction(StationRecord& s, SyncManagerKind kind, const std::vector<Part>& all, std::uint32_t logical) {
  const bool out = kind == SyncManagerKind::ProcessOut;
  for (const Part& part : all) {
    SyncManager& sm = s.sync_managers[part.number].registers;
    sm.length = static_cast<std::uint16_t>(part.bytes());
    sm.activate = kSmActivateEnable;
    // Whatever an EEPROM says: outputs that nobody watches would stay on when the bus is lost.
    if (out) sm.control |= kSmWatchdogTrigger;
    s.fmmus.push_back({.logical_start = logical,
                       .length = sm.length,
                       .physical_start = sm.start,
                       .type = static_cast<std::uint8_t>(out ? FmmuType::Write : FmmuType::Read),
                       .active = true});
    logical += sm.length;
  }
}

}  // namespace

Result<ImageSize> lay_out(std::vector<StationRecord>& stations, std::uint32_t logical_start, MapKind kind) {
  ImageSize size;
  std::uint32_t logical = logical_start;
  for (auto& s : stations) {
    for (const auto* pdos : {&s.rx_pdos, &s.tx_pdos})
      if (auto ok = check_limits(s, *pdos); !ok) return tl::unexpected(ok.error());
    const auto out = parts(s, SyncManagerKind::ProcessOut), in = parts(s, SyncManagerKind::ProcessIn);
    for (const auto* direction : {&out, &in})
      if (!*direction) return tl::unexpected(direction->error());
    s.output_bytes = sum(*out);
    s.input_bytes = sum(*in);
    s.output_offset = size.output_bytes;
    s.input_offset = size.input_bytes;
    size.output_bytes += s.output_bytes;
    size.input_bytes += s.input_bytes;

    s.logical = logical;
    s.input_at = kind == MapKind::Overlapped ? 0 : s.output_bytes;
    s.region_bytes =
        kind == MapKind::Overlapped ? std::max(s.output_bytes, s.input_bytes) : s.output_bytes + s.input_bytes;
    if (s.region_bytes > CyclicLayout::kMaxBytes)
      return fail(
          Fault::Inconsistent,
          fmt::format("its process data are {} bytes; a frame carries {}", s.region_bytes, CyclicLayout::kMaxBytes),
          s.where);
    logical += static_cast<std::uint32_t>(s.region_bytes);
    s.fmmus.clear();
    map_direction(s, SyncManagerKind::ProcessOut, *out, s.logical);
    map_direction(s, SyncManagerKind::ProcessIn, *in, s.logical + static_cast<std::uint32_t>(s.input_at));
    if (auto ok = check_areas(s); !ok) return tl::unexpected(ok.error());
  }
  return size;
}

namespace {

std::uint16_t sm_register(std::size_t number, std::size_t byte) {
  return static_cast<std::uint16_t>(reg::kSyncManager0 + kSyncManagerBytes * number + byte);
}

Result<void> write_sync_manager(Link& link, const StationRecord& s, std::size_t number) {
  SyncManager registers = s.sync_managers[number].registers;
  if (s.sync_managers[number].is(SyncManagerKind::MailboxIn) && s.mailbox.repeat_toggle)
    registers.activate |= kSmActivateRepeatRequest;
  const auto raw = to_bytes(registers);
  return link.write(s.address, sm_register(number, 0), std::span<const std::byte>(raw));
}

}  // namespace

Result<void> write_mailbox_setup(Link& link, StationRecord& s) {
  for (std::size_t i = 0; i < s.sync_managers.size(); ++i) {
    if (!s.sync_managers[i].is_mailbox()) continue;
    if (s.sync_managers[i].is(SyncManagerKind::MailboxIn)) {
      // The request bit begins as the station has acknowledged it last: a difference would ask it to repeat a message
      // of the time before.
      const auto acknowledged = link.read<std::uint8_t>(s.address, sm_register(i, kSmPdiControlOffset));
      if (!acknowledged) return tl::unexpected(acknowledged.error());
      s.mailbox.repeat_toggle = (*acknowledged & kSmPdiRepeatAck) != 0;
    }
    if (auto ok = write_sync_manager(link, s, i); !ok) return ok;
  }
  return {};
}

Result<void> write_startup(Link& link, StationRecord& s) {
  for (const auto& row : s.startup) {
    if (row.compare_first) {
      const auto value = read_number(link, s, row.address, row.type);
      if (!value) return tl::unexpected(value.error());
      if (to_bytes(row.type, *value) == to_bytes(row.type, row.value)) continue;
    }
    if (auto ok = write_number(link, s, row.address, row.type, row.value); !ok) return ok;
  }
  return {};
}

namespace {

struct Write {
  config::ObjectAddress object;
  ObjectType type;
  std::int64_t value;
};

/// What is written for one direction, in order.
std::vector<Write> mapping_writes(std::uint16_t assign, std::span<const PdoRow> pdos) {
  std::vector<Write> w{{{assign, 0}, ObjectType::U8, 0}};
  for (const auto& pdo : pdos) {
    w.push_back({{pdo.index, 0}, ObjectType::U8, 0});
    std::uint8_t sub = 0;
    for (const auto& entry : pdo.entries) {
      const auto& [index, object_sub] = entry.address;
      w.push_back({{pdo.index, ++sub}, ObjectType::U32, mapping_entry(index, object_sub, entry.bit_length)});
    }
    w.push_back({{pdo.index, 0}, ObjectType::U8, sub});
  }
  std::uint8_t sub = 0;
  for (const auto& pdo : pdos) w.push_back({{assign, ++sub}, ObjectType::U16, pdo.index});
  w.push_back({{assign, 0}, ObjectType::U8, sub});
  return w;
}

Result<void> read_back(Link& link, StationRecord& s, const std::vector<Write>& writes) {
  for (auto w = writes.begin(); w != writes.end(); ++w) {
    const bool written_again = std::any_of(w + 1, writes.end(), [&](const Write& l) { return l.object == w->object; });
    if (written_again) continue;
    const auto value = read_number(link, s, w->object, w->type);
    if (!value) return tl::unexpected(value.error());
    if (*value != w->value)
      return fail(Fault::PdoMappingDiffers,
                  fmt::format("{:04X}h:{:02X} reads back as {:X}h, written was {:X}h", w->object.index, w->object.sub,
                              *value, w->value),
                  s.where);
  }
  return {};
}

}  // namespace

Result<void> write_pdo_mapping(Link& link, StationRecord& s) {
  if (!s.writes_mapping) return {};
  struct Direction {
    std::uint16_t assign;
    std::span<const PdoRow> pdos;
  };
  for (const auto& d : {Direction{object::kRxPdoAssign, s.rx_pdos}, Direction{object::kTxPdoAssign, s.tx_pdos}}) {
    const auto writes = mapping_writes(d.assign, d.pdos);
    for (const auto& w : writes)
      if (auto ok = write_number(link, s, w.object, w.type, w.value); !ok) return ok;
    if (auto ok = read_back(link, s, writes); !ok) return ok;
  }
  return {};
}

namespace {

Result<void> write_watchdog(Link& link, const StationRecord& s) {
  if (s.output_bytes == 0) return {};
  const auto units = static_cast<std::uint16_t>(s.watchdog_ms * kWatchdogUnitsPerMs);
  const auto off = [&] {
    return fail(Fault::WatchdogDisabled,
                "the process-data watchdog is off, so outputs would stay on when the bus is lost; set watchdog_ms in "
                "the profile, or see why the station does not take it",
                s.where);
  };
  if (units == 0) return off();
  if (auto ok = link.write<std::uint16_t>(s.address, reg::kWatchdogDivider, kWatchdogDivider100us); !ok) return ok;
  if (auto ok = link.write<std::uint16_t>(s.address, reg::kWatchdogTimeProcessData, units); !ok) return ok;
  const auto divider = link.read<std::uint16_t>(s.address, reg::kWatchdogDivider);
  if (!divider) return tl::unexpected(divider.error());
  const auto time = link.read<std::uint16_t>(s.address, reg::kWatchdogTimeProcessData);
  if (!time) return tl::unexpected(time.error());
  if (*divider != kWatchdogDivider100us || *time != units) return off();
  for (std::size_t i = 0; i < s.sync_managers.size(); ++i) {
    if (!s.sync_managers[i].is(SyncManagerKind::ProcessOut) || s.sync_managers[i].registers.length == 0) continue;
    const auto control = link.read<std::uint8_t>(s.address, sm_register(i, kSmControlOffset));
    if (!control) return tl::unexpected(control.error());
    if ((*control & kSmWatchdogTrigger) == 0) return off();
  }
  return {};
}

}  // namespace

Result<void> write_process_data(Link& link, const StationRecord& s) {
  for (std::size_t i = 0; i < s.sync_managers.size(); ++i)
    if (!s.sync_managers[i].is_mailbox())
      if (auto ok = write_sync_manager(link, s, i); !ok) return ok;
  for (std::size_t i = 0; i < s.fmmus.size(); ++i) {
    const auto raw = to_bytes(s.fmmus[i]);
    if (auto ok = link.write(s.address, static_cast<std::uint16_t>(reg::kFmmu0 + kFmmuBytes * i),
                             std::span<const std::byte>(raw));
        !ok)
      return ok;
  }
  return write_watchdog(link, s);
}

namespace {

/// One datagram over the logical region of each of these stations, with outputs of 0; the working counters.
Result<std::vector<int>> pass_over(Link& link, Command command, std::span<const StationRecord* const> stations) {
  std::vector<std::vector<std::byte>> data;
  std::vector<Datagram> batch;
  for (const auto* s : stations) data.emplace_back(s->region_bytes);
  for (std::size_t i = 0; i < stations.size(); ++i) batch.push_back({command, stations[i]->logical, data[i]});
  if (auto ok = link.transact(batch); !ok) return tl::unexpected(ok.error());
  std::vector<int> counters;
  for (const Datagram& d : batch) counters.push_back(d.working_counter);
  return counters;
}

}  // namespace

Result<int> try_lrw(Link& link, std::vector<StationRecord>& stations, std::vector<std::string>& notes) {
  std::vector<StationRecord*> asked, silent;
  for (auto& s : stations)
    if (s.lrw && s.region_bytes > 0) asked.push_back(&s);
  const auto lrw = pass_over(link, Command::Lrw, asked);
  if (!lrw) return tl::unexpected(lrw.error());
  for (std::size_t i = 0; i < asked.size(); ++i)
    if ((*lrw)[i] == 0) silent.push_back(asked[i]);
  if (silent.empty()) return 0;
  const auto lwr = pass_over(link, Command::Lwr, silent);
  if (!lwr) return tl::unexpected(lwr.error());
  const auto lrd = pass_over(link, Command::Lrd, silent);
  if (!lrd) return tl::unexpected(lrd.error());
  int changed = 0;
  for (std::size_t i = 0; i < silent.size(); ++i) {
    StationRecord& s = *silent[i];
    if ((*lwr)[i] != (s.output_bytes > 0 ? 1 : 0) || (*lrd)[i] != (s.input_bytes > 0 ? 1 : 0)) continue;
    s.lrw = false;
    ++changed;
    notes.push_back(s.where + ": takes no LRW and does not say so; its data go by LWR and LRD");
  }
  return changed;
}

}  // namespace gantry::devices
