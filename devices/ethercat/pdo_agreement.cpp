#include "devices/ethercat/pdo_agreement.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <optional>
#include <utility>

#include "devices/ethercat/sdo.hpp"
#include "devices/ethercat/sdo_info.hpp"
#include "devices/ethercat/station_objects.hpp"
#include "devices/ethercat/survey.hpp"
#include "devices/profiles/drive_entries.hpp"
#include "devices/profiles/map_pdos.hpp"
#include "devices/wire/coe.hpp"

namespace gantry::devices {
namespace {

using namespace wire;
using config::ObjectAddress;
using config::ObjectType;
using config::PdoEntry;
using config::PdoRow;
using Entries = std::vector<PdoEntry>;

constexpr std::size_t kMostCandidates = 16;
constexpr std::uint16_t kNextAxis = 0x10;  // mapping objects of an axis begin so many behind those of the one before

enum class Order : std::uint8_t { AsProfile, BytesLast, BytesLastPadded };
constexpr std::array kOrders{Order::AsProfile, Order::BytesLast, Order::BytesLastPadded};

Entries ordered(Order order, Entries entries) {
  if (order == Order::AsProfile) return entries;
  std::ranges::stable_sort(entries, std::greater{}, [](const PdoEntry& e) { return std::min<int>(e.bit_length, 16); });
  std::size_t bits = 0;
  for (const auto& e : entries) bits += e.bit_length;
  if (order == Order::BytesLastPadded && bits % 16 != 0)
    entries.push_back({{0, 0}, static_cast<std::uint8_t>(16 - bits % 16)});
  return entries;
}

/// One direction of one station.
class Agreement {
 public:
  Agreement(Link& link, StationRecord& s, bool outputs, std::optional<int> probe_slot)
      : link_(link), s_(s), outputs_(outputs), probe_slot_(probe_slot) {}

  /// After `refused`, the station's answer to the profile's mapping.
  Result<void> bend(const Error& refused) {
    why_ = refused.message;
    const auto cleared = write(assignment(), ObjectType::U8, 0);
    if (!cleared) return tl::unexpected(cleared.error());
    if (!*cleared) {
      s_.fixed(outputs_) = {.assignment = true, .mapping = true};
      return adopt();
    }
    why_.clear();
    std::vector<PdoRow> agreed;
    for (const PdoRow& row : rows()) {
      auto placed = place(row, agreed);
      if (!placed) return tl::unexpected(placed.error());
      agreed.push_back(std::move(*placed));
    }
    std::uint8_t n = 0;
    for (const PdoRow& row : agreed)
      if (auto ok = must_write({assignment().index, ++n}, ObjectType::U16, row.index); !ok) return ok;
    if (auto ok = must_write(assignment(), ObjectType::U8, n); !ok) return ok;
    rows() = std::move(agreed);
    return {};
  }

  /// The mapping that the station has, if it holds what is needed.
  Result<void> adopt() {
    PdoMap map;
    if (auto ok = read_assigned(link_, s_, assignment_number(), outputs_, map); !ok) return ok;
    std::vector<PdoRow> found;
    for (const MappedPdo& pdo : map.pdos) found.push_back({.index = pdo.index, .slot = 0, .entries = pdo.entries});
    if (s_.config->profile.drive)
      for (int slot = 0; slot < s_.config->profile.slots; ++slot)
        for (const DriveEntry& e : kDriveEntries) {
          if (e.output != outputs_ || e.need != EntryNeed::EveryCycle || holds(found, e, slot)) continue;
          return fail(Fault::PdoMappingDiffers,
                      fmt::format("its mapping is fixed ({}) and does not hold {:04X}h ({} of axis {}) with {} bits, "
                                  "which is needed in every cycle",
                                  why_, on_slot(e.index, slot), e.name, slot, e.bits),
                      s_.where);
        }
    rows() = std::move(found);
    s_.max_pdo_entries = s_.max_pdo_bytes = 0;
    return {};
  }

  /// Whether the mapping, read back, is what was agreed.
  Result<bool> is_kept() {
    PdoMap map;
    if (auto ok = read_assigned(link_, s_, assignment_number(), outputs_, map); !ok) return tl::unexpected(ok.error());
    return std::ranges::equal(map.pdos, rows(), [](const MappedPdo& a, const PdoRow& b) {
      return a.index == b.index && std::ranges::equal(a.entries, b.entries, [](const PdoEntry& x, const PdoEntry& y) {
               return x.address == y.address && x.bit_length == y.bit_length;
             });
    });
  }
  void ignored() {
    why_ = "what was written to it reads back otherwise";
    s_.fixed(outputs_) = {.assignment = true, .mapping = true};
  }

