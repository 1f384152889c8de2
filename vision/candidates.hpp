// Where a mark might be: the best places of a normalised correlation on a reduced image. Several, never only the best:
// under stains and glare the mark itself is often second.
//   for (const Candidate& c : find_candidates(image, model, expected, 200, 12)) ...
#pragma once
#include <vector>

#include "vision/camera.hpp"
#include "vision/shapes.hpp"

namespace gantry::vision {

struct Candidate {
  Vec2 at_px;        ///< within about a tenth of the mark's radius
  double score = 0;  ///< correlation, 1 is perfect
};

/// At most `count` places within `radius_px` of `expected_px`, best first, at least half the mark's radius apart.
std::vector<Candidate> find_candidates(const Image& image, const MarkModel& model, Vec2 expected_px, double radius_px,
                                       std::size_t count);

}  // namespace gantry::vision
