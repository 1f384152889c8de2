// The line on stderr that is written over while something goes on (a bar, a time), on a terminal only. Whatever else is
// written to the terminal clears it first, so that no log line is glued to it; the next show_status() brings it back.
//   show_status("[###...] 12/35");   log::info("…");   clear_status();
#pragma once
#include <string>
#include <string_view>

namespace gantry {

/// Whether `fd` is a terminal that can write over a line (TERM=dumb cannot).
bool writes_over(int fd) noexcept;
/// Columns of the terminal at `fd`; 80 where it does not say.
int columns_of(int fd) noexcept;

/// As much of a line of text and colours as stands in so many columns; with colours it ends without one.
std::string cut_to(std::string_view line, int columns);

/// Writes over what it showed before; a line that is too long is cut. Only where writes_over(STDERR_FILENO).
void show_status(std::string_view line) noexcept;
/// Leaves an empty line where one was shown. May be called from any thread.
void clear_status() noexcept;

/// The user does not want colours: NO_COLOR is set to something (no-color.org).
bool no_color() noexcept;

}  // namespace gantry
