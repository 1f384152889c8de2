#include "devices/profiles/map_pdos.hpp"

#include <algorithm>
#include <fmt/format.h>

#include "devices/profiles/drive_entries.hpp"
#include "devices/wire/cia402.hpp"

namespace gantry::devices {
namespace {

using config::ObjectAddress;
using config::PdoRow;
using config::StationProfile;
namespace cia = wire::cia402;

/// Finds an object's field; false when it is mapped so that the loop cannot use it.
template <class T>
bool find_field(const StationProfile& profile, std::span<const PdoRow> pdos, std::uint16_t index, int slot,
                PdoField<T>& field) {
  const auto at = find_bits(pdos, config::in_slot(profile, {index, 0}, slot));
  if (!at) return true;  // not mapped is a choice of the profile
  if (at->bit % 8 != 0 || at->bits != 8 * sizeof(T)) return false;
  field.offset = static_cast<std::int16_t>(at->bit / 8);
  return true;
}

}  // namespace

CodeMeaning meaning(const config::DriveErrorRow& row) {
  using enum config::DriveErrorKind;
  switch (row.kind) {
    case Warning: return {row.code, Fault::DriveWarning, true};
    case EmergencyInput: return {row.code, Fault::DriveEmergencyInput, true};
    case Limit: return {row.code, Fault::LimitSwitch, true};
    case Undervoltage: return {row.code, Fault::Undervoltage, false};
    case Fault:
    case PowerCycle: break;
  }
  return {row.code, gantry::Fault::DriveFault, false};
}

std::size_t image_bytes(std::span<const PdoRow> pdos) {
  std::size_t bits = 0;
  for (const auto& pdo : pdos)
    for (const auto& entry : pdo.entries) bits += entry.bit_length;
  return (bits + 7) / 8;
}

std::optional<MappedBits> find_bits(std::span<const PdoRow> pdos, ObjectAddress object) {
  std::size_t bit = 0;
  for (const auto& pdo : pdos)
    for (const auto& entry : pdo.entries) {
      if (entry.address == object) return MappedBits{bit, entry.bit_length};
      bit += entry.bit_length;
    }
  return std::nullopt;
}

std::optional<std::size_t> find_mapped(std::span<const PdoRow> pdos, ObjectAddress object) {
  const auto at = find_bits(pdos, object);
  return at ? std::optional(at->bit) : std::nullopt;
}

std::vector<PdoRow> loop_rows(const StationProfile& profile, bool outputs) {
  std::vector<PdoRow> rows = outputs ? profile.rx_pdos : profile.tx_pdos;
  if (!profile.drive) return rows;
  for (PdoRow& row : rows)
    for (config::PdoEntry& entry : row.entries) {
      const ObjectAddress first = config::first_slot(profile, entry.address, row.slot);
      const DriveEntry* e = first.sub == 0 ? find_drive_entry(first.index) : nullptr;
      if (e != nullptr && e->need != EntryNeed::EveryCycle) entry.bit_length = e->bits;
    }
  return rows;
}

bool as_loop_has_it(const StationProfile& profile) {
  const auto same = [&](bool outputs) {
    return std::ranges::equal(outputs ? profile.rx_pdos : profile.tx_pdos, loop_rows(profile, outputs),
                              [](const PdoRow& a, const PdoRow& b) {
                                return std::ranges::equal(a.entries, b.entries, {}, &config::PdoEntry::bit_length,
                                                          &config::PdoEntry::bit_length);
                              });
  };
  return same(true) && same(false);
}

Result<DriveLayout> map_drive(const StationProfile& profile, int slot) {
  if (!profile.drive || slot < 0 || slot >= profile.slots)
    return fail(Fault::Inconsistent, fmt::format("profile '{}' has no drive axis {}", profile.name, slot));
  const config::DriveFacts& facts = *profile.drive;
  const std::vector<PdoRow> out = loop_rows(profile, true), in = loop_rows(profile, false);

  DriveLayout l;
  std::uint16_t unusable = 0;
  const auto use = [&](std::span<const PdoRow> pdos, std::uint16_t index, auto& field) {
    if (unusable == 0 && !find_field(profile, pdos, index, slot, field)) unusable = index;
  };
  use(out, cia::kControlword, l.controlword);
  use(out, cia::kMode, l.mode);
  use(out, cia::kTargetPosition, l.target);
  use(out, cia::kProbeFunction, l.probe_function);
  use(in, cia::kStatusword, l.statusword);
  use(in, cia::kModeDisplay, l.mode_display);
  use(in, cia::kActualPosition, l.position);
  use(in, cia::kErrorCode, l.error_code);
  use(in, cia::kProbeStatus, l.probe_status);
  use(in, cia::kProbe1Rising, l.probe_rising);
  use(in, cia::kProbe1Falling, l.probe_falling);
  use(in, cia::kDigitalInputs, l.digital_inputs);
  if (unusable != 0)
    return fail(Fault::Inconsistent, fmt::format("profile '{}': {:04X}h of axis {} is mapped with another size than "
                                                 "the standard's, or not on a whole byte",
                                                 profile.name, unusable, slot));
  for (const auto& [mapped, index] :
       {std::pair{l.controlword.mapped(), cia::kControlword}, std::pair{l.statusword.mapped(), cia::kStatusword},
        std::pair{l.position.mapped(), cia::kActualPosition}})
    if (!mapped)
      return fail(Fault::Inconsistent,
                  fmt::format("profile '{}': {:04X}h of axis {} is in no PDO", profile.name, index, slot));

  l.neg_limit_bit = facts.input_neg_limit;
  l.pos_limit_bit = facts.input_pos_limit;
  l.home_bit = facts.input_home;
  l.follows_bit = facts.status_follows;
  l.limit_bit = facts.status_limit;
  l.probe_level_bit = facts.probe_level_bit;
  l.closed_loop = facts.closed_loop;
  for (const auto& row : facts.errors)
    if (!l.codes.push_back(meaning(row)))
      return fail(Fault::Inconsistent, fmt::format("profile '{}' has more than {} error codes", profile.name,
                                                   decltype(l.codes)::capacity()));
  return l;
}

}  // namespace gantry::devices
