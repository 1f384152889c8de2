// How good a job's deposits are, as the report and the terminal show it: each against what is allowed at its position.
//   const DepositFigures f = deposit_figures(result);   if (f.worst) micrometres(f.worst->error_mm)
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "app/record/job_result.hpp"

namespace gantry::record {

/// Of a deposit on no feature: what a material allows that says nothing.
Allowed allowed(const JobResult& result, const Deposit& deposit);

/// The larger of what it is beside its position and off its gap, as parts of what is allowed there; infinite on no
/// feature.
double part_of_allowed(const JobResult& result, const Deposit& deposit);

struct DepositFigures {
  const Deposit* worst = nullptr;      ///< by its part of what is allowed there; null: none lies on a feature
  double worst_allowed_mm = 0;         ///< of that one
  const Deposit* worst_gap = nullptr;  ///< the same of its gap; null: no gap is known
  double worst_gap_mm = 0;          ///< deviation from the gap that was asked for, the largest part of what is allowed
  double worst_gap_allowed_mm = 0;  ///< of that one; 0: no gap is known
  bool gaps_within = true;          ///< each is within its tolerance
  std::size_t strays = 0;           ///< on no feature
  [[nodiscard]] bool within() const { return worst == nullptr || worst->error_mm <= worst_allowed_mm; }
};
DepositFigures deposit_figures(const JobResult& result);

/// How far the needle has gone with the valve open.
double length_mm(const Deposit& deposit);

/// A bead or a fill, as the recipe draws it and as it was dispensed.
struct LaidLength {
  std::string name, kind;
  double drawn_mm = 0;
  std::optional<double> laid_mm;               ///< nothing where no world has seen it, or nothing lies there
  std::optional<double> area_mm2, spacing_mm;  ///< of a fill
  std::size_t beads = 1;
};
/// One row a bead and one a fill; the beads of a fill are counted in its row.
std::vector<LaidLength> laid_lengths(const JobResult& result);

}  // namespace gantry::record
