#include "devices/ethercat/layout_check.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <map>

#include "devices/ethercat/scan.hpp"
#include "devices/ethercat/survey.hpp"
#include "devices/profiles/map_pdos.hpp"

namespace gantry::devices {
namespace {

using namespace wire;
using config::PdoRow;
using config::SyncManagerKind;

constexpr std::size_t kBytesPerKilobyte = 1024;

/// What a SyncManager takes of the ESC's memory.
struct Area {
  std::size_t number, from, to, length, buffers;
  [[nodiscard]] std::string text() const {
    return fmt::format("SM{} ({:04X}h, {} x {} bytes)", number, from, buffers, length);
  }
};

std::vector<Area> areas(const StationRecord& s) {
  std::vector<Area> used;
  for (std::size_t i = 0; i < s.sync_managers.size(); ++i) {
    const SyncManager& sm = s.sync_managers[i].registers;
    if ((sm.activate & kSmActivateEnable) == 0 || sm.length == 0) continue;
    // Below the process RAM lie the digital outputs and the user RAM: one buffer.
    const bool three = (sm.control & kSmBufferMask) != kSmMailboxMode && sm.start >= reg::kProcessRam;
    const std::size_t buffers = three ? 3 : 1;
    used.push_back({i, sm.start, sm.start + buffers * sm.length, sm.length, buffers});
  }
  return used;
}

tl::unexpected<Error> cannot(const StationRecord& s, std::string text) {
  return fail(Fault::Inconsistent, std::move(text), s.where);
}

}  // namespace

Result<void> check_areas(const StationRecord& s) {
  // An ESC that leaves these at 0 does not say.
  if (s.esc.sync_managers != 0 && s.sync_managers.size() > s.esc.sync_managers)
    return cannot(s, fmt::format("{} SyncManagers are to be written, its ESC has {}", s.sync_managers.size(),
                                 s.esc.sync_managers));
  if (s.esc.fmmus != 0 && s.fmmus.size() > s.esc.fmmus)
    return cannot(s, fmt::format("{} FMMUs are to be written, its ESC has {}", s.fmmus.size(), s.esc.fmmus));
  const auto used = areas(s);
  const std::size_t end = reg::kProcessRam + kBytesPerKilobyte * s.esc.ram_kB;
  for (std::size_t i = 0; i < used.size(); ++i) {
    if (s.esc.ram_kB != 0 && used[i].to > end)
      return cannot(s, fmt::format("{} reaches over the end of its RAM at {:04X}h", used[i].text(), end));
    for (std::size_t k = 0; k < i; ++k)
      if (used[i].from < used[k].to && used[k].from < used[i].to)
        return cannot(s, fmt::format("{} and {} lie over each other", used[k].text(), used[i].text()));
  }
  return {};
}

namespace {

struct Direction {
  SyncManagerKind kind;
  bool outputs;
  std::span<const PdoRow> ours;
  std::size_t our_bytes;
};

tl::unexpected<Error> differs(const StationRecord& s, const Direction& d, std::size_t theirs, std::string_view source) {
  return fail(Fault::PdoMappingDiffers,
              fmt::format("its {} are {} bytes by {}, and {} bytes by the profile {}; correct the profile",
                          d.outputs ? "outputs" : "inputs", theirs, source, d.our_bytes, s.title),
              s.where);
}

/// Bytes of bits that are counted by SyncManager: each of them begins with a new byte.
std::size_t bytes(const std::map<int, std::size_t>& bits) {
  std::size_t n = 0;
  for (const auto& [sync_manager, count] : bits) n += (count + 7) / 8;
  return n;
}

/// The objects of the profile lie where the station has them. Gaps are nobody's.
Result<void> compare_entries(const StationRecord& s, const Direction& d, const PdoMap& map) {
  std::map<int, std::size_t> bits;
  for (const MappedPdo& pdo : map.pdos)
    if (pdo.outputs == d.outputs) bits[pdo.sync_manager] += pdo.bits();
  if (bytes(bits) != d.our_bytes) return differs(s, d, bytes(bits), "its objects");
  for (const PdoRow& pdo : d.ours)
    for (const auto& entry : pdo.entries) {
      if (entry.address.index == 0) continue;
      std::optional<std::size_t> there;
      std::size_t at = 0;
      for (const MappedPdo& theirs : map.pdos)
        for (const auto& e : theirs.entries) {
          if (theirs.outputs != d.outputs) continue;
          if (e.address == entry.address && e.bit_length == entry.bit_length && !there) there = at;
          at += e.bit_length;
        }
      const auto here = find_mapped(d.ours, entry.address);
      if (!there || there != here)
        return fail(Fault::PdoMappingDiffers,
                    fmt::format("{:04X}h:{:02X} with {} bits {} in its fixed mapping, and begins at bit {} in the "
                                "profile {}; correct the profile",
                                entry.address.index, entry.address.sub, entry.bit_length,
                                there ? fmt::format("begins at bit {}", *there) : "is not", here.value_or(0), s.title),
                    s.where);
    }
  return {};
}

/// Bytes by the EEPROM: the SyncManagers' default lengths, or where those are 0, the PDOs. Nothing: it does not say.
std::optional<std::size_t> eeprom_bytes(const StationSii& sii, const Direction& d) {
  std::size_t lengths = 0;
  for (const SiiSyncManager& sm : sii.sync_managers)
    if (sm.type == static_cast<std::uint8_t>(d.kind)) lengths += sm.registers.length;
  if (lengths != 0) return lengths;
  std::map<int, std::size_t> bits;
  for (const SiiPdo& pdo : d.outputs ? sii.rx_pdos : sii.tx_pdos)
    if (pdo.sync_manager != sii::kNoSyncManager)
      for (const SiiPdoEntry& e : pdo.entries) bits[pdo.sync_manager] += e.bit_length;
  return bytes(bits) != 0 ? std::optional(bytes(bits)) : std::nullopt;
}

}  // namespace

Result<void> check_fixed_map(Link& link, StationRecord& s) {
  if (s.config == nullptr || s.writes_mapping) return {};
  const std::array directions{Direction{SyncManagerKind::ProcessOut, true, s.rx_pdos, s.output_bytes},
                              Direction{SyncManagerKind::ProcessIn, false, s.tx_pdos, s.input_bytes}};
  if (s.has_coe()) {
    const auto map = read_pdo_map(link, s);
    if (!map) return tl::unexpected(map.error());
    if (map->from_objects) {
      for (const Direction& d : directions)
        if (auto ok = compare_entries(s, d, *map); !ok) return ok;
      return {};
    }
  }
  if (auto ok = read_whole_sii(link, s); !ok) return ok;
  for (const Direction& d : directions)
    if (const auto theirs = eeprom_bytes(s.sii, d); theirs && *theirs != d.our_bytes)
      return differs(s, d, *theirs, "its EEPROM");
  return {};
}

}  // namespace gantry::devices
