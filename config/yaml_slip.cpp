#include "config/yaml_slip.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <ranges>
#include <vector>

#include "config/text_lines.hpp"
#include "core/trimmed.hpp"

namespace gantry::config {
namespace {

constexpr std::size_t kShownBytes = 40;

std::size_t start_of_line(std::string_view text, std::size_t at) {
  const auto end = at == 0 ? std::string_view::npos : text.rfind('\n', at - 1);
  return end == std::string_view::npos ? 0 : end + 1;
}
std::string_view line_at(std::string_view text, std::size_t start) {
  return text.substr(start, text.find('\n', start) - start);
}

/// What stands before a byte. Brackets in quotes and comments count for nothing.
struct Before {
  std::vector<std::size_t> open;   ///< bytes of the brackets that are
  std::vector<std::size_t> lines;  ///< starts of those that say something and begin in no bracket
};
Before before(std::string_view text, std::size_t at) {
  Before out;
  auto& open = out.open;
  char quote = 0;
  for (std::size_t i = 0; i < at; ++i) {
    const char c = text[i];
    if ((i == 0 || text[i - 1] == '\n') && open.empty() && quote == 0 && says_something(line_at(text, i)))
      out.lines.push_back(i);
    const bool begins = i == 0 || std::string_view(" \n[{,:").find(text[i - 1]) != std::string_view::npos;
    if (quote != 0) {
      if (quote == '"' && c == '\\') ++i;
      if (c == quote) quote = 0;
    } else if ((c == '"' || c == '\'') && begins) {
      quote = c;
    } else if (c == '#' && (i == 0 || text[i - 1] == ' ' || text[i - 1] == '\n')) {
      i = std::min(text.find('\n', i), at) - 1;
    } else if ((c == '[' || c == '{') && (begins || !open.empty())) {
      open.push_back(i);
    } else if ((c == ']' || c == '}') && !open.empty()) {
      open.pop_back();
    }
  }
  return out;
}

std::string end_of_flow(std::string_view text, std::size_t at) {
  const auto open = before(text, at).open;
  const bool at_end = text.find_first_not_of(" \n", at) == std::string_view::npos;
  if (open.empty()) return at_end ? "a bracket is missing" : fmt::format("'{}' closes nothing; take it away", text[at]);
  const char opens = text[open.back()], closes = opens == '[' ? ']' : '}';
  const auto there = line_and_column(text, open.back());
  const bool other = !at_end && (text[at] == ']' || text[at] == '}');
  const std::string wanted = at_end  ? fmt::format("'{}' is missing", closes)
                             : other ? fmt::format("'{}' is missing before this", closes)
                                     : fmt::format("',' or '{}' is missing before this", closes);
  return fmt::format("{}; the '{}' stands at {}:{}", wanted, opens, there.line, there.column);
}

/// Starts of the lines above that this one could be level with, the nearest first: each is less deep than those below.
std::vector<std::size_t> levels_above(std::string_view text, std::size_t line_start) {
  std::vector<std::size_t> levels;
  for (const std::size_t start : std::views::reverse(before(text, line_start).lines))
    if (levels.empty() || indent_of(line_at(text, start)) < indent_of(line_at(text, levels.back())))
      levels.push_back(start);
  return levels;
}

int line_of(std::string_view text, std::size_t at) { return line_and_column(text, at).line; }

std::string out_of_line(std::string_view text, std::size_t at) {
  const auto start = start_of_line(text, at);
  const auto line = line_at(text, start);
  const auto indent = indent_of(line);
  if (line.substr(indent).starts_with('-') && !line.substr(indent).starts_with("- ")) {
    const auto word = line.substr(indent + 1, line.find_first_of(" :", indent + 1) - indent - 1);
    return fmt::format("a '-' that begins an item wants a blank behind it; write '- {}'", word.substr(0, kShownBytes));
  }
  const auto away = [&](std::size_t level) {
    const auto there = indent_of(line_at(text, level));
    return there > indent ? there - indent : indent - there;
  };
  const auto levels = levels_above(text, start);
  const auto nearest = std::ranges::min_element(levels, {}, away);
  if (nearest == levels.end()) return "this line does not belong to what stands above it; begin it in column 1";
  const auto item =
      std::ranges::find_if(levels, [&](std::size_t level) { return trimmed(line_at(text, level)).starts_with("- "); });
  if (line.substr(indent).starts_with("- ") && item != levels.end() && away(*item) != 0)
    return fmt::format("this item begins in column {}; begin it in column {}, as line {} does", indent + 1,
                       indent_of(line_at(text, *item)) + 1, line_of(text, *item));
  if (away(*nearest) == 0 && line.substr(indent).starts_with("- ") &&
      !trimmed(line_at(text, *nearest)).starts_with("- "))
    return fmt::format(
        "an item of a list begins here, among keys such as line {}; write the key of that list in a line "
        "above it, or take the '- ' away",
        line_of(text, *nearest));
  if (away(*nearest) == 0)
    return fmt::format(
        "this line stands among items, as line {0}, and is none; begin it with '- ', or farther left, or "
        "take the '- ' of line {0} away",
        line_of(text, *nearest));
  return fmt::format("this line begins in column {}; begin it in column {}, as line {} does", indent + 1,
                     indent_of(line_at(text, *nearest)) + 1, line_of(text, *nearest));
}

/// A ':' where none can stand: the second of its line, or the first one below a line that has none.
YamlSlip stray_colon(std::string_view text, std::size_t at) {
  const auto start = start_of_line(text, at);
  const auto line = line_at(text, start);
  const auto key = line.find(": ");
  const YamlSlip second{"a second ': ' in one line; put text with ': ' in it in quotes", at};
  if ((key != std::string_view::npos && start + key < at) || !before(text, at).open.empty()) return second;
  const auto levels = levels_above(text, start);
  if (levels.empty()) return second;
  const auto above = line_at(text, levels.front());
  const auto above_indent = indent_of(above);
  const auto colon = above.find(": ");
  if (colon == std::string_view::npos)
    return {fmt::format("'{}' has no ': ' between a key and its value; write it, with the blank",
                        above.substr(above_indent, kShownBytes)),
            levels.front() + above_indent};
  return {fmt::format("this line begins in column {}, and '{}' on line {} has a value already; begin it in column {}",
                      indent_of(line) + 1, above.substr(above_indent, colon - above_indent),
                      line_of(text, levels.front()), above_indent + 1),
          at};
}

}  // namespace

YamlLineColumn line_and_column(std::string_view text, std::size_t at) {
  const auto start = start_of_line(text, at);
  const auto characters = [](std::string_view part) {
    return static_cast<int>(std::ranges::count_if(part, [](char c) { return (c & 0xC0) != 0x80; }));
  };
  return {1 + static_cast<int>(std::ranges::count(text.substr(0, start), '\n')),
          1 + characters(text.substr(start, at - start))};
}

YamlSlip yaml_slip(std::string_view text, std::size_t at, std::string_view reason) {
  at = std::min(at, text.size());
  if (reason == "end of map flow not found" || reason == "end of sequence flow not found" ||
      reason == "illegal flow end")
    return {end_of_flow(text, at), at};
  if (reason == "end of map not found" || reason == "end of sequence not found") return {out_of_line(text, at), at};
  if (reason == "illegal map value") return stray_colon(text, at);
  if (reason == "unknown token" && at < text.size())
    return {fmt::format("no text begins with '{}'; put it in quotes", text[at]), at};
  if (reason.starts_with("unknown escape character"))
    return {"in double quotes '\\' begins an escape; use single quotes, or write it twice", at};
  return {fmt::format("not well-formed YAML: {}; text with signs such as : # [ {{ belongs in quotes", reason), at};
}

}  // namespace gantry::config
