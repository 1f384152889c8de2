#include "config/check_profile.hpp"

#include <algorithm>
#include <array>
#include <fmt/format.h>

#include "config/profile_rules.hpp"
#include "config/stated_facts.hpp"

namespace gantry::config {
namespace {

constexpr std::int8_t kHomingMode = 6;
constexpr int kBuffers = 3;  // of a SyncManager of process data, one behind the other (ETG.1000.4, 6.7)

std::string flag_in_words(bool closed_loop) { return closed_loop ? "true" : "false"; }

void meaning_differs(const Parameter& p, std::string_view fact, const std::string& stated, const std::string& by_drive,
                     Location location, Mistakes& mistakes) {
  mistakes.add(Fault::Inconsistent,
               fmt::format("'{}' = {} stands for `{}: {}`, and `drive` says {}; correct one of the two, or, where the "
                           "value is a code, write what it stands for: `means: {{{}: {}}}`",
                           p.name, *p.value, fact, stated, by_drive, fact, by_drive),
               location);
}

void check_meaning(const StationProfile& profile, const Parameter& p, const Node& row, Mistakes& mistakes) {
  if (!profile.drive || !p.value) return;
  Meaning means;
  const Node* node = row.find("means");
  if (node != nullptr) read_object(*node, meaning_fields(), means, node->location, mistakes);
  const Location location = location_of_key(row, node != nullptr ? "means" : "value");
  const StatedFact* fact = find_stated_fact(p.name);
  if (fact != nullptr && node == nullptr) {
    if (fact->is_count)
      means.counts_per_rev = *p.value;
    else
      mistakes.add(Fault::MissingKey,
                   fmt::format("'{}' is a code; write what {} stands for: `means: {{closed_loop: {}}}`", p.name,
                               *p.value, flag_in_words(profile.drive->closed_loop)),
                   location);
  }
  if (means.counts_per_rev && *means.counts_per_rev != std::int64_t{profile.drive->counts_per_rev})
    meaning_differs(p, "counts_per_rev", std::to_string(*means.counts_per_rev),
                    std::to_string(profile.drive->counts_per_rev), location, mistakes);
  if (means.closed_loop && *means.closed_loop != profile.drive->closed_loop)
    meaning_differs(p, "closed_loop", flag_in_words(*means.closed_loop), flag_in_words(profile.drive->closed_loop),
                    location, mistakes);
}

/// A parameter and its object say the same of it.
void check_object(const StationProfile& profile, const Parameter& p, const Node& row, Mistakes& mistakes) {
  const ObjectRow* object = find_object(profile, p.address);
  if (object == nullptr) return;
  if (object->type != p.type)
    mistakes.add(Fault::Inconsistent,
                 fmt::format("{} has another type in `objects`; write the same", to_text(p.address)),
                 location_of_key(row, "type"));
  if (!p.value) return;
  if ((object->min && *p.value < *object->min) || (object->max && *p.value > *object->max))
    mistakes.add(Fault::OutOfRange,
                 fmt::format("{} of '{}' is not within what `objects` gives {}: {} to {}", *p.value, p.name,
                             to_text(p.address), object->min ? std::to_string(*object->min) : "any",
                             object->max ? std::to_string(*object->max) : "any"),
                 location_of_key(row, "value"));
}

void check_mapping(const StationProfile& profile, const Node& root, Mistakes& mistakes) {
  struct Required {
    std::uint16_t index;
    bool output;
    const char* name;
  };
  constexpr std::array kRequired{Required{0x6040, true, "controlword"}, Required{0x607A, true, "target position"},
                                 Required{0x6041, false, "statusword"}, Required{0x6064, false, "actual position"}};
  for (int slot = 0; slot < profile.slots; ++slot)
    for (const Required& r : kRequired) {
      const ObjectAddress address = in_slot(profile, {r.index, 0}, slot);
      const std::vector<PdoRow>& pdos = r.output ? profile.rx_pdos : profile.tx_pdos;
      const auto maps = [&](const PdoRow& pdo) {
        return pdo.slot == slot && std::ranges::count(pdo.entries, address, &PdoEntry::address) != 0;
      };
      if (std::ranges::any_of(pdos, maps)) continue;
      const char* const key = r.output ? "rx_pdos" : "tx_pdos";
      const auto its = std::ranges::find(pdos, slot, &PdoRow::slot);
      const Node& rows = *root.find(key);
      mistakes.add(
          Fault::MissingKey,
          fmt::format("{} ({} of axis {}) is in none of `{}`, and is needed in every cycle; add it", to_text(address),
                      r.name, slot, key),
          its != pdos.end() ? rows.items[static_cast<std::size_t>(its - pdos.begin())].location : rows.location);
    }
}

/// Bytes in the station's memory.
int bytes_of(const StationProfile& profile, const SyncManagerRow& row) {
  const bool outputs = row.kind == SyncManagerKind::ProcessOut;
  if (!outputs && row.kind != SyncManagerKind::ProcessIn) return row.length;
  return kBuffers * ((image_bits(profile, outputs) + 7) / 8);
}

void check_sync_managers(const StationProfile& profile, const Node& rows, Mistakes& mistakes) {
  const auto& all = profile.sync_managers;
  for (std::size_t i = 0; i < all.size(); ++i)
    for (std::size_t k = 0; k < i; ++k) {
      const int length = bytes_of(profile, all[i]), other = bytes_of(profile, all[k]);
      if (all[i].start >= all[k].start + other || all[k].start >= all[i].start + length) continue;
      mistakes.add(Fault::Inconsistent,
                   fmt::format("its {} bytes from 0x{:04X} lie over the {} bytes from 0x{:04X} of another one (process "
                               "data have {} buffers); give it a start of its own",
                               length, all[i].start, other, all[k].start, kBuffers),
                   location_of_key(rows.items[i], "start"));
      break;
    }
}

}  // namespace

const Fields<Meaning>& meaning_fields() {
  static const Fields<Meaning> kFields{
      integer("counts_per_rev", &Meaning::counts_per_rev, {1, 1e9}, kOptional, "pulses of one revolution"),
      flag("closed_loop", &Meaning::closed_loop, kOptional, "6064h is a measurement"),
  };
  return kFields;
}

void check_profile(const StationProfile& profile, const Node& root, Mistakes& mistakes) {
  keep_profile_rules(profile, root, mistakes);
  if (const Node* rows = root.find("parameters"))
    for (std::size_t i = 0; i < profile.parameters.size(); ++i) {
      check_meaning(profile, profile.parameters[i], rows->items[i], mistakes);
      check_object(profile, profile.parameters[i], rows->items[i], mistakes);
    }
  if (profile.drive && profile.bus == BusKind::EtherCat) check_mapping(profile, root, mistakes);
  if (const Node* rows = root.find("sync_managers")) check_sync_managers(profile, *rows, mistakes);
  if (profile.drive && !profile.drive->homing_methods.empty() &&
      std::ranges::count(profile.drive->modes, kHomingMode) == 0)
    mistakes.add(Fault::Inconsistent,
                 "`homing_methods` are listed, and `modes` lack 6 (homing); add it, or leave the methods out: []",
                 location_of_key(*root.find("drive"), "modes"));
}

}  // namespace gantry::config
