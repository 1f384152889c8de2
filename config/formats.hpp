// The formats of this project's files as tables of fields, for schemas and docs.
#pragma once
#include "config/fields.hpp"

namespace gantry::config {

/// config/drives/*.yaml, config/devices/*.yaml
const std::vector<FieldShape>& profile_format();
/// config/machines/*.yaml
const std::vector<FieldShape>& machine_format();

}  // namespace gantry::config