 private:
  std::vector<PdoRow>& rows() { return outputs_ ? s_.rx_pdos : s_.tx_pdos; }
  [[nodiscard]] std::uint8_t assignment_number() const {
    return static_cast<std::uint8_t>(assignment().index - object::kSyncManagerAssign0);
  }
  [[nodiscard]] ObjectAddress assignment() const { return {pdo_assignment(s_, outputs_), 0}; }
  [[nodiscard]] std::uint16_t on_slot(std::uint16_t index, int slot) const {
    return config::in_slot(s_.config->profile, {index, 0}, slot).index;
  }
  [[nodiscard]] const DriveEntry* known(ObjectAddress address, int slot) const {
    if (!s_.config->profile.drive || address.sub != 0) return nullptr;
    return find_drive_entry(config::first_slot(s_.config->profile, address, slot).index);
  }
  /// Of a station that is no drive, everything is needed.
  [[nodiscard]] bool is_needed(ObjectAddress address, int slot) const {
    const DriveEntry* e = known(address, slot);
    return e == nullptr || e->need == EntryNeed::EveryCycle;
  }
  [[nodiscard]] bool is_of_probe(ObjectAddress address, int slot) const {
    const DriveEntry* e = known(address, slot);
    return slot == probe_slot_ && e != nullptr && e->need == EntryNeed::Probe;
  }
  [[nodiscard]] bool holds(const std::vector<PdoRow>& found, const DriveEntry& e, int slot) const {
    return std::ranges::any_of(found, [&](const PdoRow& pdo) {
      return std::ranges::any_of(pdo.entries, [&](const PdoEntry& x) {
        return x.address == ObjectAddress{on_slot(e.index, slot), 0} && x.bit_length == e.bits;
      });
    });
  }

  /// False: the station has refused, and said_ is what it said.
  Result<bool> write(ObjectAddress object, ObjectType type, std::int64_t value) {
    aborted_ = 0;
    auto done = write_number(link_, s_, object, type, value, &aborted_);
    if (done) return true;
    if (aborted_ == 0) return tl::unexpected(done.error());
    said_ = std::move(done.error().message);
    return false;
  }
  Result<void> must_write(ObjectAddress object, ObjectType type, std::int64_t value) {
    const auto done = write(object, type, value);
    if (!done) return tl::unexpected(done.error());
    return *done ? Result<void>{} : fail(Fault::PdoMappingDiffers, said_, s_.where);
  }
  void blame(const PdoEntry& entry, int slot) {
    if (!why_.empty()) return;
    const DriveEntry* e = known(entry.address, slot);
    why_ = fmt::format("{:04X}h ({} of axis {}) cannot be mapped, and is needed in every cycle; {}",
                       entry.address.index, e != nullptr ? e->name : "object", slot, said_);
  }

  /// Writes one mapping object. `refused`: place in `entries` of the one that was not taken; none: their count.
  Result<bool> write_entries(std::uint16_t index, const Entries& entries, std::optional<std::size_t>& refused) {
    refused.reset();
    const auto cleared = write({index, 0}, ObjectType::U8, 0);
    if (!cleared || !*cleared) return cleared;
    for (std::size_t i = 0; i < entries.size(); ++i) {
      const auto& [address, bits] = entries[i];
      const auto done = write({index, static_cast<std::uint8_t>(i + 1)}, ObjectType::U32,
                              mapping_entry(address.index, address.sub, bits));
      if (!done) return done;
      if (!*done) {
        refused = i;
        return false;
      }
    }
    return write({index, 0}, ObjectType::U8, static_cast<std::int64_t>(entries.size()));
  }

