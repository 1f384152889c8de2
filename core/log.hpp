// The one way to tell people something while running: stderr, through spdlog. Never called from the RT loop, which
// pushes events that its reader logs. Who handles an error logs it; nobody logs and returns.
//   log::info("axis {} is referenced", name);
#pragma once
#include <spdlog/spdlog.h>

#include "core/error.hpp"

namespace gantry::log {

enum class Level { Quiet, Normal, Verbose };

/// Once, in main: pattern, stderr, level. Colour only when stderr is a terminal.
void open(Level level);

using spdlog::debug;
using spdlog::error;
using spdlog::info;
using spdlog::warn;

/// One line for an error that somebody has just handled.
inline void report(const Error& e) { spdlog::error("{}", to_text(e)); }

}  // namespace gantry::log
