// The lines of a text by their columns, and texts with a line moved, changed or put in.
#pragma once
#include <algorithm>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

namespace gantry::config {

/// Of a line's first sign that is no blank, from 0; the line's length where there is none.
inline std::size_t indent_of(std::string_view line) { return std::min(line.find_first_not_of(' '), line.size()); }
/// More than blanks and a comment.
inline bool says_something(std::string_view line) {
  const std::size_t first = indent_of(line);
  return first < line.size() && line[first] != '#';
}

class TextLines {
 public:
  explicit TextLines(std::string_view text);
  [[nodiscard]] std::size_t count() const { return lines_.size(); }
  [[nodiscard]] std::string_view line(std::size_t n) const { return lines_[n]; }
  [[nodiscard]] std::size_t indent(std::size_t n) const { return indent_of(lines_[n]); }
  [[nodiscard]] bool says_something(std::size_t n) const { return config::says_something(lines_[n]); }
  /// The nearest above that says something and begins before `column`.
  [[nodiscard]] std::optional<std::size_t> above(std::size_t n, std::size_t column = std::string_view::npos) const;
  /// Behind the last line that belongs to this one: that is indented further.
  [[nodiscard]] std::size_t end_of_block(std::size_t n) const;
  /// In which lines begin; 0 always.
  [[nodiscard]] std::set<std::size_t> columns() const;
  /// The text in which the lines from `first` to before `end` begin so much further right, further left where by < 0.
  [[nodiscard]] std::string moved(std::size_t first, std::size_t end, std::ptrdiff_t by) const;
  [[nodiscard]] std::string replaced(std::size_t n, std::string_view by) const;
  [[nodiscard]] std::string with(std::string_view put_in, std::size_t before) const;

 private:
  std::vector<std::string_view> lines_;
};

}  // namespace gantry::config
