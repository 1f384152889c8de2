#include "config/standard_objects.hpp"

#include <algorithm>
#include <array>
#include <fmt/format.h>

namespace gantry::config {
namespace {

enum class Fits : std::uint8_t {
  Exactly,   ///< the loop takes it as it stands in the frame
  Signed,    ///< of any size: bring-up asks the station for it
  Unsigned,  ///< of any size
  Number,    ///< of any size, with a sign or without: vendors differ
};
struct Standard {
  std::uint16_t first, last;  ///< indices
  ObjectType type;
  Fits fits;
  const char* name;
  std::uint8_t sub = 0;  ///< the least; sub-index 0 of a record is the number of its entries
};
// IEC 61800-7-201 (CiA 402-2), the object dictionary's table.
constexpr std::array kStandard{
    Standard{0x603F, 0x603F, ObjectType::U16, Fits::Unsigned, "error code"},
    Standard{0x6040, 0x6040, ObjectType::U16, Fits::Exactly, "controlword"},
    Standard{0x6041, 0x6041, ObjectType::U16, Fits::Exactly, "statusword"},
    Standard{0x605A, 0x605E, ObjectType::I16, Fits::Number, "option code"},
    Standard{0x6060, 0x6060, ObjectType::I8, Fits::Number, "mode of operation"},
    Standard{0x6061, 0x6061, ObjectType::I8, Fits::Number, "mode display"},
    Standard{0x6062, 0x6063, ObjectType::I32, Fits::Signed, "position"},
    Standard{0x6064, 0x6064, ObjectType::I32, Fits::Exactly, "actual position"},
    Standard{0x606C, 0x606C, ObjectType::I32, Fits::Signed, "actual velocity"},
    Standard{0x607A, 0x607A, ObjectType::I32, Fits::Exactly, "target position"},
    Standard{0x607C, 0x607C, ObjectType::I32, Fits::Signed, "home offset"},
    Standard{0x607D, 0x607D, ObjectType::I32, Fits::Signed, "soft limit", 1},
    Standard{0x6080, 0x6085, ObjectType::U32, Fits::Number, "speed or acceleration"},
    Standard{0x6098, 0x6098, ObjectType::I8, Fits::Number, "homing method"},
    Standard{0x6099, 0x609A, ObjectType::U32, Fits::Number, "speed or acceleration"},
    Standard{0x60B8, 0x60B9, ObjectType::U16, Fits::Unsigned, "bits of the touch probe"},
    Standard{0x60BA, 0x60BD, ObjectType::I32, Fits::Exactly, "position of the touch probe"},
    Standard{0x60F4, 0x60F4, ObjectType::I32, Fits::Signed, "following error"},
    Standard{0x60FD, 0x60FE, ObjectType::U32, Fits::Unsigned, "inputs or outputs"},
    Standard{0x60FF, 0x60FF, ObjectType::I32, Fits::Signed, "target velocity"},
    Standard{0x6502, 0x6502, ObjectType::U32, Fits::Unsigned, "supported modes"},
};

bool fits(const Standard& s, ObjectType type) {
  if (type == s.type) return true;
  if (type == ObjectType::String || type == ObjectType::Bool) return false;
  switch (s.fits) {
    case Fits::Exactly: return false;
    case Fits::Signed: return is_signed(type);
    case Fits::Unsigned: return !is_signed(type);
    case Fits::Number: return true;
  }
  return true;
}

}  // namespace

std::string against_standard(ObjectAddress address, ObjectType type) {
  const auto s = std::ranges::find_if(
      kStandard, [&](const Standard& row) { return address.index >= row.first && address.index <= row.last; });
  if (s == kStandard.end() || address.sub < s->sub || fits(*s, type)) return {};
  return fmt::format("{} ({}) is {} in CiA 402{}, and {} here; write what the manual's table of objects says",
                     to_text(address), s->name, to_text(s->type),
                     s->fits == Fits::Exactly    ? ""
                     : s->fits == Fits::Signed   ? ", of some size and with a sign"
                     : s->fits == Fits::Unsigned ? ", of some size and without a sign"
                                                 : ", a whole number of some size",
                     to_text(type));
}

std::string_view to_text(ObjectType type) {
  switch (type) {
    case ObjectType::Bool: return "bool";
    case ObjectType::I8: return "i8";
    case ObjectType::U8: return "u8";
    case ObjectType::I16: return "i16";
    case ObjectType::U16: return "u16";
    case ObjectType::I32: return "i32";
    case ObjectType::U32: return "u32";
    case ObjectType::String: return "string";
  }
  return "";
}

std::optional<TypeRange> range_of(ObjectType type) {
  const int width = bits(type);
  if (width == 0) return std::nullopt;
  if (is_signed(type)) return TypeRange{-(std::int64_t{1} << (width - 1)), (std::int64_t{1} << (width - 1)) - 1};
  return TypeRange{0, (std::int64_t{1} << width) - 1};
}

}  // namespace gantry::config
