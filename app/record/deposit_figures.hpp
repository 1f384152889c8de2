// How good a job's deposits are, as the report and the terminal show it: each against what is allowed at its position.
//   const DepositFigures f = deposit_figures(result);   if (f.worst) micrometres(f.worst->error_mm)
#pragma once
#include "app/record/job_result.hpp"

namespace gantry::record {

/// What every deposit may be off by sideways; at corners the recipe's tolerance comes on top.
inline constexpr double kErrorLimit_mm = 0.020;
inline constexpr double kGapLimit_mm = 0.030;
double allowed_error_mm(const JobResult& result, const Deposit& deposit);

struct DepositFigures {
  const Deposit* worst = nullptr;  ///< by its part of what is allowed there; null: none lies on a feature
  double worst_allowed_mm = 0;     ///< of that one
  double worst_gap_mm = 0;         ///< largest deviation from the gap that was asked for
  std::size_t strays = 0;          ///< on no feature
  [[nodiscard]] bool within() const { return worst == nullptr || worst->error_mm <= worst_allowed_mm; }
};
DepositFigures deposit_figures(const JobResult& result);

}  // namespace gantry::record
