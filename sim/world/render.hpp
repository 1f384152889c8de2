// Pixels of what the camera would see: every edge pixel is sampled 8 x 8 times, each sample's ray is cast to the true
// plane of the board and asked there what it meets; then point spread, light, noise, 8 bit.
//   render(view, board, noise_seed) -> Image
// A pure function of its arguments. One scale at all heights (a telecentric lens); out of focus it blurs.
#pragma once
#include <cstdint>

#include "config/machine.hpp"
#include "core/vec.hpp"
#include "sim/world/board.hpp"
#include "vision/camera.hpp"

namespace gantry::sim {

/// Grey levels of the scene under full light, before blur and noise.
struct Greys {
  double dark = 6;  ///< without light
  double pallet = 45, board = 95, part = 60, mark_bright = 205, mark_dark = 25;
  double falloff = 0.10;  ///< relative loss of light from the image's centre to its corner
};

struct View {
  Vec3 focus;         ///< machine frame: the point in focus at the image's centre when exposure began
  Vec2 drift;         ///< how far it moved while exposed, mm
  bool light = true;  ///< at the exposure
  int width_px = 0, height_px = 0;
  double mm_per_px = 0.01;
  double noise = 2;                ///< sigma, grey levels
  double blur_px = 0.8;            ///< sigma of the lens in focus
  double defocus_px_per_mm = 0.6;  ///< added in quadrature
  Greys greys;
};

/// `board` may be null: an empty pallet.
vision::Image render(const View& view, const BoardTruth* board, std::uint64_t noise_seed);

}  // namespace gantry::sim
