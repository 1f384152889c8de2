// From what was measured to where the board lies. Pure.
//   auto offset  = settle_offset(recipe, state.known.marks);      // Result<vision::OffsetFit>
//   auto surface = settle_surface(recipe, state.known.heights);   // Result<vision::SurfaceFit>
#pragma once
#include <vector>

#include "app/job/job_state.hpp"
#include "core/error.hpp"
#include "recipes/job.hpp"
#include "vision/fit_offset.hpp"
#include "vision/fit_surface.hpp"

namespace gantry::job {

/// Where the board is likely to lie by the marks found so far: one gives the shift, two or more the rotation as well.
recipes::WorkOffset guess_offset(const recipes::Recipe& recipe, const std::vector<FoundMark>& marks);

/// The best fit, whether the recipe's rules allow it or not; of one mark or more.
vision::OffsetFit fit_marks(const recipes::Recipe& recipe, const std::vector<FoundMark>& marks);

/// By the recipe's mark rules. Faults of vision::fit_offset, with the line of the recipe's first mark.
Result<vision::OffsetFit> settle_offset(const recipes::Recipe& recipe, const std::vector<FoundMark>& marks);

/// By the recipe's touch rules. Faults of vision::fit_surface, with the line of the recipe's first touch.
Result<vision::SurfaceFit> settle_surface(const recipes::Recipe& recipe, const std::vector<TouchedHeight>& heights);

/// "board.yaml:12:3"
std::string at_line(const recipes::Recipe& recipe, recipes::Location location);

}  // namespace gantry::job
