#include "config/line_slip.hpp"

#include <algorithm>
#include <cstdlib>
#include <fmt/format.h>
#include <set>
#include <vector>

#include "config/fields.hpp"
#include "config/text_lines.hpp"

namespace gantry::config {
namespace {

constexpr std::size_t kBytes = 2u << 20;  ///< that are read for trials
constexpr std::size_t kPlaces = 4;        ///< lines with a mistake that are looked at
constexpr const char* kSomeName = "some_name";

using MistakeRows = std::vector<Mistakes::Row>;

/// The lines from `line` to before `end` begin so much further right; or one is put in above `line`; or something else
/// stands in it.
struct Trial {
  std::size_t line = 0, end = 0;
  std::ptrdiff_t by = 0;
  std::string put_in{};   ///< with its blanks
  std::string instead{};  ///< of the line
  std::string words{};    ///< what to do with `at`, where another line stands instead
  std::size_t at = 0;
  [[nodiscard]] std::string text(const TextLines& lines) const {
    if (!instead.empty()) return lines.replaced(line, instead);
    return put_in.empty() ? lines.moved(line, end, by) : lines.with(put_in, line);
  }
  [[nodiscard]] std::size_t column() const { return put_in.find_first_not_of(' '); }
  /// The more of them would help, the rather it is one sign or a short move of one line.
  [[nodiscard]] std::size_t cost() const { return static_cast<std::size_t>(std::abs(by)) + (end - line); }
};

std::set<std::size_t> lines_with_mistakes(const TextLines& lines, const Mistakes& told) {
  std::set<std::size_t> all;
  for (const Mistakes::Row& row : told.rows())
    if (const auto n = static_cast<std::size_t>(row.location.line); n > 0 && n <= lines.count())
      if (lines.says_something(n - 1)) all.insert(n - 1);
  while (all.size() > kPlaces) all.erase(std::prev(all.end()));
  return all;
}

/// The same, what stands above each, its heading, and the first line under that.
std::set<std::size_t> with_what_leads_there(const TextLines& lines, const std::set<std::size_t>& places) {
  std::set<std::size_t> all = places;
  for (const std::size_t n : places) {
    if (const auto last = lines.above(n)) all.insert(*last);
    const auto heading = lines.above(n, lines.indent(n));
    if (!heading) continue;
    all.insert(*heading);
    std::size_t first = *heading + 1;
    while (!lines.says_something(first)) ++first;
    all.insert(first);
  }
  return all;
}

/// Lines, alone or with what belongs to them, in every column in which one begins.
std::vector<Trial> moves(const TextLines& lines, const std::set<std::size_t>& places) {
  std::vector<Trial> out;
  for (const std::size_t n : places)
    for (const std::size_t column : lines.columns()) {
      const auto by = static_cast<std::ptrdiff_t>(column) - static_cast<std::ptrdiff_t>(lines.indent(n));
      if (by == 0) continue;
      out.push_back({n, n + 1, by});
      if (const std::size_t end = lines.end_of_block(n); end > n + 1) out.push_back({n, end, by});
    }
  return out;
}

/// A quote or a bracket that is left out, or a colon that is put behind the first word.
std::vector<Trial> edits(const TextLines& lines, const std::set<std::size_t>& places) {
  std::vector<Trial> out;
  for (const std::size_t n : places) {
    const std::string line(lines.line(n));
    for (std::size_t at = line.find_first_of("\"'[]{}"); at != std::string::npos;
         at = line.find_first_of("\"'[]{}", at + 1))
      out.push_back({n,
                     n,
                     0,
                     {},
                     std::string(line).erase(at, 1),
                     fmt::format("this {} is one too many; take it away", line[at]),
                     at});
    std::size_t first = lines.indent(n);
    if (line.substr(first).starts_with("- ")) first += 2;
    const std::size_t end = std::min(line.find_first_of(": ", first), line.size());
    std::string rest = line.substr(std::min(end + (line.substr(end).starts_with(":") ? 1 : 0), line.size()));
    if (!rest.starts_with(' ')) rest = " " + rest;
    const std::string word = line.substr(first, end - first);
    if (!word.empty())
      out.push_back({n,
                     n,
                     0,
                     {},
                     fmt::format("{}:{}", line.substr(0, end), rest),
                     fmt::format("'{}' has no ': ' behind it; write it, with the blank", word),
                     first});
  }
  return out;
}

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

std::vector<Trial> put_in(const TextLines& lines, const std::set<std::size_t>& places,
                          std::span<const FieldShape> format) {
  std::set<std::string> known;
  headings(format, "", known);
  std::vector<std::string> words{fmt::format("{}:", kSomeName)};  // first: a known key does for a name, too
  words.insert(words.end(), known.begin(), known.end());
  std::vector<Trial> out;
  for (const std::size_t n : places)
    for (const std::size_t column : lines.columns())
      for (const std::string& heading : words)
        if (column <= lines.indent(n)) out.push_back({n, n, 0, std::string(column, ' ') + heading});
  return out;
}

struct Found {
  Trial trial;
  MistakeRows left;
  std::vector<std::string> as_well{};  ///< what might be put in there instead, with its blanks
};

/// The trial that leaves least, and nothing that was not there before: at least `fewer` mistakes less.
std::optional<Found> best(const TextLines& lines, const std::vector<Trial>& trials, const MistakeRows& told,
                          std::size_t fewer, const std::function<Mistakes(std::string_view)>& judge) {
  std::optional<Found> best;
  std::size_t bytes = 0;
  for (const Trial& trial : trials) {
    const std::string text = trial.text(lines);
    if ((bytes += text.size()) > kBytes) break;
    MistakeRows left = judge(text).rows();
    if (left.size() + fewer > told.size()) continue;
    for (Mistakes::Row& row : left)
      if (!trial.put_in.empty() && row.location.line > static_cast<int>(trial.line + 1)) --row.location.line;
    if (!std::ranges::all_of(left, [&](const auto& row) { return std::ranges::find(told, row) != told.end(); }))
      continue;
    const auto rank = [](const MistakeRows& rows, const Trial& by) { return std::pair(rows.size(), by.cost()); };
    if (!best || rank(left, trial) < rank(best->left, best->trial))
      best = Found{trial, std::move(left)};
    else if (!trial.put_in.empty() && trial.line == best->trial.line && left.size() == best->left.size() &&
             trial.column() == best->trial.column())
      best->as_well.push_back(trial.put_in);
  }
  return best;
}

std::string in_words(const TextLines& lines, const Found& found) {
  constexpr std::size_t kMost = 4;
  const Trial& trial = found.trial;
  if (!trial.instead.empty()) return trial.words;
  if (!trial.put_in.empty()) {
    std::string words = fmt::format("`{}`", trial.put_in.substr(trial.column()));
    const bool any_name = words.starts_with(fmt::format("`{}", kSomeName));
    for (std::size_t k = 0; !any_name && k < std::min(found.as_well.size(), kMost); ++k)
      words += fmt::format(" or `{}`", found.as_well[k].substr(trial.column()));
    return fmt::format("a line is missing above this one, which begins in column {}: {} {}", trial.column() + 1,
                       any_name ? "the name of what follows, such as" : "for example", words);
  }
  const std::size_t now = lines.indent(trial.line), then = now + static_cast<std::size_t>(trial.by);
  const auto heading = lines.above(trial.line, then);
  std::string inside;
  if (heading) {
    std::string_view words = lines.line(*heading).substr(lines.indent(*heading));
    if (words.starts_with("- ")) words.remove_prefix(2);
    inside = fmt::format(", as a part of '{}'", words.substr(0, words.find(':')));
  }
  return fmt::format("this line{} begins in column {} and does not fit there; begin it in column {}{}",
                     trial.end > trial.line + 1 ? ", with what belongs to it," : "", now + 1, then + 1, inside);
}

}  // namespace

std::optional<LineSlip> find_line_slip(std::string_view text, const Mistakes& told, std::span<const FieldShape> format,
                                       const std::function<Mistakes(std::string_view)>& judge) {
  const auto is = [&](Fault fault) { return told.rows().size() == 1 && told.rows()[0].fault == fault; };
  const bool not_well_formed = is(Fault::YamlSyntax);
  if (told.rows().size() < 2 && !not_well_formed && !is(Fault::UnknownKey)) return std::nullopt;
  const TextLines lines(text);
  const std::set<std::size_t> places = lines_with_mistakes(lines, told);
  const std::set<std::size_t> around = with_what_leads_there(lines, places);
  std::vector<Trial> trials = moves(lines, around);
  if (not_well_formed) std::ranges::move(edits(lines, around), std::back_inserter(trials));
  auto found = best(lines, trials, told.rows(), 1, judge);
  if (!found) found = best(lines, put_in(lines, places, format), told.rows(), 2, judge);
  if (!found) return std::nullopt;
  const Trial& trial = found->trial;
  LineSlip slip{Mistakes(told.file()), std::nullopt};
  const std::size_t column = trial.instead.empty() ? lines.indent(trial.line) : trial.at;
  slip.left.add(Fault::YamlSyntax, in_words(lines, *found),
                {static_cast<int>(trial.line + 1), static_cast<int>(column + 1)});
  for (const Mistakes::Row& row : found->left) slip.left.add(row.fault, row.message, row.location);
  if (trial.put_in.empty()) slip.mended = trial.text(lines);
  return slip;
}

}  // namespace gantry::config
