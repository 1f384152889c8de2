// A text that yaml-cpp finds not well-formed: what its writer most likely slipped on, and what to write.
//   const YamlSlip slip = yaml_slip(text, mark.pos, error.msg);   // slip.message at byte slip.at of the text
#pragma once
#include <string>
#include <string_view>

namespace gantry::config {

struct YamlSlip {
  std::string message;
  std::size_t at = 0;  ///< a byte of the text
};

/// text: line ends are '\n', no tabs. at: the byte that the parser stopped at. reason: what yaml-cpp says
/// (exceptions.h); one that is not known here is passed on.
YamlSlip yaml_slip(std::string_view text, std::size_t at, std::string_view reason);

/// Line and column of a byte, from 1, in characters.
struct YamlLineColumn {
  int line = 1, column = 1;
};
YamlLineColumn line_and_column(std::string_view text, std::size_t at);

}  // namespace gantry::config