  /// As many of `wanted` in this order as the station takes; nothing when it does not take what is needed.
  Result<std::optional<Entries>> fill(std::uint16_t index, const PdoRow& row, Order order, const Entries& wanted) {
    Entries kept = wanted;
    std::optional<std::size_t> refused;
    for (;;) {
      const Entries now = ordered(order, kept);
      const auto done = write_entries(index, now, refused);
      if (!done) return tl::unexpected(done.error());
      if (*done) return now;
      if (!refused) break;
      const PdoEntry culprit = now[*refused];
      if (culprit.address.index == 0) return std::nullopt;
      if (is_needed(culprit.address, row.slot)) {
        blame(culprit, row.slot);
        return std::nullopt;
      }
      if (is_of_probe(culprit.address, row.slot)) break;  // it may only have come too late
      std::erase_if(kept, [&](const PdoEntry& e) { return e.address == culprit.address; });
    }
    // Together they are too many, and the station does not say which: one after the other.
    kept.clear();
    std::ranges::copy_if(wanted, std::back_inserter(kept),
                         [&](const PdoEntry& e) { return is_needed(e.address, row.slot); });
    auto done = write_entries(index, ordered(order, kept), refused);
    if (!done) return tl::unexpected(done.error());
    if (!*done) {
      if (!kept.empty()) blame(kept[refused && *refused < kept.size() ? *refused : 0], row.slot);
      return std::nullopt;
    }
    bool written = true;
    Entries rest = wanted;
    std::erase_if(rest, [&](const PdoEntry& e) { return is_needed(e.address, row.slot); });
    std::ranges::stable_partition(rest, [&](const PdoEntry& e) { return is_of_probe(e.address, row.slot); });
    for (const PdoEntry& e : rest) {
      Entries more = kept;
      more.push_back(e);
      done = write_entries(index, ordered(order, more), refused);
      if (!done) return tl::unexpected(done.error());
      written = *done;
      if (written) kept = std::move(more);
    }
    const Entries now = ordered(order, kept);
    if (!written) done = write_entries(index, now, refused);
    if (!done) return tl::unexpected(done.error());
    return now;
  }

  /// The entries with the sizes that the objects have, without those that the station does not have.
  Result<std::optional<Entries>> sized(const PdoRow& row) {
    Entries entries;
    for (PdoEntry entry : row.entries) {
      const DriveEntry* e = known(entry.address, row.slot);
      if (e == nullptr) {
        entries.push_back(entry);
        continue;
      }
      std::uint32_t aborted = 0;
      const auto value =
          sdo_upload(link_, s_, entry.address, SdoAccess::Single, &aborted, std::size_t{entry.bit_length} / 8);
      if (!value && aborted == 0) return tl::unexpected(value.error());
      if (!value) said_ = value.error().message;
      if (value && !value->empty() && value->size() <= 4)
        entry.bit_length = static_cast<std::uint8_t>(8 * value->size());
      if (value && e->bits == 32 && entry.bit_length != 32) {
        said_ = fmt::format("it has {} bits instead of {}", entry.bit_length, e->bits);
        if (e->need == EntryNeed::EveryCycle) return blame(entry, row.slot), std::nullopt;
        if (e->need == EntryNeed::Probe) continue;
      }
      if (aborted != abort_code::kNoObject && aborted != abort_code::kNoSub)
        entries.push_back(entry);
      else if (e->need == EntryNeed::EveryCycle)
        return blame(entry, row.slot), std::nullopt;
    }
    return entries;
  }

  /// The row in this mapping object; nothing: what is needed does not go there.
  Result<std::optional<PdoRow>> try_in(std::uint16_t index, const PdoRow& row) {
    const auto cleared = write({index, 0}, ObjectType::U8, 0);
    if (!cleared) return tl::unexpected(cleared.error());
    if (!*cleared && (aborted_ == abort_code::kNoObject || aborted_ == abort_code::kNoSub)) return std::nullopt;
    if (!*cleared) return as_it_is(index, row);
    const auto wanted = sized(row);
    if (!wanted) return tl::unexpected(wanted.error());
    if (!*wanted) return std::nullopt;
    const auto real = [](const Entries& e) {
      return std::ranges::count_if(e, [](const PdoEntry& x) { return x.address.index != 0; });
    };
    std::optional<Entries> best;
    Order best_order{};
    for (const Order order : kOrders) {
      auto taken = fill(index, row, order, **wanted);
      if (!taken) return tl::unexpected(taken.error());
      if (!*taken || (best && real(**taken) <= real(*best))) continue;
      best = std::move(*taken);
      best_order = order;
      if (real(*best) == real(**wanted)) return PdoRow{index, row.slot, *best};
    }
    if (!best) return std::nullopt;
    if (best_order != kOrders.back()) {
      std::optional<std::size_t> refused;
      if (auto again = write_entries(index, *best, refused); !again) return tl::unexpected(again.error());
    }
    return PdoRow{index, row.slot, *best};
  }

