#include "app/record/deposit_figures.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <string_view>

namespace gantry::record {

Allowed allowed(const JobResult& r, const Deposit& d) {
  const auto found = r.drawing.allowed.find(d.id);
  return found != r.drawing.allowed.end() ? found->second : Allowed{};
}

namespace {

/// From the gap that was asked for, which must be known.
double off_gap_mm(const Deposit& d) { return std::abs(d.gap_mm - d.asked_gap_mm); }

}  // namespace

double part_of_allowed(const JobResult& r, const Deposit& d) {
  if (d.id.empty() || !std::isfinite(d.error_mm)) return std::numeric_limits<double>::infinity();
  const Allowed may = allowed(r, d);
  const double beside = d.error_mm / may.beside_mm;
  return std::isfinite(d.asked_gap_mm) ? std::max(beside, off_gap_mm(d) / may.gap_mm) : beside;
}

DepositFigures deposit_figures(const JobResult& r) {
  DepositFigures f;
  for (const Deposit& d : r.deposits) {
    if (d.id.empty()) {
      ++f.strays;
      continue;
    }
    const Allowed may = allowed(r, d);
    if (std::isfinite(d.asked_gap_mm)) {
      const double off_mm = off_gap_mm(d);
      if (f.worst_gap_allowed_mm == 0 || off_mm / may.gap_mm > f.worst_gap_mm / f.worst_gap_allowed_mm)
        f.worst_gap = &d, f.worst_gap_mm = off_mm, f.worst_gap_allowed_mm = may.gap_mm;
      f.gaps_within = f.gaps_within && off_mm <= may.gap_mm;
    }
    if (!std::isfinite(d.error_mm)) continue;
    if (f.worst == nullptr || d.error_mm / may.beside_mm > f.worst->error_mm / f.worst_allowed_mm)
      f.worst = &d, f.worst_allowed_mm = may.beside_mm;
  }
  return f;
}

double length_mm(const Deposit& deposit) {
  double mm = 0;
  for (std::size_t i = 1; i < deposit.board_mm.size(); ++i) mm += norm(deposit.board_mm[i] - deposit.board_mm[i - 1]);
  return mm;
}

std::vector<LaidLength> laid_lengths(const JobResult& r) {
  std::map<std::string_view, double> laid;
  for (const Deposit& d : r.deposits)
    if (on_feature(d)) laid[d.id] += length_mm(d);
  std::vector<LaidLength> rows;
  std::size_t in_fill = 0;  // beads of the fill of the last row that are still to come
  auto fill = r.fills.begin();
  for (const DrawnBead& bead : r.beads) {
    if (in_fill == 0) {
      LaidLength& row = rows.emplace_back(LaidLength{bead.id, bead.kind, 0, {}, {}, {}, 1});
      if (bead.kind == "fill" && fill != r.fills.end()) {
        row.name = fill->name, row.area_mm2 = fill->area_mm2, row.spacing_mm = fill->spacing_mm;
        in_fill = row.beads = fill->beads;
        ++fill;
      } else {
        in_fill = 1;
      }
    }
    rows.back().drawn_mm += bead.length_mm;
    if (const auto found = laid.find(bead.id); found != laid.end())
      rows.back().laid_mm = rows.back().laid_mm.value_or(0) + found->second;
    --in_fill;
  }
  return rows;
}

}  // namespace gantry::record
