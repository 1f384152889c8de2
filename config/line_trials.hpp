// What a hand may have slipped on in one line of a file, each as a text to be read once more and as words to tell it.
#pragma once
#include <cstddef>
#include <functional>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "config/text_lines.hpp"

namespace gantry::config {

struct FieldShape;

/// One line that is not as it was. Lines and columns count from 0.
struct LineTrial {
  std::size_t line = 0, column = 0;  ///< where it is told
  std::size_t cost = 0;              ///< where several help, the least is taken
  std::string message{};
  std::function<std::string(const TextLines&)> text{};
  std::optional<std::size_t> heading{};  ///< the line that a moved one is a part of then
  /// A line is put in above this one, in this column; other words may do there as well.
  struct PutIn {
    std::size_t column = 0;
    std::string word{};
  };
  std::optional<PutIn> puts_in{};
};

/// Has a line one of these signs too many, or too few? Quotes come in pairs; as many brackets open as close.
bool is_odd(std::string_view line, char sign);

/// Lines, alone or with what belongs to them, in every column in which one begins.
std::vector<LineTrial> moved_lines(const TextLines& lines, const std::set<std::size_t>& places);
/// A quote that has no other in its line, left out or closed; a bracket left out or put at a line's end; a colon behind
/// its first word.
std::vector<LineTrial> changed_signs(const TextLines& lines, const std::set<std::size_t>& places);
/// Headings above lines, in every column up to theirs: a name of some sort, and those of the format.
std::vector<LineTrial> headings_put_in(const TextLines& lines, const std::set<std::size_t>& places,
                                       std::span<const FieldShape> format);

}  // namespace gantry::config
