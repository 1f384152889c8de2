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
#include <memory>
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
  Mapping,     ///< 16xxh, 1Axxh: what a PDO holds (sim/objects/pdo_map.hpp)
  Assignment,  ///< 1C12h, 1C13h: which PDOs a SyncManager carries
};

/// Object codes of CiA 301.
enum class ObjectCode : std::uint8_t { Var = 7, Array = 8, Record = 9 };

/// What is asked for now and then only.
struct ObjectFacts {
  std::int64_t initial = 0;
  std::optional<std::int64_t> min, max;
  std::string text;  ///< of String objects
  std::string name;
};

/// Small: drives and process data go through many of them in every cycle.
struct Object {
  std::int64_t value = 0;
  std::unique_ptr<ObjectFacts> facts{};  ///< of every object in a dictionary
  config::ObjectAddress address{};
  config::ObjectType type = config::ObjectType::U16;
  bool readable = true, writable = false, mappable = false;
  ObjectRule rule = ObjectRule::Plain;
  bool kept = false;  ///< outlives the supply
};

/// Bytes of a number on the wire; 0 for strings.
std::size_t size_of(config::ObjectType type) noexcept;
/// The value as an object of this type holds it: cut to its width, sign-extended where it is signed.
inline std::int64_t fit(config::ObjectType type, std::int64_t value) noexcept {
  switch (type) {
    case config::ObjectType::Bool: return value & 1;
    case config::ObjectType::I8: return static_cast<std::int8_t>(value);
    case config::ObjectType::U8: return static_cast<std::uint8_t>(value);
    case config::ObjectType::I16: return static_cast<std::int16_t>(value);
    case config::ObjectType::U16: return static_cast<std::uint16_t>(value);
    case config::ObjectType::I32: return static_cast<std::int32_t>(value);
    case config::ObjectType::U32: return static_cast<std::uint32_t>(value);
    case config::ObjectType::String: break;
  }
  return value;
}

/// What a station allows of its mapping beyond the profile's limits.
struct PdoRules {
  bool assignment_fixed = false, mapping_fixed = false;
  bool even = false;  ///< see StationHabits::even_pdos
};

/// What comes of "save" (1010h).
enum class Saving : std::uint8_t { Keeps, Refuses, Forgets };

/// Objects that a station keeps without its supply.
using Kept = std::map<config::ObjectAddress, std::int64_t>;

/// What an index is as a whole.
struct ObjectShape {
  ObjectCode code{};
  std::uint16_t data_type = 0;  ///< of ETG.1020: a base type, or that of a record
  std::string name;
};
/// Number of a base data type (ETG.1020; CiA 301, 7.4.7.1).
std::uint16_t base_type(config::ObjectType type) noexcept;

class ObjectDictionary {
 public:
  /// `serial` goes to 1018h:4. `kept` outlives the dictionary: what it holds is set at once, what the profile's storage
  /// keeps is put there (nullptr: nothing is kept).
  ObjectDictionary(const config::StationProfile& profile, std::uint32_t serial, Kept* kept = nullptr);

  /// Every object has its start value again, or what is kept of it; rows and addresses of objects stay.
  void power_on() noexcept;

  [[nodiscard]] Object* find(config::ObjectAddress address) noexcept;
  [[nodiscard]] const Object* find(config::ObjectAddress address) const noexcept;
  /// All sub-objects of an index, ascending; empty when there is none.
  [[nodiscard]] std::span<Object> index(std::uint16_t index) noexcept;
  [[nodiscard]] std::span<const Object> index(std::uint16_t index) const noexcept;
  [[nodiscard]] std::span<const Object> all() const noexcept { return objects_; }
  [[nodiscard]] const config::StationProfile& profile() const noexcept { return profile_; }

  /// Number of an object, or `otherwise` where the station has no such object.
  [[nodiscard]] std::int64_t value(config::ObjectAddress address, std::int64_t otherwise = 0) const noexcept;

  /// Appends the object's bytes to `out`. 0, or an SDO abort code.
  [[nodiscard]] std::uint32_t read(config::ObjectAddress address, std::vector<std::byte>& out) const;
  /// All sub-objects one behind the other, from sub 0 (which takes two bytes) or sub 1 (ETG.1000.6, 5.6.2). Of a PDO's
  /// mapping or assignment as many as sub 0 says.
  [[nodiscard]] std::uint32_t read_complete(config::ObjectAddress from, std::vector<std::byte>& out) const;
  /// The same bytes back; all of it is taken, or nothing.
  [[nodiscard]] std::uint32_t write_complete(config::ObjectAddress from, std::span<const std::byte> bytes, bool pre_op);
  /// Writes are answered and change nothing: to one object (index 0: to all), or to none any more.
  void ignore_writes(std::optional<config::ObjectAddress> object) noexcept { ignored_ = object; }
  void set_save(Saving saving) noexcept { saving_ = saving; }
  void set_pdo_rules(const PdoRules& rules) noexcept { pdo_rules_ = rules; }
  [[nodiscard]] const PdoRules& pdo_rules() const noexcept { return pdo_rules_; }
  [[nodiscard]] ObjectShape shape(std::uint16_t index) const;
  /// 0, or an SDO abort code with nothing changed. `pre_op`: the station is in PRE_OP, where PDOs may be mapped.
  [[nodiscard]] std::uint32_t write(config::ObjectAddress address, std::span<const std::byte> bytes, bool pre_op);

 private:
  void add(Object object);
  void add_profile_rows();
  void add_communication_rows(std::uint32_t serial);
  void add_pdo_rows();
  void add_missing_counts();
  void sort();
  void note_what_is_kept();
  void commission();
  [[nodiscard]] std::uint32_t save(std::uint8_t group, std::int64_t signature);
  [[nodiscard]] std::uint32_t missing(config::ObjectAddress address) const noexcept;

  const config::StationProfile& profile_;
  Kept* kept_;
  PdoRules pdo_rules_;
  Saving saving_ = Saving::Keeps;
  std::optional<config::ObjectAddress> ignored_;
  std::vector<Object> objects_;  ///< by address
};

}  // namespace gantry::sim
