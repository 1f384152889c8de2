#include "sim/objects/pdo_map.hpp"

#include <algorithm>

#include "devices/wire/bytes.hpp"
#include "devices/wire/cia402.hpp"
#include "devices/wire/coe.hpp"

namespace gantry::sim {

using config::PdoEntry;
using config::PdoRow;
namespace abort_code = devices::wire::abort_code;
namespace cia402 = devices::wire::cia402;
using devices::wire::get_le;
using devices::wire::put_le;

std::uint32_t mapping_entry(const PdoEntry& e) noexcept {
  return static_cast<std::uint32_t>(e.address.index) << 16 | static_cast<std::uint32_t>(e.address.sub) << 8 |
         e.bit_length;
}

PdoEntry mapped(std::uint32_t entry) noexcept {
  return {{static_cast<std::uint16_t>(entry >> 16), static_cast<std::uint8_t>(entry >> 8)},
          static_cast<std::uint8_t>(entry)};
}

std::vector<PdoRow> default_mapping(const config::StationProfile& profile, PdoDirection direction) {
  const auto& used = direction == PdoDirection::Rx ? profile.rx_pdos : profile.tx_pdos;
  if (profile.pdo_fixed || !profile.drive) return used;

  constexpr int kMappingObjects = 4;
  const std::uint16_t first = direction == PdoDirection::Rx ? 0x1600 : 0x1A00;
  std::vector<PdoRow> rows = used;
  for (auto& row : rows) row.entries.clear();
  // Drives that count their mapping objects otherwise (an axis at 1610h) have those that they use, and no others.
  const bool in_a_row = std::all_of(
      used.begin(), used.end(), [&](const PdoRow& r) { return r.index >= first && r.index < first + kMappingObjects; });
  for (int i = 0; in_a_row && i < kMappingObjects; ++i) rows.push_back({static_cast<std::uint16_t>(first + i), 0, {}});
  std::stable_sort(rows.begin(), rows.end(), [](const PdoRow& a, const PdoRow& b) { return a.index < b.index; });
  rows.erase(std::unique(rows.begin(), rows.end(), [](const auto& a, const auto& b) { return a.index == b.index; }),
             rows.end());

  for (int slot = 0; slot < profile.slots; ++slot) {
    const auto row = std::find_if(rows.begin(), rows.end(), [&](const PdoRow& r) {
      return r.entries.empty() && std::any_of(used.begin(), used.end(),
                                              [&](const PdoRow& u) { return u.index == r.index && u.slot == slot; });
    });
    if (row == rows.end()) continue;
    const auto on = [&](std::uint16_t index) { return static_cast<std::uint16_t>(index + slot * profile.slot_stride); };
    if (direction == PdoDirection::Rx)
      row->entries = {{{on(cia402::kControlword), 0}, 16}, {{on(cia402::kTargetPosition), 0}, 32}};
    else
      row->entries = {{{on(cia402::kStatusword), 0}, 16}, {{on(cia402::kActualPosition), 0}, 32}};
  }
  return rows;
}

namespace {

constexpr int kWordBits = 16;

/// Bits of the entries before `sub`.
int bits_before(ObjectDictionary& objects, std::uint16_t mapping_index, std::uint8_t sub) {
  int bits = 0;
  for (int i = 1; i < sub; ++i)
    bits += mapped(static_cast<std::uint32_t>(objects.value({mapping_index, static_cast<std::uint8_t>(i)}))).bit_length;
  return bits;
}

bool is_tx(std::uint16_t mapping_index) noexcept { return mapping_index >= 0x1A00; }

bool assigned(ObjectDictionary& objects, std::uint16_t mapping_index) {
  const std::uint16_t assignment = assignment_index(is_tx(mapping_index) ? PdoDirection::Tx : PdoDirection::Rx);
  const auto count = objects.value({assignment, 0});
  for (int i = 1; i <= count; ++i)
    if (objects.value({assignment, static_cast<std::uint8_t>(i)}) == mapping_index) return true;
  return false;
}

std::uint32_t check_entry(ObjectDictionary& objects, std::uint16_t mapping_index, const PdoEntry& entry) {
  if (entry.address.index == 0) return 0;  // a gap
  const Object* o = objects.find(entry.address);
  if (o == nullptr) return objects.index(entry.address.index).empty() ? abort_code::kNoObject : abort_code::kNoSub;
  const bool right_direction = is_tx(mapping_index) ? o->readable : o->writable;
  const bool right_size = entry.bit_length == config::bits(o->type);
  return o->mappable && right_direction && right_size ? 0 : abort_code::kNotMappable;
}

std::uint32_t check_count(ObjectDictionary& objects, std::uint16_t mapping_index, std::int64_t count) {
  const auto subs = objects.index(mapping_index);
  if (count >= static_cast<std::int64_t>(subs.size())) return abort_code::kPdoTooLong;
  int bits = 0;
  for (int i = 1; i <= count; ++i) {
    const auto entry = mapped(static_cast<std::uint32_t>(subs[static_cast<std::size_t>(i)].value));
    if (const auto refused = check_entry(objects, mapping_index, entry); refused != 0) return refused;
    bits += entry.bit_length;
  }
  if (objects.pdo_rules().even && bits % kWordBits != 0) return abort_code::kPdoTooLong;
  const int max_bytes = objects.profile().max_pdo_bytes;
  return max_bytes > 0 && bits > 8 * max_bytes ? abort_code::kPdoTooLong : 0;
}

}  // namespace

std::uint32_t check_mapping_write(ObjectDictionary& objects, const Object& target, std::int64_t value, bool pre_op) {
  if (!pre_op) return abort_code::kDeviceState;
  const auto [index, sub] = target.address;
  const PdoRules& rules = objects.pdo_rules();
  if (target.rule == ObjectRule::Mapping ? rules.mapping_fixed : rules.assignment_fixed) return abort_code::kReadOnly;
  const bool count_is_zero = objects.value({index, 0}) == 0;
  if (sub != 0 && !count_is_zero) return abort_code::kSubWriteSub0First;
  if (target.rule == ObjectRule::Mapping) {
    if (assigned(objects, index)) return abort_code::kUnsupportedAccess;
    if (sub == 0) return check_count(objects, index, value);
    const PdoEntry entry = mapped(static_cast<std::uint32_t>(value));
    if (rules.even && entry.bit_length >= kWordBits && bits_before(objects, index, sub) % kWordBits != 0)
      return abort_code::kNotMappable;
    return check_entry(objects, index, entry);
  }
  const bool tx = index == assignment_index(PdoDirection::Tx);
  const auto is_pdo = [&](std::int64_t pdo) {
    const Object* o = objects.find({static_cast<std::uint16_t>(pdo), 0});
    return o != nullptr && o->rule == ObjectRule::Mapping && is_tx(static_cast<std::uint16_t>(pdo)) == tx;
  };
  if (sub != 0) return value == 0 || is_pdo(value) ? 0 : abort_code::kValueRange;
  const auto subs = objects.index(index);
  if (value >= static_cast<std::int64_t>(subs.size())) return abort_code::kValueTooHigh;
  for (int i = 1; i <= value; ++i)
    if (!is_pdo(subs[static_cast<std::size_t>(i)].value)) return abort_code::kValueRange;
  return 0;
}

PdoMap PdoMap::build(ObjectDictionary& objects, PdoDirection direction) {
  PdoMap map;
  const std::uint16_t assignment = assignment_index(direction);
  for (int i = 1; i <= objects.value({assignment, 0}); ++i) {
    const auto pdo = static_cast<std::uint16_t>(objects.value({assignment, static_cast<std::uint8_t>(i)}));
    map.complete_ = map.complete_ && objects.find({pdo, 0}) != nullptr;
    for (int k = 1; k <= objects.value({pdo, 0}); ++k) {
      const auto entry = mapped(static_cast<std::uint32_t>(objects.value({pdo, static_cast<std::uint8_t>(k)})));
      Object* object = entry.address.index != 0 ? objects.find(entry.address) : nullptr;
      map.complete_ = map.complete_ && (object != nullptr || entry.address.index == 0);
      if (object != nullptr) {
        const bool whole = map.bits_ % 8 == 0 && entry.bit_length == 8 * size_of(object->type);
        map.fields_.push_back({object, static_cast<std::uint32_t>(map.bits_), entry.bit_length,
                               static_cast<std::uint8_t>(whole ? entry.bit_length / 8 : 0), is_signed(object->type)});
      }
      map.bits_ += entry.bit_length;
    }
  }
  return map;
}

void PdoMap::unpack(std::span<const std::byte> image) const noexcept {
  for (const Field& f : fields_) {
    std::int64_t& value = f.object->value;
    const std::size_t at = f.bit / 8;
    switch (f.whole) {
      case 1: value = f.is_signed ? get_le<std::int8_t>(image, at) : get_le<std::uint8_t>(image, at); break;
      case 2: value = f.is_signed ? get_le<std::int16_t>(image, at) : get_le<std::uint16_t>(image, at); break;
      case 4:
        value = f.is_signed ? std::int64_t{get_le<std::int32_t>(image, at)} : get_le<std::uint32_t>(image, at);
        break;
      default: {
        std::uint64_t raw = 0;
        for (std::uint32_t i = 0; i < f.bits; ++i)
          raw |= (std::to_integer<std::uint64_t>(image[(f.bit + i) / 8]) >> ((f.bit + i) & 7) & 1) << i;
        value = fit(f.object->type, static_cast<std::int64_t>(raw));
      }
    }
  }
}

void PdoMap::pack(std::span<std::byte> image) const noexcept {
  for (const Field& f : fields_) {
    const auto raw = static_cast<std::uint64_t>(f.object->value);
    switch (f.whole) {
      case 1: put_le<std::uint8_t>(image, f.bit / 8, static_cast<std::uint8_t>(raw)); break;
      case 2: put_le<std::uint16_t>(image, f.bit / 8, static_cast<std::uint16_t>(raw)); break;
      case 4: put_le<std::uint32_t>(image, f.bit / 8, static_cast<std::uint32_t>(raw)); break;
      default:
        for (std::uint32_t i = 0; i < f.bits; ++i) {
          const auto mask = static_cast<std::byte>(1u << ((f.bit + i) & 7));
          std::byte& b = image[(f.bit + i) / 8];
          b = (raw >> i & 1) != 0 ? b | mask : b & ~mask;
        }
    }
  }
}

void PdoMap::clear() const noexcept {
  for (const Field& f : fields_) f.object->value = 0;
}

}  // namespace gantry::sim
