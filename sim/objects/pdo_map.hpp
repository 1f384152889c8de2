// How a virtual station lays objects into its process image: the mapping objects 16xxh/1Axxh and 1C12h/1C13h, the rules
// for writing them, and the list of fields that comes out when the station leaves PRE_OP.
//   auto map = PdoMap::build(objects, PdoDirection::Rx);   // once, on the way to SAFE_OP; may allocate
//   map.unpack(sm2_bytes);                                 // every cycle: image -> Object::value
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "config/drive.hpp"
#include "sim/objects/object_dictionary.hpp"

namespace gantry::sim {

enum class PdoDirection { Rx, Tx };  ///< to the station, from the station

constexpr std::uint16_t assignment_index(PdoDirection d) noexcept { return d == PdoDirection::Rx ? 0x1C12 : 0x1C13; }

/// Entries of a PDO where the manual states no limit (assumed).
inline constexpr int kEntriesWhereNotStated = 16;

/// As 16xxh:n carries it: index, sub-index, bits.
std::uint32_t mapping_entry(const config::PdoEntry& entry) noexcept;
config::PdoEntry mapped(std::uint32_t entry) noexcept;

/// The PDOs a station has at power-on. A station whose mapping is fixed has its profile's. A drive has 4 + 4 mapping
/// objects, or as many as its profile uses; the first of each axis holds controlword and target, statusword and
/// position (assumed: the manuals give counts at most), the others are empty, so that a master has to map what it
/// wants.
std::vector<config::PdoRow> default_mapping(const config::StationProfile& profile, PdoDirection direction);

/// Abort code that a write to a mapping or assignment object earns; 0: it may be written. Mapping changes in PRE_OP
/// only; entries only while sub 0 is 0; an assigned PDO does not change (ETG.1000.6, 5.6.7.4).
std::uint32_t check_mapping_write(ObjectDictionary& objects, const Object& target, std::int64_t value, bool pre_op);

class PdoMap {
 public:
  static PdoMap build(ObjectDictionary& objects, PdoDirection direction);

  [[nodiscard]] std::size_t bytes() const noexcept { return (bits_ + 7) / 8; }
  /// Image to objects. The image must have bytes() at least.
  void unpack(std::span<const std::byte> image) const noexcept;
  /// Objects to image.
  void pack(std::span<std::byte> image) const noexcept;
  /// Every PDO that is assigned exists, and so does every object in it.
  [[nodiscard]] bool complete() const noexcept { return complete_; }
  /// Its objects become 0.
  void clear() const noexcept;

 private:
  struct Field {
    Object* object = nullptr;
    std::uint32_t bit = 0;
    std::uint8_t bits = 0;
    std::uint8_t whole = 0;  ///< 1, 2 or 4: it is so many whole bytes, all of its object
    bool is_signed = false;
  };
  std::vector<Field> fields_;
  std::size_t bits_ = 0;
  bool complete_ = true;
};

}  // namespace gantry::sim
