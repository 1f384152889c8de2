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

std::optional<ObjectType> type_of_size(ObjectType type, std::size_t bytes) {
  const bool has_sign = type == ObjectType::I8 || type == ObjectType::I16 || type == ObjectType::I32;
  if (type == ObjectType::String) return std::nullopt;
  switch (bytes) {
    case 1: return has_sign ? ObjectType::I8 : ObjectType::U8;
    case 2: return has_sign ? ObjectType::I16 : ObjectType::U16;
    case 4: return has_sign ? ObjectType::I32 : ObjectType::U32;
    default: return std::nullopt;
  }
}

std::optional<std::int64_t> to_number_of_any_size(ObjectType type, std::span<const std::byte> bytes) {
  const auto as_it_is = type_of_size(type, bytes.size());
  return as_it_is ? to_number(*as_it_is, bytes) : std::nullopt;
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
