#include "devices/profiles/object_value.hpp"

#include "devices/wire/bytes.hpp"

namespace gantry::devices {

using config::ObjectType;
using wire::get_le;

std::size_t bytes_of(ObjectType type) { return static_cast<std::size_t>(config::bits(type) + 7) / 8; }

Bytes to_bytes(ObjectType type, std::int64_t value) {
  Bytes bytes(bytes_of(type));
  for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<std::byte>(value >> (8 * i) & 0xFF);
  return bytes;
}

std::optional<std::int64_t> to_number(ObjectType type, std::span<const std::byte> bytes) {
  if (bytes.size() != bytes_of(type)) return std::nullopt;
  switch (type) {
    case ObjectType::I8: return get_le<std::int8_t>(bytes, 0);
    case ObjectType::Bool:
    case ObjectType::U8: return get_le<std::uint8_t>(bytes, 0);
    case ObjectType::I16: return get_le<std::int16_t>(bytes, 0);
    case ObjectType::U16: return get_le<std::uint16_t>(bytes, 0);
    case ObjectType::I32: return get_le<std::int32_t>(bytes, 0);
    case ObjectType::U32: return get_le<std::uint32_t>(bytes, 0);
    case ObjectType::String: break;
  }
  return std::nullopt;
}

}  // namespace gantry::devices
