#include "config/text_lines.hpp"

namespace gantry::config {

TextLines::TextLines(std::string_view text) {
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    lines_.push_back(text.substr(at, end - at));
    at = end + 1;
  }
}

std::optional<std::size_t> TextLines::above(std::size_t n, std::size_t column) const {
  while (n-- > 0)
    if (says_something(n) && indent(n) < column) return n;
  return std::nullopt;
}

std::size_t TextLines::end_of_block(std::size_t n) const {
  std::size_t end = n + 1;
  for (std::size_t k = end; k < count(); ++k) {
    if (!says_something(k)) continue;
    if (indent(k) <= indent(n)) break;
    end = k + 1;
  }
  return end;
}

std::set<std::size_t> TextLines::columns() const {
  std::set<std::size_t> all{0};
  for (std::size_t n = 0; n < count(); ++n)
    if (says_something(n)) all.insert(indent(n));
  return all;
}

std::string TextLines::moved(std::size_t first, std::size_t end, std::ptrdiff_t by) const {
  std::string out;
  for (std::size_t n = 0; n < count(); ++n) {
    std::string_view words = lines_[n];
    if (n >= first && n < end && says_something(n)) {
      const auto column = static_cast<std::ptrdiff_t>(indent(n)) + by;
      words.remove_prefix(indent(n));
      out.append(static_cast<std::size_t>(std::max<std::ptrdiff_t>(column, 0)), ' ');
    }
    out.append(words).append(1, '\n');
  }
  return out;
}

std::string TextLines::replaced(std::size_t n, std::string_view by) const {
  std::string out;
  for (std::size_t k = 0; k < count(); ++k) out.append(k == n ? by : lines_[k]).append(1, '\n');
  return out;
}

std::string TextLines::with(std::string_view put_in, std::size_t before) const {
  std::string out;
  for (std::size_t n = 0; n < count(); ++n) {
    if (n == before) out.append(put_in).append(1, '\n');
    out.append(lines_[n]).append(1, '\n');
  }
  return out;
}

}  // namespace gantry::config
