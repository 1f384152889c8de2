// Where the board lies: the turn and shift that bring nominal marks onto found ones, and whether the marks agree.
//   Result<OffsetFit> fit = fit_offset(marks, {.max_residual_mm = 0.05});
//   // found = rotated(nominal, fit->rotation_rad) + fit->shift_mm: turn about the origin of the frame, then shift
// Both sides in the board's frame at its nominal position. Rigid: no scale, so a stretched board shows as residuals.
#pragma once
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/error.hpp"
#include "core/vec.hpp"

namespace gantry::vision {

struct MarkPair {
  std::string name;
  Vec2 nominal_mm, found_mm;
};

struct FitRules {
  double max_residual_mm = 0.05;  ///< of any mark
  double max_shift_mm = 5;
  double max_rotation_rad = 0.05;
};

struct MarkResidual {
  std::string name;
  Vec2 residual_mm;  ///< found minus expected
};

struct OffsetFit {
  Vec2 shift_mm;
  double rotation_rad = 0;
  std::vector<MarkResidual> residuals;  ///< in the order of the marks
  double rms_mm = 0, max_mm = 0;
  int redundancy = 0;  ///< measured numbers more than the fit has unknowns; 1 with two marks
};

/// Least squares, each mark alike (Umeyama 1991, eq. 40-42, with unit scale). At least two marks at two positions.
OffsetFit fit_rigid(std::span<const MarkPair> marks);

/// fit_rigid, and refuses what it cannot trust: Fault::MarksTooFew (fewer than two, or all at one position),
/// Fault::ResidualTooLarge (marks disagree: every residual is named, and with four marks or more the one whose absence
/// makes the others agree, if it is only one; it is never dropped), the same fault for a shift or turn beyond the
/// rules.
Result<OffsetFit> fit_offset(std::span<const MarkPair> marks, const FitRules& rules);

}  // namespace gantry::vision
