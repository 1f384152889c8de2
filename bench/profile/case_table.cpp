#include "bench/profile/case_table.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>

namespace gantry::bench {
namespace {

/// Cells of a line as RFC 4180 has them: quotes around a cell protect its commas, two of them inside are one. A quoted
/// cell does not go on in the next line.
std::vector<std::string> cells_of(std::string line) {
  if (!line.empty() && line.back() == '\r') line.pop_back();
  std::vector<std::string> cells(1);
  bool quoted = false;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const char c = line[i];
    if (quoted && c == '"' && i + 1 < line.size() && line[i + 1] == '"')
      cells.back() += line[++i];
    else if (c == '"' && (quoted || cells.back().empty()))
      quoted = !quoted;
    else if (c == ',' && !quoted)
      cells.emplace_back();
    else
      cells.back() += c;
  }
  return cells;
}

}  // namespace

std::string quoted(const std::string& cell) {
  if (cell.find_first_of(",\"") == std::string::npos) return cell;
  std::string out = "\"";
  for (const char c : cell) out += c == '"' ? std::string("\"\"") : std::string(1, c);
  return out + '"';
}

std::optional<CaseTable> CaseTable::open(std::istream& in, std::string& error) {
  CaseTable table(in);
  std::string line;
  if (!std::getline(in, line)) {
    error = "no header: the first line names the columns, id,p0,v0,...";
    return std::nullopt;
  }
  if (line.starts_with("\xef\xbb\xbf")) line.erase(0, 3);  // some editors mark UTF-8
  table.names_ = cells_of(line);
  const auto& names = table.names_;
  const auto column = [&](const std::string& name) {
    const auto at = std::find(names.begin(), names.end(), name);
    return at == names.end() ? -1 : static_cast<int>(at - names.begin());
  };
  table.id_ = column("id");
  table.min_duration_ = column("min_duration");
  const bool several = column("v0_0") >= 0;
  table.kind_ = column(several ? "pf_0" : "pf") >= 0 ? Kind::Position : Kind::Velocity;
  for (int axis = 0;; ++axis) {
    const std::string suffix = several ? "_" + std::to_string(axis) : "";
    const auto of = [&](const char* name) { return column(name + suffix); };
    if (several && of("v0") < 0) break;
    const Columns c{of("p0"),   of("v0"),   of("a0"),   of("pf"),   of("vf"),   of("af"),   of("vmax"),
                    of("vmin"), of("amax"), of("amin"), of("jmax"), of("jmin"), of("pmin"), of("pmax")};
    for (const auto& [name, at] :
         {std::pair{"v0", c.v0}, {"a0", c.a0}, {"vf", c.vf}, {"amax", c.a_max}, {"jmax", c.j_max}})
      if (at < 0 && error.empty()) error = "column '" + (name + suffix) + "' is missing";
    if (error.empty() && table.kind_ == Kind::Position && (c.p0 < 0 || c.v_max < 0))
      error = "columns 'p0" + suffix + "' and 'vmax" + suffix + "' are needed beside 'pf" + suffix + "'";
    table.columns_.push_back(c);
    if (!several) break;
  }
  if (table.id_ < 0) error = "column 'id' is missing";
  if (!error.empty()) return std::nullopt;
  return table;
}

std::optional<Case> CaseTable::next(std::string& error) {
  std::string line;
  do {
    if (!std::getline(*in_, line)) return std::nullopt;
    ++line_;
  } while (line.empty() || line == "\r");
  const auto cells = cells_of(line);
  const auto number = [&](int at, double otherwise) {
    if (at < 0) return otherwise;
    const auto i = static_cast<std::size_t>(at);
    const char* text = i < cells.size() ? cells[i].c_str() : "";
    char* end = nullptr;
    const double value = std::strtod(text, &end);
    if (error.empty() && (end == text || *end != '\0'))
      error = "line " + std::to_string(line_) + ", column '" + names_[i] + "': '" + text + "' is no number";
    return value;
  };
  Case c;
  c.id = static_cast<std::size_t>(id_) < cells.size() ? cells[static_cast<std::size_t>(id_)] : "";
  const double least = number(min_duration_, 0);
  c.min_duration_s = std::isnan(least) ? 0 : least;
  for (const Columns& k : columns_) {
    motion::AxisMove m;
    m.from = {number(k.p0, 0), number(k.v0, 0), number(k.a0, 0)};
    m.to = {number(k.pf, 0), number(k.vf, 0), number(k.af, 0)};
    motion::AxisBounds& b = m.bounds;
    b.v_max = number(k.v_max, std::numeric_limits<double>::max()), b.v_min = number(k.v_min, -b.v_max);
    b.a_max = number(k.a_max, 0), b.a_min = number(k.a_min, -b.a_max);
    b.j_max = number(k.j_max, 0), b.j_min = number(k.j_min, -b.j_max);
    b.p_min = number(k.p_min, b.p_min), b.p_max = number(k.p_max, b.p_max);
    c.axes.push_back(m);
  }
  return c;
}

}  // namespace gantry::bench
