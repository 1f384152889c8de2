// Images for people: PNG files for reports and for the job's folder.
//   write(annotated_png(frame.image, model, expected_px, &found))
#pragma once
#include <cstddef>
#include <vector>

#include "core/error.hpp"
#include "vision/find.hpp"

namespace gantry::vision {

/// The same in colour, with a cross where the mark was expected and, when it was found, its outline and centre.
/// `shrink`: each side is divided by it.
Result<std::vector<std::byte>> annotated_png(const Image& image, const MarkModel& model, Vec2 expected_px,
                                             const FoundMark* found, int shrink = 1);

}  // namespace gantry::vision
