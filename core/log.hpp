// The one way to tell people something while running: stderr, through spdlog. Never called from the RT loop, which
// pushes events that its reader logs. Who handles an error logs it; nobody logs and returns.
//   log::info("axis {} is referenced", name);
#pragma once
#include <fmt/format.h>
#include <string_view>
#include <utility>

#include "core/error.hpp"

namespace gantry::log {

enum class Level { Quiet, Normal, Verbose };
enum class Weight { Debug, Info, Warning, Error };

/// Once, in main: pattern, stderr, level. Colour only when stderr is a terminal.
void open(Level level);

/// One line, if lines of this weight are shown.
void say(Weight weight, std::string_view line);

// The text is made here by a function of the library, and spdlog stays in log.cpp: its templates would be compiled in
// every file that logs.
template <class... A>
void debug(fmt::format_string<A...> text, A&&... args) {
  say(Weight::Debug, fmt::format(text, std::forward<A>(args)...));
}
template <class... A>
void info(fmt::format_string<A...> text, A&&... args) {
  say(Weight::Info, fmt::format(text, std::forward<A>(args)...));
}
template <class... A>
void warn(fmt::format_string<A...> text, A&&... args) {
  say(Weight::Warning, fmt::format(text, std::forward<A>(args)...));
}
template <class... A>
void error(fmt::format_string<A...> text, A&&... args) {
  say(Weight::Error, fmt::format(text, std::forward<A>(args)...));
}

/// One line for an error that somebody has just handled.
inline void report(const Error& e) { say(Weight::Error, to_text(e)); }

}  // namespace gantry::log