  Result<Entries> contents(std::uint16_t index) {
    PdoMap map;
    if (auto ok = read_mapping(link_, s_, index, map); !ok) return tl::unexpected(ok.error());
    return map.pdos.empty() ? Entries{} : map.pdos.front().entries;
  }

  /// A mapping object that cannot be written.
  Result<std::optional<PdoRow>> as_it_is(std::uint16_t index, const PdoRow& row) {
    auto entries = contents(index);
    if (!entries) return tl::unexpected(entries.error());
    const std::vector<PdoRow> found{{index, row.slot, *entries}};
    for (const PdoEntry& e : row.entries) {
      if (!is_needed(e.address, row.slot)) continue;
      const bool there = std::ranges::any_of(
          *entries, [&](const PdoEntry& x) { return x.address == e.address && x.bit_length == e.bit_length; });
      if (!there) return blame(e, row.slot), std::nullopt;
    }
    s_.fixed(outputs_).mapping = true;
    return found.front();
  }

  /// Mapping objects that may be this axis' instead of the profile's, the likeliest first.
  Result<std::vector<std::uint16_t>> others(const PdoRow& row, const std::vector<PdoRow>& taken) {
    const std::uint16_t base = outputs_ ? object::kRxPdoMap0 : object::kTxPdoMap0;
    const auto here = static_cast<std::uint16_t>(base + kNextAxis * row.slot);
    std::vector<std::uint16_t> all;
    if (auto list = read_object_indices(link_, s_, sdo_info::kListAll)) {
      std::ranges::copy_if(*list, std::back_inserter(all), [&](int i) { return i >= base && i < base + 0x200; });
    } else {
      for (const int step : {0x10, 0x01, 0x02, 0x04, 0x08, 0x20, 0x40})
        all.push_back(static_cast<std::uint16_t>(base + step * row.slot));
    }
    std::erase_if(all, [&](std::uint16_t i) {
      const auto is = [&](const PdoRow& r) { return r.index == i; };
      return i == row.index || std::ranges::any_of(taken, is) ||
             std::ranges::any_of(rows(), [&](const PdoRow& r) { return is(r) && r.slot != row.slot; });
    });
    if (all.size() > kMostCandidates) all.resize(kMostCandidates);
    std::vector<std::pair<int, std::uint16_t>> ranked;
    for (const std::uint16_t index : all) {
      const auto now = contents(index);
      if (!now && now.error().fault != Fault::SdoAbort) return tl::unexpected(now.error());
      if (!now) continue;  // there is none
      const bool its = std::ranges::any_of(*now, [&](const PdoEntry& e) {
        return std::ranges::any_of(row.entries, [&](const PdoEntry& w) { return w.address == e.address; });
      });
      ranked.emplace_back(its ? 0 : index == here ? 1 : 2, index);
    }
    std::ranges::stable_sort(ranked);
    std::vector<std::uint16_t> order;
    for (const auto& [rank, index] : ranked) order.push_back(index);
    return order;
  }

  Result<PdoRow> place(const PdoRow& row, const std::vector<PdoRow>& taken) {
    auto placed = try_in(row.index, row);
    if (!placed) return tl::unexpected(placed.error());
    if (*placed) return **placed;
    const std::string at_first = why_.empty() ? said_ : why_;
    const auto elsewhere = others(row, taken);
    if (!elsewhere) return tl::unexpected(elsewhere.error());
    for (const std::uint16_t index : *elsewhere) {
      placed = try_in(index, row);
      if (!placed) return tl::unexpected(placed.error());
      if (*placed) return **placed;
    }
    return fail(Fault::PdoMappingDiffers, at_first, s_.where);
  }

