// The rules of docs/architecture.md: which room may include which.
//   Floors floors(page);  floors.verdict("sim/esc/esc.cpp", "devices/ethercat/master.hpp")  ->  why not, or ""
#pragma once
#include <string>
#include <string_view>
#include <vector>

#include "tests/architecture/source_tree.hpp"

namespace gantry::architecture {

class Floors {
 public:
  explicit Floors(const std::string& page) : floors_(table(page, "floors")), never_(table(page, "never")) {}

  [[nodiscard]] bool empty() const { return floors_.empty() || never_.empty(); }

  /// The room of a file: the longest name in the table that it lies in; "" when there is none (tests, bench, docs).
  [[nodiscard]] std::string room(std::string_view path) const {
    std::string best;
    for (const auto& row : floors_)
      for (std::size_t i = 1; i < row.size(); ++i)
        if (within(path, row[i]) && row[i].size() > best.size()) best = row[i];
    return best;
  }

  /// Empty when `file` may include `header`, otherwise the reason why not.
  [[nodiscard]] std::string verdict(std::string_view file, std::string_view header) const {
    const std::string from = room(file), to = room(header);
    if (from.empty()) return within(file, "app") ? "this file stands in no room of the table" : "";
    if (to.empty()) return "the header stands in no room of the table";
    for (const auto& row : never_)
      for (std::size_t i = 1; i < row.size(); ++i)
        if (within(file, row[0]) && within(header, row[i])) return row[0] + " never includes " + row[i];
    if (from == to) return "";
    const std::size_t line_from = line(from), line_to = line(to);
    if (line_from == line_to) return from + " and " + to + " share a floor and do not know each other";
    if (line_from > line_to) return from + " stands below " + to;
    return "";
  }

  /// Rooms of the loop: their floor ends with 'r'; core/rt belongs to them.
  [[nodiscard]] std::vector<std::string> rt_folders() const {
    std::vector<std::string> rooms{"core/rt"};
    for (const auto& row : floors_)
      if (row[0].ends_with('r')) rooms.insert(rooms.end(), row.begin() + 1, row.end());
    return rooms;
  }

 private:
  [[nodiscard]] std::size_t line(const std::string& room) const {
    for (std::size_t n = 0; n < floors_.size(); ++n)
      for (std::size_t i = 1; i < floors_[n].size(); ++i)
        if (floors_[n][i] == room) return n;
    return floors_.size();
  }
  std::vector<std::vector<std::string>> floors_, never_;
};

}  // namespace gantry::architecture
