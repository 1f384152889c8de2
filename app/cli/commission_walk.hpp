// gantry commission --walk: each axis goes a short distance and back, and a person says which one moved and which way.
#pragma once
#include <string>

#include "app/cli/verbs.hpp"

namespace gantry::cli {

/// Sets context.exit_code. `interface`: "" walks the simulated machine, whose mode switch it turns to setup itself.
void commission_walk(Context& context, config::Machine machine, const std::string& interface, const std::string& state);

}  // namespace gantry::cli
