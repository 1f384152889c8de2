#include "config/line_slip.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <set>
#include <vector>

#include "config/line_trials.hpp"
#include "config/text_lines.hpp"

namespace gantry::config {
namespace {

constexpr std::size_t kBytes = 2u << 20;  ///< that are read for trials
constexpr std::size_t kPlaces = 4;        ///< lines with a mistake that are looked at

using MistakeRows = std::vector<Mistakes::Row>;

std::set<std::size_t> lines_with_mistakes(const TextLines& lines, const MistakeRows& told) {
  std::set<std::size_t> all;
  for (const Mistakes::Row& row : told)
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

/// The first line with a quote that has no other in it, as what is between it and the next one is text; and above each
/// of these lines the nearest with a bracket that has none.
void add_odd_lines(const TextLines& lines, const std::set<std::size_t>& places, std::set<std::size_t>& to) {
  const auto odd = [&](std::size_t n, std::string_view signs) {
    return lines.says_something(n) &&
           std::ranges::any_of(signs, [&](char sign) { return is_odd(lines.line(n), sign); });
  };
  for (std::size_t n = 0; n < lines.count(); ++n)
    if (odd(n, "\"'")) {
      to.insert(n);
      break;
    }
  for (std::size_t n : places)
    while (n-- > 0)
      if (odd(n, "[{")) {
        to.insert(n);
        break;
      }
}

/// Lines, from 1, on which something of the file stands: not those of a text of several lines.
void add_lines(const Node& node, std::set<int>& to) {
  to.insert(node.location.line);
  for (const Node::Key& key : node.keys) to.insert(key.location.line);
  for (const Node& item : node.items) add_lines(item, to);
}
std::optional<std::set<int>> lines_read(std::string_view text) {
  Mistakes ignored("");
  const auto root = read_yaml(text, ignored);
  if (!root) return std::nullopt;
  std::set<int> out;
  add_lines(*root, out);
  return out;
}

class Search {
 public:
  Search(std::string_view text, const MistakeRows& told, const std::function<Mistakes(std::string_view)>& judge)
      : lines_(text), told_(told), judge_(judge), read_(lines_read(text)) {}

  [[nodiscard]] const TextLines& lines() const { return lines_; }
  /// At least `fewer` mistakes less than without it, and fewer than with the best trial before.
  void look_at(std::vector<LineTrial> trials, std::size_t fewer) {
    constexpr std::size_t kMostWords = 5;
    std::size_t words = 1;
    bool found_here = false;
    for (LineTrial& trial : trials) {
      const std::string text = trial.text(lines_);
      if ((bytes_ += text.size()) > kBytes) break;
      MistakeRows left = judge_(text).rows();
      if (left.size() + fewer > told_.size()) continue;
      if (best_ && (left.size() > left_.size() || (!found_here && left.size() == left_.size()))) continue;
      for (Mistakes::Row& row : left)
        if (trial.puts_in && row.location.line > static_cast<int>(trial.line + 1)) --row.location.line;
      if (!is_better(trial, left) || !is_all_read(trial, text)) continue;
      const auto rank = [](const MistakeRows& rows, const LineTrial& by) { return std::pair(rows.size(), by.cost); };
      if (!best_ || rank(left, trial) < rank(left_, *best_))
        best_ = std::move(trial), left_ = std::move(left), words = 1, found_here = true;
      else if (does_as_well(trial) && words++ < kMostWords)
        best_->message += fmt::format(" or `{}`", trial.puts_in->word);
    }
  }
  [[nodiscard]] const std::optional<LineTrial>& best() const { return best_; }
  [[nodiscard]] const MistakeRows& left() const { return left_; }

 private:
  /// Nothing is wrong that was not before, and the line is no part of something that nobody knows, whose contents are
  /// not looked at.
  [[nodiscard]] bool is_better(const LineTrial& trial, const MistakeRows& left) const {
    const auto was_told = [&](const Mistakes::Row& row) { return std::ranges::find(told_, row) != told_.end(); };
    const auto at_heading = [&](const Mistakes::Row& row) {
      return trial.heading && row.fault == Fault::UnknownKey &&
             row.location.line == static_cast<int>(*trial.heading + 1);
    };
    return std::ranges::all_of(left, was_told) && std::ranges::none_of(left, at_heading);
  }
  /// A line that has become a part of some text is not mended.
  [[nodiscard]] bool is_all_read(const LineTrial& trial, const std::string& text) const {
    const auto now = lines_read(text);
    if (!now) return false;
    const auto has = [&](std::size_t n) {
      return now->contains(static_cast<int>(n + 1 + (trial.puts_in && n >= trial.line ? 1 : 0)));
    };
    if (read_) return std::ranges::all_of(*read_, [&](int line) { return has(static_cast<std::size_t>(line - 1)); });
    std::size_t next = trial.line + 1;
    while (next < lines_.count() && !lines_.says_something(next)) ++next;
    return has(trial.line) && (next == lines_.count() || has(next));
  }
  [[nodiscard]] bool does_as_well(const LineTrial& trial) const {
    return trial.puts_in && best_->puts_in && !best_->message.ends_with("some_name:`") && trial.line == best_->line &&
           trial.puts_in->column == best_->puts_in->column;
  }

  TextLines lines_;
  const MistakeRows& told_;
  const std::function<Mistakes(std::string_view)>& judge_;
  std::optional<std::set<int>> read_;  ///< of the file as it is; nothing: it is not well-formed
  std::size_t bytes_ = 0;              ///< that were read for trials
  std::optional<LineTrial> best_;
  MistakeRows left_;
};

/// A key with its value in one line may stand in the wrong place, and in which is the right one nobody can tell.
bool has_value(const TextLines& lines, const Mistakes::Row& row) {
  const auto n = static_cast<std::size_t>(row.location.line);
  if (n == 0 || n > lines.count()) return false;
  const std::string_view line = lines.line(n - 1);
  const std::string_view words = line.substr(0, line.find(" #"));
  return words.find_last_not_of(' ') != words.find(':');
}

/// The first of several keys that stand twice in one place: what begins there lacks its heading.
std::set<std::size_t> first_double(const TextLines& lines, const MistakeRows& told) {
  std::set<std::size_t> all;
  for (const Mistakes::Row& row : told)
    if (const auto n = static_cast<std::size_t>(row.location.line);
        row.fault == Fault::DuplicateKey && n > 0 && n <= lines.count())
      all.insert(n - 1);
  if (all.size() < 2) return {};
  return {*all.begin()};
}

/// A misspelt key is that, and stands where it should.
void leave_out_misspelt(std::vector<LineTrial>& moves, const MistakeRows& told) {
  std::erase_if(moves, [&](const LineTrial& move) {
    return std::ranges::any_of(told, [&](const Mistakes::Row& row) {
      return row.fault == Fault::UnknownKey && row.location.line == static_cast<int>(move.line + 1) &&
             row.message.find("did you mean") != std::string::npos;
    });
  });
}

}  // namespace

std::optional<LineSlip> find_line_slip(std::string_view text, const Mistakes& told, std::span<const FieldShape> format,
                                       const std::function<Mistakes(std::string_view)>& judge) {
  const MistakeRows& rows = told.rows();
  const auto has = [&](Fault fault) { return std::ranges::find(rows, fault, &Mistakes::Row::fault) != rows.end(); };
  const bool not_well_formed = has(Fault::YamlSyntax);
  if (rows.size() < 2 && !not_well_formed && !has(Fault::UnknownKey)) return std::nullopt;
  Search search(text, rows, judge);
  if (rows.size() == 1 && has(Fault::UnknownKey) && has_value(search.lines(), rows[0])) return std::nullopt;
  const std::set<std::size_t> places = lines_with_mistakes(search.lines(), rows);
  std::set<std::size_t> around = with_what_leads_there(search.lines(), places);
  search.look_at(headings_put_in(search.lines(), first_double(search.lines(), rows), format), 2);  // before many others
  if (not_well_formed) {
    add_odd_lines(search.lines(), places, around);
    search.look_at(changed_signs(search.lines(), around), 1);
  }
  std::vector<LineTrial> moves = moved_lines(search.lines(), around);
  leave_out_misspelt(moves, rows);
  search.look_at(std::move(moves), 1);
  if (!search.best() || !search.left().empty())
    search.look_at(headings_put_in(search.lines(), not_well_formed ? around : places, format), not_well_formed ? 1 : 2);
  if (!search.best()) return std::nullopt;
  const LineTrial& trial = *search.best();
  LineSlip slip{Mistakes(told.file()), std::nullopt};
  slip.left.add(Fault::YamlSyntax, trial.message,
                {static_cast<int>(trial.line + 1), static_cast<int>(trial.column + 1)});
  for (const Mistakes::Row& row : search.left()) slip.left.add(row.fault, row.message, row.location);
  if (!trial.puts_in) slip.mended = trial.text(search.lines());
  return slip;
}

}  // namespace gantry::config
