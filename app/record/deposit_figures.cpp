#include "app/record/deposit_figures.hpp"

#include <algorithm>
#include <cmath>

namespace gantry::record {

double allowed_error_mm(const JobResult& r, const Deposit& d) {
  const auto corner = r.drawing.corner_tolerance_mm.find(d.id);
  return kErrorLimit_mm + (corner != r.drawing.corner_tolerance_mm.end() ? corner->second : 0);
}

DepositFigures deposit_figures(const JobResult& r) {
  DepositFigures f;
  for (const Deposit& d : r.deposits) {
    if (d.id.empty()) {
      ++f.strays;
      continue;
    }
    if (!d.nominal_mm.empty()) f.worst_gap_mm = std::max(f.worst_gap_mm, std::abs(d.gap_mm - d.nominal_mm.front().z));
    const double allowed = allowed_error_mm(r, d);
    if (!std::isfinite(d.error_mm)) continue;
    if (f.worst == nullptr || d.error_mm / allowed > f.worst->error_mm / f.worst_allowed_mm)
      f.worst = &d, f.worst_allowed_mm = allowed;
  }
  return f;
}

}  // namespace gantry::record
