// Images for people: PNG files for reports and for the job's folder.
//   write(encode_png(frame.image)), write(annotated_png(frame.image, model, found))
#pragma once
#include <cstddef>
#include <vector>

#include "core/error.hpp"
#include "vision/find.hpp"

namespace gantry::vision {

/// 8-bit grey PNG. Fault::Internal when the image is empty or the codec refuses it.
Result<std::vector<std::byte>> encode_png(const Image& image);

/// The same in colour, with a cross where the mark was expected and, when it was found, its outline and centre.
/// `shrink`: each side is divided by it.
Result<std::vector<std::byte>> annotated_png(const Image& image, const MarkModel& model, Vec2 expected_px,
                                             const FoundMark* found, int shrink = 1);

}  // namespace gantry::vision
