// Cases of state-to-state motion as CSV: a header, then one case a line. Columns are found by name, others ignored.
//   1 axis     id,p0,v0,a0,pf,vf,af,vmax,vmin,amax,amin,jmax
//   several    the same names with suffix _0, _1 ..., and min_duration (nan: none); time-synchronised
//   velocity   id,p0,v0,a0,vf,af,amax,amin,jmax
// id is free text, in quotes where it holds a comma. vmin and amin are negative. Without jmin, vmin or amin the bound
// is symmetric; pmin and pmax may be given.
#pragma once
#include <istream>
#include <optional>
#include <string>
#include <vector>

#include "motion/profile/together.hpp"

namespace gantry::bench {

enum class Kind { Position, Velocity };

struct Case {
  std::string id;
  std::vector<motion::AxisMove> axes;
  double min_duration_s = 0;
};

/// A cell as it is written to CSV: in quotes where it holds a comma or a quote.
std::string quoted(const std::string& cell);

class CaseTable {
 public:
  /// Reads the header. The error is a text that names the column that is missing.
  static std::optional<CaseTable> open(std::istream& in, std::string& error);
  [[nodiscard]] Kind kind() const { return kind_; }
  [[nodiscard]] std::size_t axes() const { return columns_.size(); }
  /// The next case; nothing at the end. A line that cannot be read sets `error` to its number and reason.
  std::optional<Case> next(std::string& error);

 private:
  struct Columns {
    int p0, v0, a0, pf, vf, af, v_max, v_min, a_max, a_min, j_max, j_min, p_min, p_max;
  };
  explicit CaseTable(std::istream& in) : in_(&in) {}
  std::istream* in_;
  Kind kind_ = Kind::Position;
  int id_ = -1, min_duration_ = -1;
  std::vector<Columns> columns_;
  std::vector<std::string> names_;
  std::size_t line_ = 1;
};

}  // namespace gantry::bench
