// Pixels and millimetres: the convention of the image stands here alone; the simulated camera and all others follow it.
//   Vec2 off = CameraModel(machine.camera).to_mm(found.at_px);   // mm from the camera tool's tip, machine X and Y
// - Pixel (0, 0) has its centre at (0, 0); the image's centre, ((width-1)/2, (height-1)/2), shows the camera tool's
// tip.
// - The column grows with machine +X, the row grows with machine -Y (the image is seen as from above, Y upwards).
// - One scale, mm_per_px, at the focus plane: the height of the tip. Lens distortion and tilt come with calibration.
// A point P of the machine, seen with the head at H (X, Y), is at H + tip + to_mm(pixel).
#pragma once
#include "config/machine.hpp"
#include "core/vec.hpp"

namespace gantry::vision {

class CameraModel {
 public:
  explicit constexpr CameraModel(const config::CameraConfig& c)
      : centre_px_{(c.width_px - 1) / 2.0, (c.height_px - 1) / 2.0}, mm_per_px_(c.mm_per_px) {}

  [[nodiscard]] constexpr Vec2 centre_px() const { return centre_px_; }
  [[nodiscard]] constexpr double mm_per_px() const { return mm_per_px_; }

  /// Offset from the camera tool's tip along machine X and Y.
  [[nodiscard]] constexpr Vec2 to_mm(Vec2 pixel) const {
    return {(pixel.x - centre_px_.x) * mm_per_px_, -(pixel.y - centre_px_.y) * mm_per_px_};
  }
  [[nodiscard]] constexpr Vec2 to_px(Vec2 offset_mm) const {
    return {centre_px_.x + offset_mm.x / mm_per_px_, centre_px_.y - offset_mm.y / mm_per_px_};
  }
  [[nodiscard]] constexpr double length_px(double length_mm) const { return length_mm / mm_per_px_; }

 private:
  Vec2 centre_px_;
  double mm_per_px_ = 1;
};

}  // namespace gantry::vision
