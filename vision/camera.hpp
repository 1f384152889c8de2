// What vision sees: frames. Exposure is triggered by an output of the bus, so a frame shows where the axes were at that
// cycle tick.
#pragma once
#include <cstdint>
#include <vector>

#include "core/clock.hpp"
#include "core/error.hpp"

namespace gantry::vision {

/// 8-bit grey image, row by row from the top left. Pixel (0, 0) has its centre at (0, 0).
struct Image {
  int width = 0, height = 0;
  std::vector<std::uint8_t> pixels;
  [[nodiscard]] std::uint8_t at(int x, int y) const {
    return pixels[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)];
  }
};

struct Frame {
  std::uint64_t counter = 0;  ///< counts exposures; the same number twice is a frozen camera
  Image image;
};

class Camera {
 public:
  virtual ~Camera() = default;
  /// Counter of the newest exposure; 0 before the first.
  virtual std::uint64_t latest() = 0;
  /// The first frame after exposure number `after`. Fault::CameraTimeout when none came within `timeout` (a virtual
  /// camera answers at once), Fault::WorldUnreachable.
  virtual Result<Frame> fetch(std::uint64_t after, Time timeout) = 0;
};

}  // namespace gantry::vision
