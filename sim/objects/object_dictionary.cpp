#include "sim/objects/object_dictionary.hpp"

#include <algorithm>

#include "devices/wire/coe.hpp"
#include "sim/objects/pdo_map.hpp"
#include "sim/objects/sii_image.hpp"

namespace gantry::sim {

using config::ObjectAddress;
using config::ObjectType;
namespace abort_code = devices::wire::abort_code;

std::size_t size_of(ObjectType type) noexcept {
  switch (type) {
    case ObjectType::Bool:
    case ObjectType::I8:
    case ObjectType::U8: return 1;
    case ObjectType::I16:
    case ObjectType::U16: return 2;
    case ObjectType::I32:
    case ObjectType::U32: return 4;
    case ObjectType::String: break;
  }
  return 0;
}

namespace {

constexpr std::uint16_t kStoreParameters = 0x1010;

/// Index of a profile row on another axis of the station; 1xxxh belongs to the station as a whole.
std::uint16_t index_on(const config::StationProfile& profile, std::uint16_t index, int slot) noexcept {
  const int stride = index >= 0x6000 ? profile.slot_stride : index >= 0x2000 ? profile.slot_stride_vendor : 0;
  return static_cast<std::uint16_t>(index + slot * stride);
}

Object number(ObjectAddress address, ObjectType type, std::int64_t value, std::string name) {
  Object o;
  o.address = address, o.type = type, o.value = value;
  o.facts = std::make_unique<ObjectFacts>();
  o.facts->name = std::move(name);
  return o;
}

Object text(ObjectAddress address, std::string value, std::string name) {
  Object o = number(address, ObjectType::String, 0, std::move(name));
  o.facts->text = std::move(value);
  return o;
}

}  // namespace

ObjectDictionary::ObjectDictionary(const config::StationProfile& profile, std::uint32_t serial, Kept* kept)
    : profile_(profile), kept_(kept) {
  add_profile_rows();
  sort();
  add_communication_rows(serial);
  add_pdo_rows();
  sort();
  add_missing_counts();
  sort();
  note_what_is_kept();
  commission();
  power_on();
}

void ObjectDictionary::power_on() noexcept {
  ignored_.reset();
  for (Object& o : objects_) o.value = o.facts->initial;
  if (kept_ != nullptr)
    for (const auto& [address, value] : *kept_)
      if (Object* o = find(address)) o->value = value;
}

void ObjectDictionary::note_what_is_kept() {
  using config::Storage;
  for (Object& o : objects_) {
    o.facts->initial = o.value;
    const bool vendors = o.address.index >= 0x2000 && o.address.index < 0x6000;
    const bool standard = o.address.index >= 0x6000 && o.address.index < 0xA000;
    o.kept = o.writable && o.rule == ObjectRule::Plain &&
             ((profile_.storage != Storage::None && vendors) || (profile_.storage == Storage::OnSave && standard));
  }
}

/// What `gantry commission` has written, once, before this world began: what acts at power-up only, and facts of the
/// motor that is wired to the drive.
void ObjectDictionary::commission() {
  for (const auto& row : profile_.startup)
    if (row.acts == config::ActsAt::PowerUp || row.rule == config::ParameterRule::MustEqual)
      if (Object* o = find(row.address)) o->facts->initial = row.value;
}

void ObjectDictionary::sort() {
  std::stable_sort(objects_.begin(), objects_.end(),
                   [](const Object& a, const Object& b) { return a.address < b.address; });
  const auto same = [](const Object& a, const Object& b) { return a.address == b.address; };
  objects_.erase(std::unique(objects_.begin(), objects_.end(), same), objects_.end());
}

void ObjectDictionary::add(Object object) { objects_.push_back(std::move(object)); }

void ObjectDictionary::add_profile_rows() {
  for (int slot = 0; slot < std::max(profile_.slots, 1); ++slot)
    for (const auto& row : profile_.objects) {
      if (slot > 0 && row.address.index < 0x2000) continue;
      const bool of_identity = row.address.index == 0x1008 || row.address.index == 0x1018;
      if (of_identity && !row.initial) continue;  // the profile's identity fills it
      Object o = number({index_on(profile_, row.address.index, slot), row.address.sub}, row.type,
                        row.initial.value_or(0), row.name);
      o.readable = row.readable, o.writable = row.writable, o.mappable = row.mappable;
      o.facts->min = row.min, o.facts->max = row.max;
      add(std::move(o));
    }
}

// ETG.1000.6 table 58 and ETG.1020. A row that the profile has itself stands first and stays.
void ObjectDictionary::add_communication_rows(std::uint32_t serial) {
  const auto& id = profile_.identity;
  add(number({0x1000, 0}, ObjectType::U32, profile_.drive ? 0x00020192 : 0x00000191, "device type"));
  add(number({0x1001, 0}, ObjectType::U8, 0, "error register"));
  add(text({0x1008, 0}, profile_.title.empty() ? profile_.name : profile_.title, "device name"));
  add(text({0x1009, 0}, "virtual", "hardware version"));
  add(text({0x100A, 0}, "virtual", "software version"));
  if (profile_.storage == config::Storage::OnSave)
    for (const std::uint8_t group : {std::uint8_t{1}, std::uint8_t{2}}) {
      Object o = number({kStoreParameters, group}, ObjectType::U32, 1, "store parameters");  // 1: on command
      o.writable = true;
      add(std::move(o));
    }
  add(number({0x1018, 1}, ObjectType::U32, id.vendor, "vendor id"));
  add(number({0x1018, 2}, ObjectType::U32, id.product, "product code"));
  add(number({0x1018, 3}, ObjectType::U32, id.revision, "revision"));
  add(number({0x1018, 4}, ObjectType::U32, serial, "serial number"));
  Object reaction = number({0x10F1, 1}, ObjectType::U32, 1, "local error reaction");
  Object limit = number({0x10F1, 2}, ObjectType::U32, 0, "sync error counter limit");  // 0: not watched (assumed)
  reaction.writable = limit.writable = true;
  add(std::move(reaction));
  add(std::move(limit));
  std::uint8_t sm = 0;
  for (const auto& row : sync_managers(profile_))
    add(number({0x1C00, ++sm}, ObjectType::U8, static_cast<int>(row.kind), "SyncManager communication type"));
  // ETG.1020, 1C32h and 1C33h.
  const auto& cycles = profile_.drive ? profile_.drive->cycle_times_us : std::vector<std::uint32_t>{};
  const std::int64_t shortest =
      cycles.empty() ? 250'000 : std::int64_t{1000} * *std::min_element(cycles.begin(), cycles.end());
  for (const std::uint16_t index : {std::uint16_t{0x1C32}, std::uint16_t{0x1C33}}) {
    const bool outputs = index == 0x1C32;
    const auto row = [&](std::uint8_t sub, ObjectType type, std::int64_t value, const char* name, bool write) {
      Object o = number({index, sub}, type, value, name);
      o.writable = write;
      add(std::move(o));
    };
    row(1, ObjectType::U16, profile_.dc ? 2 : outputs ? 1 : 0x22, "synchronisation type", true);
    row(2, ObjectType::U32, 0, "cycle time", true);
    row(3, ObjectType::U32, 0, "shift time", true);
    row(4, ObjectType::U16, profile_.dc ? 0x0007 : 0x0003, "synchronisation types supported", false);
    row(5, ObjectType::U32, shortest, "minimum cycle time", false);
    row(6, ObjectType::U32, 0, "calculate and copy time", false);
    row(8, ObjectType::U16, 0, "get cycle time", true);
    row(9, ObjectType::U32, 0, "delay time", false);
    row(10, ObjectType::U32, 0, "SYNC0 cycle time", true);
    row(11, ObjectType::U16, 0, "SM event missed", false);
    row(12, ObjectType::U16, 0, "cycle time too small", false);
    row(13, ObjectType::U16, 0, "shift time too short", false);
    row(32, ObjectType::Bool, 0, "sync error", false);
  }
}

void ObjectDictionary::add_pdo_rows() {
  for (const auto direction : {PdoDirection::Rx, PdoDirection::Tx}) {
    const auto defaults = default_mapping(profile_, direction);
    const int entries_max = profile_.max_pdo_entries > 0 ? profile_.max_pdo_entries : kEntriesWhereNotStated;
    for (const auto& pdo : defaults) {
      const int subs = profile_.pdo_fixed ? static_cast<int>(pdo.entries.size()) : entries_max;
      Object count = number({pdo.index, 0}, ObjectType::U8, static_cast<int>(pdo.entries.size()), "mapped objects");
      count.writable = !profile_.pdo_fixed, count.rule = ObjectRule::Mapping;
      add(std::move(count));
      for (int i = 0; i < subs; ++i) {
        const bool used = i < static_cast<int>(pdo.entries.size());
        const std::uint32_t entry = used ? mapping_entry(pdo.entries[static_cast<std::size_t>(i)]) : 0;
        Object o = number({pdo.index, static_cast<std::uint8_t>(i + 1)}, ObjectType::U32, entry, "mapped object");
        o.writable = !profile_.pdo_fixed, o.rule = ObjectRule::Mapping;
        add(std::move(o));
      }
    }
    const std::uint16_t assignment = assignment_index(direction);
    std::vector<std::uint16_t> assigned;
    for (const auto& pdo : defaults)
      if (!pdo.entries.empty()) assigned.push_back(pdo.index);
    Object count = number({assignment, 0}, ObjectType::U8, static_cast<int>(assigned.size()), "assigned PDOs");
    count.writable = !profile_.pdo_fixed, count.rule = ObjectRule::Assignment;
    add(std::move(count));
    for (std::size_t i = 0; i < defaults.size(); ++i) {
      Object o = number({assignment, static_cast<std::uint8_t>(i + 1)}, ObjectType::U16,
                        i < assigned.size() ? assigned[i] : 0, "assigned PDO");
      o.writable = !profile_.pdo_fixed, o.rule = ObjectRule::Assignment;
      add(std::move(o));
    }
  }
}

// Sub-index 0 of an array or record holds the highest sub-index (CiA 301, 7.4.3).
void ObjectDictionary::add_missing_counts() {
  const std::size_t known = objects_.size();
  for (std::size_t i = 0; i < known; ++i) {
    const ObjectAddress a = objects_[i].address;
    const bool last = i + 1 == known || objects_[i + 1].address.index != a.index;
    if (last && a.sub > 0 && find({a.index, 0}) == nullptr)
      add(number({a.index, 0}, ObjectType::U8, a.sub, "highest sub-index"));
  }
}

Object* ObjectDictionary::find(ObjectAddress address) noexcept {
  return const_cast<Object*>(std::as_const(*this).find(address));
}

const Object* ObjectDictionary::find(ObjectAddress address) const noexcept {
  // add_missing_counts() looks while unsorted rows stand at the end; none of them is looked for.
  const auto at = std::lower_bound(objects_.begin(), objects_.end(), address,
                                   [](const Object& o, ObjectAddress a) { return o.address < a; });
  return at != objects_.end() && at->address == address ? &*at : nullptr;
}

std::span<Object> ObjectDictionary::index(std::uint16_t index) noexcept {
  const auto from =
      std::partition_point(objects_.begin(), objects_.end(), [&](const Object& o) { return o.address.index < index; });
  const auto to = std::partition_point(from, objects_.end(), [&](const Object& o) { return o.address.index == index; });
  return {from, to};
}

std::span<const Object> ObjectDictionary::index(std::uint16_t index) const noexcept {
  return const_cast<ObjectDictionary&>(*this).index(index);
}

std::int64_t ObjectDictionary::value(ObjectAddress address, std::int64_t otherwise) const noexcept {
  const Object* o = find(address);
  return o != nullptr ? o->value : otherwise;
}

std::uint32_t ObjectDictionary::missing(ObjectAddress address) const noexcept {
  const bool index_known =
      std::any_of(objects_.begin(), objects_.end(), [&](const Object& o) { return o.address.index == address.index; });
  return index_known ? abort_code::kNoSub : abort_code::kNoObject;
}

std::uint32_t ObjectDictionary::read(ObjectAddress address, std::vector<std::byte>& out) const {
  const Object* o = find(address);
  if (o == nullptr) return missing(address);
  if (!o->readable) return abort_code::kWriteOnly;
  if (o->type == ObjectType::String) {
    for (const char c : o->facts->text) out.push_back(static_cast<std::byte>(c));
    return 0;
  }
  for (std::size_t i = 0; i < size_of(o->type); ++i)
    out.push_back(static_cast<std::byte>(static_cast<std::uint64_t>(o->value) >> (8 * i) & 0xFF));
  return 0;
}

std::uint32_t ObjectDictionary::write(ObjectAddress address, std::span<const std::byte> bytes, bool pre_op) {
  Object* o = find(address);
  if (o == nullptr) return missing(address);
  if (!o->writable) return abort_code::kReadOnly;
  const std::size_t size = size_of(o->type);
  if (bytes.size() > size) return abort_code::kSizeTooLarge;
  if (bytes.size() < size) return abort_code::kSizeTooSmall;
  std::uint64_t raw = 0;
  for (std::size_t i = 0; i < size; ++i) raw |= std::to_integer<std::uint64_t>(bytes[i]) << (8 * i);
  const std::int64_t value = fit(o->type, static_cast<std::int64_t>(raw));
  if (o->facts->max && value > *o->facts->max) return abort_code::kValueTooHigh;
  if (o->facts->min && value < *o->facts->min) return abort_code::kValueTooLow;
  if (o->rule != ObjectRule::Plain)
    if (const auto refused = check_mapping_write(*this, *o, value, pre_op); refused != 0) return refused;
  if (ignored_ && (ignored_->index == 0 || *ignored_ == address)) return 0;
  if (address.index == kStoreParameters && address.sub > 0) return save(address.sub, value);
  o->value = value;
  if (kept_ != nullptr && o->kept && profile_.storage == config::Storage::AtOnce)
    kept_->insert_or_assign(address, value);
  return 0;
}

/// 1010h: "save" keeps a group of objects, "rest" drops it (AMD530B 8.2: group 1 is 6000h, group 2 is 2000h).
std::uint32_t ObjectDictionary::save(std::uint8_t group, std::int64_t signature) {
  constexpr std::int64_t kSave = 0x65766173, kRestore = 0x74736572;
  if (signature != kSave && signature != kRestore) return abort_code::kCannotStore;
  if (saving_ == Saving::Refuses) return abort_code::kCannotStore;
  if (saving_ == Saving::Forgets) return 0;
  const std::uint16_t from = group == 1 ? 0x6000 : 0x2000, to = group == 1 ? 0xA000 : 0x6000;
  if (kept_ == nullptr) return 0;
  std::erase_if(*kept_, [&](const auto& row) { return row.first.index >= from && row.first.index < to; });
  if (signature == kRestore) return 0;
  for (const Object& o : objects_)
    if (o.kept && o.address.index >= from && o.address.index < to) kept_->insert_or_assign(o.address, o.value);
  return 0;
}

}  // namespace gantry::sim