  Link& link_;
  StationRecord& s_;
  const bool outputs_;
  const std::optional<int> probe_slot_;
  std::string said_, why_;
  std::uint32_t aborted_ = 0;
};

/// What of the profile's mapping no PDO of the station carries.
Result<void> tell_what_is_lost(Link& link, StationRecord& s, std::vector<std::string>& notes) {
  const config::StationProfile& profile = s.config->profile;
  for (const bool outputs : {true, false})
    for (const PdoRow& row : outputs ? profile.rx_pdos : profile.tx_pdos)
      for (const PdoEntry& entry : row.entries) {
        const DriveEntry* e = find_drive_entry(config::first_slot(profile, entry.address, row.slot).index);
        const auto mapped = find_bits(outputs ? s.rx_pdos : s.tx_pdos, entry.address);
        const bool whole = mapped && (e == nullptr || e->bits != 32 || mapped->bits == 32);
        if (whole || e == nullptr) continue;
        const std::string how = mapped ? fmt::format("is in its PDOs with {} of {} bits", mapped->bits, e->bits)
                                       : std::string("is in none of its PDOs");
        const std::string what = fmt::format("{:04X}h ({} of axis {})", entry.address.index, e->name, row.slot);
        if (e->need == EntryNeed::Probe) {
          s.left_out.push_back(entry.address);
          notes.push_back(fmt::format("{}: {} {}: {}", s.where, what, how, e->cost));
          continue;
        }
        std::uint32_t aborted = 0;
        const auto value = sdo_upload(link, s, entry.address, SdoAccess::Single, &aborted);
        if (!value && aborted == 0) return tl::unexpected(value.error());
        const bool is_mode = e->index == cia402::kMode;
        if (!value && is_mode)
          return fail(Fault::PdoMappingDiffers,
                      fmt::format("{} {} and not to be had by SDO: {}", what, how, value.error().message), s.where);
        ObjectAddress by = entry.address;
        const bool is_display = e->index == cia402::kModeDisplay;
        if (!value && is_display) by = config::in_slot(profile, {cia402::kMode, 0}, row.slot);
        if (value || is_display) s.slow.push_back({entry.address, by, e->bits, outputs, e->has_sign, is_mode});
        notes.push_back(value ? fmt::format("{}: {} {}: {}", s.where, what, how, e->cost)
                              : fmt::format("{}: it has no {}: {}", s.where, what, e->absent));
      }
  return {};
}

}  // namespace

Result<void> learn_foreign_outputs(Link& link, StationRecord& s, std::vector<std::string>& notes) {
  s.foreign_outputs.clear();
  if (!s.bent) return {};
  std::size_t bit = 0;
  for (const PdoRow& row : s.rx_pdos)
    for (const PdoEntry& entry : row.entries) {
      const std::size_t at = std::exchange(bit, bit + entry.bit_length);
      if (entry.address.index == 0 || find_bits(s.config->profile.rx_pdos, entry.address)) continue;
      const std::string what = config::to_text(entry.address);
      const auto held =
          sdo_upload(link, s, entry.address, SdoAccess::Single, nullptr, std::size_t{entry.bit_length} / 8);
      if (!held || held->size() > sizeof(std::uint64_t))
        return fail(Fault::PdoMappingDiffers,
                    fmt::format("its mapping is its own and holds {}, which is not known here; it would be sent zeros, "
                                "and what it has cannot be kept: {}",
                                what, held ? "it is longer than 8 bytes" : held.error().message),
                    s.where);
      std::uint64_t value = 0;
      for (std::size_t i = 0; i < held->size(); ++i) value |= std::to_integer<std::uint64_t>((*held)[i]) << 8 * i;
      s.foreign_outputs.push_back({at, entry.bit_length, value});
      notes.push_back(fmt::format("{}: {} is in its PDOs and not known here: it goes on being sent the {} that it has",
                                  s.where, what, value));
    }
  return {};
}

Result<void> agree_on_pdos(Link& link, StationRecord& s, std::optional<int> probe_slot,
                           std::vector<std::string>& notes) {
  if (!s.writes_mapping) return {};
  bool bent = false;
  for (const bool outputs : {true, false}) {
    std::uint32_t aborted = 0;
    const auto as_profile = write_direction(link, s, outputs, &aborted);
    if (as_profile) continue;
    const bool ignored = as_profile.error().fault == Fault::PdoMappingDiffers;
    if (aborted == 0 && !ignored) return as_profile;
    bent = true;
    Agreement agreement(link, s, outputs, probe_slot);
    if (!ignored) {
      if (auto ok = agreement.bend(as_profile.error()); !ok) return ok;
      const auto kept = agreement.is_kept();
      if (!kept) return tl::unexpected(kept.error());
      if (*kept) continue;
    }
    agreement.ignored();
    if (auto ok = agreement.adopt(); !ok) return ok;
  }
  s.bent = bent;
  if (!bent || !s.config->profile.drive) return {};
  return tell_what_is_lost(link, s, notes);
}

}  // namespace gantry::devices
