// Numbers as the bytes of an object, and back.
//   bus.write_object(station, row.address, to_bytes(row.type, row.value));
#pragma once
#include <cstdint>
#include <optional>
#include <span>

#include "config/drive.hpp"
#include "devices/bus.hpp"

namespace gantry::devices {

/// Bytes of a type on the wire; 0 for String.
std::size_t bytes_of(config::ObjectType type);
/// Little-endian bytes of a number in an object's type; empty for String.
Bytes to_bytes(config::ObjectType type, std::int64_t value);
/// The number; nothing when the size is not the type's.
std::optional<std::int64_t> to_number(config::ObjectType type, std::span<const std::byte> bytes);

/// The type of this size with the sign of `type`; nothing for sizes that no number has.
std::optional<config::ObjectType> type_of_size(config::ObjectType type, std::size_t bytes);
/// A number of as many bytes as the station has, with the sign of `type`.
std::optional<std::int64_t> to_number_of_any_size(config::ObjectType type, std::span<const std::byte> bytes);

}  // namespace gantry::devices
