#include "config/line_trials.hpp"

#include <algorithm>
#include <cstdlib>
#include <fmt/format.h>

#include "config/fields.hpp"

namespace gantry::config {
namespace {

constexpr std::size_t kLongLine = 2000;  ///< a list of points; signs in it are not tried one by one

/// The word before ':' of a line, without the dash of an item; none where it has none.
std::string key_of(std::string_view words) {
  words.remove_prefix(std::min(words.find_first_not_of(' '), words.size()));
  if (words.starts_with("- ")) words.remove_prefix(2);
  const std::size_t end = words.find(':');
  if (end == std::string_view::npos || words.starts_with("- ")) return {};
  std::string_view key = words.substr(0, end);
  if (key.size() > 1 && key.front() == key.back() && (key.front() == '"' || key.front() == '\'')) {
    key.remove_prefix(1);
    key.remove_suffix(1);
  }
  return std::string(key);
}

std::string one_too_many(char sign) {
  if (sign == '"' || sign == '\'')
    return fmt::format("a quote that never ends, or one too many: close it, or take this {} away", sign);
  return fmt::format("this {} is one too many; take it away", sign);
}

}  // namespace

bool is_odd(std::string_view line, char sign) {
  line = line.substr(0, line.find(" #"));
  const auto count = [&](char c) { return std::ranges::count(line, c); };
  switch (sign) {
    case '[':
    case ']': return count('[') != count(']');
    case '{':
    case '}': return count('{') != count('}');
    default: return count(sign) % 2 != 0;
  }
}

namespace {

/// Keys behind which more stands on lines of their own, of all depths; `- ` before those that tell the kind of an item.
void headings(std::span<const FieldShape> fields, std::string_view dash, std::set<std::string>& to) {
  using enum ValueShape::Kind;
  const std::function<void(const ValueShape&)> inside = [&](const ValueShape& shape) {
    headings(shape.fields, shape.kind == OneOf ? "- " : "", to);
    for (const ValueShape& item : shape.items) inside(item);
  };
  for (const FieldShape& field : fields) {
    const auto kind = field.shape.kind;
    if (kind == Object || kind == List || kind == Named) to.insert(fmt::format("{}{}:", dash, field.key));
    inside(field.shape);
  }
}

}  // namespace

std::vector<LineTrial> moved_lines(const TextLines& lines, const std::set<std::size_t>& places) {
  std::vector<LineTrial> out;
  for (const std::size_t n : places)
    for (const std::size_t column : lines.columns())
      for (const std::size_t end : std::set{n + 1, lines.end_of_block(n)}) {
        const auto by = static_cast<std::ptrdiff_t>(column) - static_cast<std::ptrdiff_t>(lines.indent(n));
        if (by == 0) continue;
        const auto heading = lines.above(n, column);
        const std::string inside = heading ? key_of(lines.line(*heading)) : "";
        out.push_back(
            {.line = n,
             .column = lines.indent(n),
             .cost = static_cast<std::size_t>(std::abs(by)) + end - n,
             .message = fmt::format("this line{} begins in column {} and does not fit there; begin it in column {}{}",
                                    end > n + 1 ? ", with what belongs to it," : "", lines.indent(n) + 1, column + 1,
                                    inside.empty() ? "" : fmt::format(", as a part of '{}'", inside)),
             .text = [=](const TextLines& all) { return all.moved(n, end, by); },
             .heading = heading});
      }
  return out;
}

std::vector<LineTrial> changed_signs(const TextLines& lines, const std::set<std::size_t>& places) {
  std::vector<LineTrial> out;
  const auto with = [&](std::size_t n, std::size_t column, std::string message, auto&& change) {
    out.push_back(
        {.line = n, .column = column, .message = std::move(message), .text = [n, change](const TextLines& all) {
           std::string line(all.line(n));
           change(line);
           return all.replaced(n, line);
         }});
  };
  for (const std::size_t n : places) {
    const std::string_view line = lines.line(n);
    const std::size_t behind = line.substr(0, line.find(" #")).find_last_not_of(' ') + 1;
    for (const char sign : {'}', ']'})
      if (is_odd(line, sign))
        with(n, behind, fmt::format("'{}' is missing at the end of this line", sign),
             [=](std::string& words) { words.insert(behind, 1, sign); });
    if (line.size() > kLongLine) continue;
    for (const auto& [open, close] : {std::pair{'{', '}'}, {'[', ']'}})
      if (std::ranges::count(line, close) > std::ranges::count(line, open))
        for (std::size_t at = line.find(": "); at != std::string_view::npos; at = line.find(": ", at + 1))
          with(n, at + 2, fmt::format("'{}' is missing before this", open),
               [at, sign = open](std::string& words) { words.insert(at + 2, 1, sign); });
    for (std::size_t at = 0; at < line.size(); ++at)
      if (std::string_view("\"'[]{}").find(line[at]) != std::string_view::npos && is_odd(line, line[at]))
        with(n, at, one_too_many(line[at]), [=](std::string& words) { words.erase(at, 1); });
    for (const char quote : {'"', '\''})
      if (is_odd(line, quote))
        for (std::size_t last = line.rfind(quote), at = last + 1; at <= behind; ++at)
          if (at == behind || std::string_view(",}]").find(line[at]) != std::string_view::npos)
            with(n, last, fmt::format("this {} never ends; close it behind its text", quote),
                 [=](std::string& words) { words.insert(at, 1, quote); });
    const std::size_t first = lines.indent(n) + (line.substr(lines.indent(n)).starts_with("- ") ? 2 : 0);
    const std::size_t end = std::min(line.find_first_of(": ", first), line.size());
    const std::size_t rest = std::min(line.find_first_not_of(": ", end), line.size());
    if (end > first)
      with(n, first,
           fmt::format("'{}' has no ': ' behind it; write it, with the blank", line.substr(first, end - first)),
           [=](std::string& words) { words.replace(end, rest - end, ": "); });
  }
  return out;
}

std::vector<LineTrial> headings_put_in(const TextLines& lines, const std::set<std::size_t>& places,
                                       std::span<const FieldShape> format) {
  constexpr const char* kSomeName = "some_name:";  // first: where that does, any of the format's keys would
  std::set<std::string> known;
  headings(format, "", known);
  std::vector<LineTrial> out;
  const auto above = [&](std::size_t n, std::size_t column, const std::string& heading, const char* what) {
    out.push_back(
        {.line = n,
         .column = lines.indent(n),
         .message = fmt::format("a line is missing above this one, which begins in column {}: {} `{}`", column + 1,
                                what, heading),
         .text = [n, line = std::string(column, ' ') + heading](const TextLines& all) { return all.with(line, n); },
         .puts_in = LineTrial::PutIn{column, heading}});
  };
  for (const std::size_t n : places)
    for (const std::size_t column : lines.columns()) {
      if (column > lines.indent(n)) break;
      above(n, column, kSomeName, "the name of what follows, such as");
      for (const std::string& heading : known) above(n, column, heading, "for example");
    }
  return out;
}

}  // namespace gantry::config
