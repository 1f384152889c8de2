// Types of the objects that every drive of CiA 402 has, for profiles that state another one.
#pragma once
#include <optional>
#include <string>
#include <string_view>

#include "config/drive.hpp"

namespace gantry::config {

/// Why an object at this address of the first axis cannot be of this type, with the type that it has; empty: it can, or
/// no standard says anything of it.
std::string against_standard(ObjectAddress address, ObjectType type);

/// As a profile has it: "u16".
std::string_view to_text(ObjectType type);
/// Least and largest value; nothing of a text.
struct TypeRange {
  std::int64_t low = 0, high = 0;
};
std::optional<TypeRange> range_of(ObjectType type);

}  // namespace gantry::config
