// The date that is kept with what was found on a machine.
#pragma once
#include <ctime>
#include <fmt/chrono.h>
#include <string>

namespace gantry::cli {

/// "2026-11-24", where the machine stands.
inline std::string today() { return fmt::format("{:%Y-%m-%d}", fmt::localtime(std::time(nullptr))); }

}  // namespace gantry::cli
