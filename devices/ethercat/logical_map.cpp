#include "devices/ethercat/logical_map.hpp"

#include <algorithm>
#include <fmt/format.h>

#include "devices/ethercat/layout_check.hpp"
#include "devices/profiles/map_pdos.hpp"
#include "devices/rt/cyclic.hpp"

namespace gantry::devices {
namespace {

using namespace wire;
using config::PdoRow;
using config::SyncManagerKind;

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

}  // namespace

Result<void> check_pdo_limits(const StationRecord& s) {
  for (const auto* pdos : {&s.rx_pdos, &s.tx_pdos})
    if (auto ok = check_limits(s, *pdos); !ok) return ok;
  return {};
}

namespace {

/// What one SyncManager carries of a direction.
struct Part {
  std::size_t number, bits;
  [[nodiscard]] std::size_t bytes() const { return (bits + 7) / 8; }
};

/// PDOs by their SyncManagers, in the order of those. Where no PDOs are known, the lengths of its SyncManagers count.
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
  // The offsets of a profile's objects are counted over all PDOs, one behind the other.
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

}  // namespace gantry::devices
