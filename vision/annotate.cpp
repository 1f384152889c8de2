#include "vision/annotate.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <png.h>

namespace gantry::vision {
namespace {

const cv::Scalar kExpected(60, 160, 255), kFound(80, 220, 80);  // blue, green, red

/// PNG through libpng's simplified API (libpng manual, section V), which neither throws nor jumps. Not cv::imencode:
/// see docs/decisions/005-images-without-imgcodecs.md.
Result<std::vector<std::byte>> to_png(const cv::Mat& canvas) {
  png_image png{};
  png.version = PNG_IMAGE_VERSION;
  png.width = static_cast<png_uint_32>(canvas.cols);
  png.height = static_cast<png_uint_32>(canvas.rows);
  png.flags = PNG_IMAGE_FLAG_FAST;  // the noise of a camera packs no better for four times the work
  png.format = canvas.channels() == 1 ? PNG_FORMAT_GRAY : PNG_FORMAT_BGR;
  const auto row_bytes = static_cast<png_int_32>(canvas.step[0]);
  png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(png);
  std::vector<std::byte> out(size);
  if (png_image_write_to_memory(&png, out.data(), &size, 0, canvas.data, row_bytes, nullptr) == 0)
    return fail(Fault::Internal, std::string("an image could not be written as PNG: ") + png.message);
  out.resize(size);
  return out;
}

/// Runs what may throw cv::Exception.
Result<std::vector<std::byte>> guarded(const Image& image, auto&& draw) {
  const auto pixels =
      static_cast<std::size_t>(std::max(image.width, 0)) * static_cast<std::size_t>(std::max(image.height, 0));
  if (pixels == 0 || image.pixels.size() != pixels)
    return fail(Fault::Internal, "an image for the report is empty or has another size than it says");
  try {
    // OpenCV has no view of constant pixels; nothing below writes to it.
    const cv::Mat grey(image.height, image.width, CV_8UC1, const_cast<std::uint8_t*>(image.pixels.data()));
    return to_png(draw(grey));
  } catch (const cv::Exception& e) {
    return fail(Fault::Internal, std::string("an image could not be written as PNG: ") + e.what());
  }
}

/// Fixed-point coordinates of OpenCV's drawing functions: 4 binary places.
constexpr int kShift = 4;
cv::Point fixed(Vec2 p) {
  return {static_cast<int>(std::lround(p.x * (1 << kShift))), static_cast<int>(std::lround(p.y * (1 << kShift)))};
}
void cross(cv::Mat& canvas, Vec2 at, double arm, const cv::Scalar& colour) {
  cv::line(canvas, fixed(at - Vec2{arm, 0}), fixed(at + Vec2{arm, 0}), colour, 1, cv::LINE_AA, kShift);
  cv::line(canvas, fixed(at - Vec2{0, arm}), fixed(at + Vec2{0, arm}), colour, 1, cv::LINE_AA, kShift);
}

/// The zero line of the shape's distance function, point by point from the centre outwards.
std::vector<cv::Point> outline(const MarkModel& model, const FoundMark& found, auto&& to_canvas) {
  constexpr int kPoints = 180;
  std::vector<cv::Point> points;
  for (int i = 0; i < kPoints; ++i) {
    const Vec2 ray = rotated({1, 0}, 2 * std::numbers::pi * i / kPoints);
    double in = 0, out = 1.01 * reach_px(model.shape);
    for (int k = 0; k < 30; ++k) {
      const double middle = (in + out) / 2;
      (distance(model.shape, ray * middle).value < 0 ? in : out) = middle;
    }
    points.push_back(fixed(to_canvas(found.at_px + ray * (in * found.scale))));
  }
  return points;
}

}  // namespace

Result<std::vector<std::byte>> annotated_png(const Image& image, const MarkModel& model, Vec2 expected_px,
                                             const FoundMark* found, int shrink) {
  return guarded(image, [&](const cv::Mat& grey) {
    const double k = 1.0 / std::max(1, shrink);
    // cv::resize keeps the corners of pixels, so a centre p goes to (p + 0.5) k - 0.5.
    const auto to_canvas = [k](Vec2 p) { return Vec2{(p.x + 0.5) * k - 0.5, (p.y + 0.5) * k - 0.5}; };
    cv::Mat small, canvas;
    cv::resize(grey, small, {}, k, k, cv::INTER_AREA);
    cv::cvtColor(small, canvas, cv::COLOR_GRAY2BGR);
    const double arm = std::max(4.0, 0.3 * reach_px(model.shape) * k);
    cross(canvas, to_canvas(expected_px), arm, kExpected);
    if (found != nullptr) {
      cv::polylines(canvas, outline(model, *found, to_canvas), true, kFound, 1, cv::LINE_AA, kShift);
      cross(canvas, to_canvas(found->at_px), arm, kFound);
    }
    return canvas;
  });
}

}  // namespace gantry::vision
