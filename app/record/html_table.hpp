// Sections and tables of the report, as HTML.
//   Table table({"axis", ">largest"});   table.row({text(name), number(x, 2)});   section("Axes", table.done());
#pragma once
#include <cmath>
#include <fmt/format.h>
#include <string>
#include <string_view>
#include <vector>

#include "app/record/html.hpp"

namespace gantry::record::html {

/// Cells are HTML already. A heading that starts with '>' is set to the right, with its column.
class Table {
 public:
  explicit Table(std::vector<std::string> headings) : headings_(std::move(headings)) {
    out_ = "<table><thead><tr>";
    for (const auto& h : headings_)
      out_ += h.starts_with('>') ? "<th class=\"r\">" + text(h.substr(1)) + "</th>" : "<th>" + text(h) + "</th>";
    out_ += "</tr></thead><tbody>";
  }
  void row(const std::vector<std::string>& cells) {
    out_ += "<tr>";
    for (std::size_t i = 0; i < cells.size(); ++i)
      out_ +=
          (i < headings_.size() && headings_[i].starts_with('>') ? "<td class=\"r\">" : "<td>") + cells[i] + "</td>";
    out_ += "</tr>";
  }
  [[nodiscard]] std::string done() const { return out_ + "</tbody></table>"; }

 private:
  std::vector<std::string> headings_;
  std::string out_;
};

inline std::string section(std::string_view title, const std::string& body) {
  return fmt::format("<section><h2>{}</h2>{}</section>\n", title, body);
}

/// "12.345 s", or "1 min 05.2 s" from a minute on.
inline std::string span_of_time(double s) {
  if (!(s >= 60)) return number(s, 2) + " s";
  const double minutes = std::floor(s / 60);
  return fmt::format("{:.0f} min {:04.1f} s", minutes, s - 60 * minutes);
}

}  // namespace gantry::record::html
