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

/// One line that is not as it was, and what to tell of it.
struct Trial {
  std::size_t line = 0, column = 0;  ///< from 0, where it is told
  std::size_t cost = 0;              ///< where several help, the least is taken
  std::string message{};
  std::string word{};  ///< of a line that is put in above this one, in this column; others may do there as well
  std::size_t word_column = 0;
  bool puts_in = false;
  std::function<std::string(const TextLines&)> text{};
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

std::string moved_in_words(const TextLines& lines, std::size_t n, std::size_t column, bool all) {
  std::string inside;
  if (const auto heading = lines.above(n, column)) {
    std::string_view words = lines.line(*heading).substr(lines.indent(*heading));
    if (words.starts_with("- ")) words.remove_prefix(2);
    inside = fmt::format(", as a part of '{}'", words.substr(0, words.find(':')));
  }
  return fmt::format("this line{} begins in column {} and does not fit there; begin it in column {}{}",
                     all ? ", with what belongs to it," : "", lines.indent(n) + 1, column + 1, inside);
}

/// Lines, alone or with what belongs to them, in every column in which one begins.
std::vector<Trial> moves(const TextLines& lines, const std::set<std::size_t>& places) {
  std::vector<Trial> out;
  for (const std::size_t n : places)
    for (const std::size_t column : lines.columns())
      for (const std::size_t end : std::set{n + 1, lines.end_of_block(n)}) {
        const auto by = static_cast<std::ptrdiff_t>(column) - static_cast<std::ptrdiff_t>(lines.indent(n));
        if (by == 0) continue;
        Trial trial{n, lines.indent(n), static_cast<std::size_t>(std::abs(by)) + end - n};
        trial.message = moved_in_words(lines, n, column, end > n + 1);
        trial.text = [=](const TextLines& all) { return all.moved(n, end, by); };
        out.push_back(std::move(trial));
      }
  return out;
}

std::string one_too_many(char sign) {
  if (sign == '"' || sign == '\'')
    return fmt::format("a quote that never ends, or one too many: close it, or take this {} away", sign);
  return fmt::format("this {} is one too many; take it away", sign);
}

/// A quote or a bracket that is left out, or a colon that is put behind the first word.
std::vector<Trial> edits(const TextLines& lines, const std::set<std::size_t>& places) {
  constexpr const char* kSigns = "\"'[]{}";
  std::vector<Trial> out;
  const auto instead = [&](std::size_t n, std::size_t column, std::string line, std::string message) {
    out.push_back({.line = n,
                   .column = column,
                   .message = std::move(message),
                   .text = [n, line = std::move(line)](const TextLines& all) { return all.replaced(n, line); }});
  };
  for (const std::size_t n : places) {
    const std::string line(lines.line(n));
    for (std::size_t at = line.find_first_of(kSigns); at != std::string::npos; at = line.find_first_of(kSigns, at + 1))
      instead(n, at, std::string(line).erase(at, 1), one_too_many(line[at]));
    const std::size_t first = lines.indent(n) + (line.substr(lines.indent(n)).starts_with("- ") ? 2 : 0);
    const std::size_t end = std::min(line.find_first_of(": ", first), line.size());
    const std::string rest = line.substr(std::min(line.find_first_not_of(": ", end), line.size()));
    if (end > first)
      instead(n, first, fmt::format("{}: {}", line.substr(0, end), rest),
              fmt::format("'{}' has no ': ' behind it; write it, with the blank", line.substr(first, end - first)));
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

/// Headings above lines, in every column up to theirs.
std::vector<Trial> put_in(const TextLines& lines, const std::set<std::size_t>& places,
                          std::span<const FieldShape> format) {
  std::set<std::string> known;
  headings(format, "", known);
  std::vector<Trial> out;
  const auto above = [&](std::size_t n, std::size_t column, const std::string& heading, const char* what) {
    Trial trial{n, lines.indent(n)};
    trial.message =
        fmt::format("a line is missing above this one, which begins in column {}: {} `{}`", column + 1, what, heading);
    trial.puts_in = true;
    trial.text = [n, line = std::string(column, ' ') + heading](const TextLines& all) { return all.with(line, n); };
    out.push_back(std::move(trial));
  };
  for (const std::size_t n : places)
    for (const std::size_t column : lines.columns()) {
      if (column > lines.indent(n)) break;
      above(n, column, fmt::format("{}:", kSomeName), "the name of what follows, such as");  // for which keys do, too
      for (const std::string& heading : known)
        above(n, column, heading, "for example"), out.back().word = heading, out.back().word_column = column;
    }
  return out;
}

struct Found {
  Trial trial;
  MistakeRows left;
};

/// The trial that leaves least, and nothing that was not there before: at least `fewer` mistakes less.
std::optional<Found> best(const TextLines& lines, std::vector<Trial> trials, const MistakeRows& told, std::size_t fewer,
                          const std::function<Mistakes(std::string_view)>& judge) {
  constexpr std::size_t kMostWords = 5;
  std::optional<Found> best;
  std::size_t bytes = 0, words = 1;
  for (Trial& trial : trials) {
    const std::string text = trial.text(lines);
    if ((bytes += text.size()) > kBytes) break;
    MistakeRows left = judge(text).rows();
    if (left.size() + fewer > told.size()) continue;
    for (Mistakes::Row& row : left)
      if (trial.puts_in && row.location.line > static_cast<int>(trial.line + 1)) --row.location.line;
    if (!std::ranges::all_of(left, [&](const auto& row) { return std::ranges::find(told, row) != told.end(); }))
      continue;
    if (!best || std::pair(left.size(), trial.cost) < std::pair(best->left.size(), best->trial.cost))
      best = Found{std::move(trial), std::move(left)}, words = 1;
    else if (!trial.word.empty() && !best->trial.word.empty() && trial.line == best->trial.line &&
             trial.word_column == best->trial.word_column && left.size() == best->left.size() && words++ < kMostWords)
      best->trial.message += fmt::format(" or `{}`", trial.word);
  }
  return best;
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
  slip.left.add(Fault::YamlSyntax, trial.message,
                {static_cast<int>(trial.line + 1), static_cast<int>(trial.column + 1)});
  for (const Mistakes::Row& row : found->left) slip.left.add(row.fault, row.message, row.location);
  if (!trial.puts_in) slip.mended = trial.text(lines);
  return slip;
}

}  // namespace gantry::config
