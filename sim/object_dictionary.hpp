// The object dictionary of one virtual station: the rows of its profile, once per axis, and the objects that every CoE
// station has. Numbers live in `Object::value`; a drive keeps pointers to its own and reads and writes them every
// cycle, SDO comes through read() and write() with the checks and abort codes of the standard.
//   ObjectDictionary objects(profile, serial);
//   Object* target = objects.find({0x607A, 0});                  // stays valid as long as the dictionary
//   auto abort = objects.write({0x6098, 0}, bytes, pre_op);      // 0: done
#pragma once
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "config/drive.hpp"

namespace gantry::sim {

/// What a write to an object has to obey beyond its own row.
enum class ObjectRule : std::uint8_t {
  Plain,
  Mapping,     ///< 16xxh, 1Axxh: what a PDO holds (sim/pdo_map.hpp)
  Assignment,  ///< 1C12h, 1C13h: which PDOs a SyncManager carries
};

struct Object {
  config::ObjectAddress address;
  config::ObjectType type = config::ObjectType::U16;
  bool readable = true, writable = false, mappable = false;
  ObjectRule rule = ObjectRule::Plain;
  std::int64_t value = 0;
  std::optional<std::int64_t> min, max;
  std::string text;  ///< of String objects
  std::string name, unit;
};

/// Bytes of a number on the wire; 0 for strings.
std::size_t size_of(config::ObjectType type) noexcept;
/// The value as an object of this type holds it: cut to its width, sign-extended where it is signed.
std::int64_t fit(config::ObjectType type, std::int64_t value) noexcept;

/// Objects that a station keeps without its supply.
using Kept = std::map<config::ObjectAddress, std::int64_t>;

class ObjectDictionary {
 public:
  /// `serial` goes to 1018h:4. `kept` outlives the dictionary: what it holds is set at once, what the profile's storage
  /// keeps is put there (nullptr: nothing is kept).
  ObjectDictionary(const config::StationProfile& profile, std::uint32_t serial, Kept* kept = nullptr);

  [[nodiscard]] Object* find(config::ObjectAddress address) noexcept;
  [[nodiscard]] const Object* find(config::ObjectAddress address) const noexcept;
  /// All sub-objects of an index, ascending; empty when there is none.
  [[nodiscard]] std::span<Object> index(std::uint16_t index) noexcept;
  [[nodiscard]] std::span<const Object> all() const noexcept { return objects_; }
  [[nodiscard]] const config::StationProfile& profile() const noexcept { return profile_; }

  /// Number of an object, or `otherwise` where the station has no such object.
  [[nodiscard]] std::int64_t value(config::ObjectAddress address, std::int64_t otherwise = 0) const noexcept;

  /// Appends the object's bytes to `out`. 0, or an SDO abort code.
  [[nodiscard]] std::uint32_t read(config::ObjectAddress address, std::vector<std::byte>& out) const;
  /// 0, or an SDO abort code with nothing changed. `pre_op`: the station is in PRE_OP, where PDOs may be mapped.
  [[nodiscard]] std::uint32_t write(config::ObjectAddress address, std::span<const std::byte> bytes, bool pre_op);

 private:
  void add(Object object);
  void add_profile_rows();
  void add_communication_rows(std::uint32_t serial);
  void add_pdo_rows();
  void add_missing_counts();
  void sort();
  [[nodiscard]] std::uint32_t save(std::uint8_t group, std::int64_t signature);
  [[nodiscard]] std::uint32_t missing(config::ObjectAddress address) const noexcept;

  const config::StationProfile& profile_;
  Kept* kept_;
  std::vector<Object> objects_;  ///< by address
};

}  // namespace gantry::sim
