// A text without the blanks at its ends: what stands between commas and behind keys.
#pragma once
#include <string_view>

namespace gantry {

/// Blanks are spaces and tabs. Of nothing but blanks an empty part of it is left.
constexpr std::string_view trimmed(std::string_view text) noexcept {
  constexpr std::string_view kBlank = " \t";
  const auto first = text.find_first_not_of(kBlank);
  return first == std::string_view::npos ? text.substr(0, 0)
                                         : text.substr(first, text.find_last_not_of(kBlank) - first + 1);
}

}  // namespace gantry
