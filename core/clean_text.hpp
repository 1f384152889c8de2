// Text from elsewhere (a file, the wire, a name that someone wrote) as a terminal may show it.
//   fmt::print("{}", clean_text(message));
#pragma once
#include <string>
#include <string_view>

namespace gantry {

/// Control characters (C0, DEL, C1), those that turn the direction of writing, and bytes that are no UTF-8 become the
/// replacement character U+FFFD each; blanks stand for tabs and line ends. All else stays as it is.
std::string clean_text(std::string_view text);

/// The same of each line: line ends stay.
std::string clean_lines(std::string_view text);

/// JSON text in which characters that steer a terminal or turn the direction of writing stand as \uXXXX: the same
/// document.
std::string escape_steering(std::string_view json);

}  // namespace gantry
