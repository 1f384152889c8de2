// ObjectDictionary: what an index is as a whole, as strangers ask for it by SDO information.
#include <algorithm>
#include <array>
#include <cctype>

#include "sim/objects/object_dictionary.hpp"

namespace gantry::sim {

using config::ObjectType;

namespace {

// Data types of records (CiA 301, 7.4.7.1; ETG.1020; CiA 402-2 for the last one). 0: that of the elements.
constexpr std::uint16_t kElements = 0, kPdoMapping = 0x0021, kIdentity = 0x0023, kSyncParameter = 0x0029,
                        kRecord = 0x002A, kTimePeriod = 0x0080;

struct Shape {
  std::uint16_t index;
  ObjectCode code;
  std::uint16_t data_type;
  const char* name;
};
/// Objects of several entries that the standards name: ETG.1000.6 table 58, ETG.1020, CiA 301, CiA 402-2.
constexpr std::array kShapes{
    Shape{0x1010, ObjectCode::Array, kElements, "Store parameters"},
    Shape{0x1018, ObjectCode::Record, kIdentity, "Identity object"},
    Shape{0x10F1, ObjectCode::Record, kRecord, "Error settings"},
    Shape{0x1C00, ObjectCode::Array, kElements, "Sync manager type"},
    Shape{0x1C12, ObjectCode::Array, kElements, "RxPDO assign"},
    Shape{0x1C13, ObjectCode::Array, kElements, "TxPDO assign"},
    Shape{0x1C32, ObjectCode::Record, kSyncParameter, "SM output parameter"},
    Shape{0x1C33, ObjectCode::Record, kSyncParameter, "SM input parameter"},
    Shape{0x607B, ObjectCode::Array, kElements, "Position range limit"},
    Shape{0x607D, ObjectCode::Array, kElements, "Software position limit"},
    Shape{0x608F, ObjectCode::Array, kElements, "Position encoder resolution"},
    Shape{0x6091, ObjectCode::Array, kElements, "Gear ratio"},
    Shape{0x6092, ObjectCode::Array, kElements, "Feed constant"},
    Shape{0x6099, ObjectCode::Array, kElements, "Homing speeds"},
    Shape{0x60C1, ObjectCode::Array, kElements, "Interpolation data record"},
    Shape{0x60C2, ObjectCode::Record, kTimePeriod, "Interpolation time period"},
    Shape{0x60E3, ObjectCode::Array, kElements, "Supported homing methods"},
    Shape{0x60FE, ObjectCode::Array, kElements, "Digital outputs"},
};

/// Its words, without their digits: "DI1 function" and "DI2 function" are "DI function" both.
std::vector<std::string> words(const std::string& name) {
  std::vector<std::string> out(1);
  for (const char c : name) {
    if (c == ' ')
      out.emplace_back();
    else if (std::isdigit(static_cast<unsigned char>(c)) == 0)
      out.back() += c;
  }
  return out;
}

/// The words that the names of all elements have; where there is none, the first name.
std::string common_name(std::span<const Object> elements) {
  std::string name;
  for (const std::string& word : words(elements[0].facts->name)) {
    const bool everywhere = std::all_of(elements.begin(), elements.end(), [&](const Object& o) {
      const auto theirs = words(o.facts->name);
      return std::find(theirs.begin(), theirs.end(), word) != theirs.end();
    });
    if (everywhere && !word.empty()) name += (name.empty() ? "" : " ") + word;
  }
  return name.empty() ? elements[0].facts->name : name;
}

}  // namespace

std::uint16_t base_type(ObjectType type) noexcept {
  switch (type) {
    case ObjectType::Bool: return 0x0001;
    case ObjectType::I8: return 0x0002;
    case ObjectType::I16: return 0x0003;
    case ObjectType::I32: return 0x0004;
    case ObjectType::U8: return 0x0005;
    case ObjectType::U16: return 0x0006;
    case ObjectType::U32: return 0x0007;
    case ObjectType::String: return 0x0009;
  }
  return 0;
}

ObjectShape ObjectDictionary::shape(std::uint16_t of) const {
  const auto subs = index(of);
  if (subs.empty()) return {};
  if (subs.size() == 1 && subs[0].address.sub == 0)
    return {ObjectCode::Var, base_type(subs[0].type), subs[0].facts->name};
  if (subs[0].rule == ObjectRule::Mapping)
    return {ObjectCode::Record, kPdoMapping, of < 0x1A00 ? "RxPDO mapping" : "TxPDO mapping"};
  const auto elements = subs.subspan(1);
  const bool alike =
      std::all_of(elements.begin(), elements.end(), [&](const Object& o) { return o.type == elements[0].type; });
  // What an object of the drive profile is called is the same for each axis of the station.
  std::uint16_t first = of;
  if (profile_.drive && of >= 0x6000 && profile_.slot_stride > 0)
    first = static_cast<std::uint16_t>(0x6000 + (of - 0x6000) % profile_.slot_stride);
  const auto known = std::find_if(kShapes.begin(), kShapes.end(), [&](const Shape& s) {
    return s.index == first && (s.index < 0x6000 || profile_.drive) && (alike || s.code == ObjectCode::Record);
  });
  if (known != kShapes.end())
    return {known->code, known->data_type == kElements ? base_type(elements[0].type) : known->data_type, known->name};
  return {alike ? ObjectCode::Array : ObjectCode::Record, alike ? base_type(elements[0].type) : kRecord,
          common_name(elements)};
}

}  // namespace gantry::sim
