// Ways around bodies that were found before, for the same question asked again among bodies that stand nearly as then:
// a search begun anew would find another way, of another length, and a job would take longer or shorter than was told
// before its first motion. A known way is taken where it is free now; it is proved as any other.
//   ways.keep(from, to, clearance_mm, points);        ...        ways.like(from, to, clearance_mm)
#pragma once
#include <optional>
#include <vector>

#include "core/axis_vec.hpp"

namespace gantry::motion {

class KnownWays {
 public:
  /// `points`: both ends included; empty: there was none.
  void keep(const AxisVec& from, const AxisVec& to, double clearance_mm, std::vector<AxisVec> points);
  /// What was kept for the ends and the clearance that are nearest to these, with these ends. What stands between may
  /// have stayed where it was, or gone with one end or with both: a way for each, the likeliest first. Empty: there was
  /// none. Nothing: of ends near these nothing is known.
  [[nodiscard]] std::optional<std::vector<std::vector<AxisVec>>> like(const AxisVec& from, const AxisVec& to,
                                                                      double clearance_mm) const;

 private:
  struct Way {
    AxisVec from{}, to{};
    double clearance_mm = 0;
    std::vector<AxisVec> points;
  };
  std::vector<Way> ways_;
};

}  // namespace gantry::motion
