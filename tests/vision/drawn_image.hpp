// Images with known truth for the tests of vision, drawn without anything that vision uses: hard-edged figures counted
// on 16 x 16 sub-pixels, then blurred by a discrete Gaussian, lit, disturbed and rounded to 8 bit.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <random>
#include <vector>

#include "core/vec.hpp"
#include "vision/camera.hpp"

namespace gantry::test {

class DrawnImage {
 public:
  DrawnImage(int width, int height, double grey)
      : width_(width),
        height_(height),
        pixels_(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), grey) {}

  /// Paints `grey` over the share of each pixel that lies inside; pixel (0, 0) covers -0.5 .. 0.5.
  void paint(Vec2 low, Vec2 high, double grey, const std::function<bool(Vec2)>& inside) {
    constexpr int kSub = 16;
    for (int y = std::max(0, static_cast<int>(low.y) - 1); y <= std::min(height_ - 1, static_cast<int>(high.y) + 2);
         ++y)
      for (int x = std::max(0, static_cast<int>(low.x) - 1); x <= std::min(width_ - 1, static_cast<int>(high.x) + 2);
           ++x) {
        int corners = 0;  // a figure here is never so thin that it passes between a pixel's corners
        for (const Vec2 c : {Vec2{-0.5, -0.5}, Vec2{0.5, -0.5}, Vec2{-0.5, 0.5}, Vec2{0.5, 0.5}})
          corners += inside(Vec2{1.0 * x, 1.0 * y} + c);
        if (corners == 0) continue;
        if (corners == 4) {
          at(x, y) = grey;
          continue;
        }
        int hits = 0;
        for (int j = 0; j < kSub; ++j)
          for (int i = 0; i < kSub; ++i) hits += inside({x - 0.5 + (i + 0.5) / kSub, y - 0.5 + (j + 0.5) / kSub});
        double& p = at(x, y);
        p += (grey - p) * hits / (kSub * kSub);
      }
  }
  void disc(Vec2 c, double radius, double grey) {
    paint(c - Vec2{radius, radius}, c + Vec2{radius, radius}, grey, [=](Vec2 p) { return norm(p - c) < radius; });
  }
  void ring(Vec2 c, double radius, double hole, double grey) {
    paint(c - Vec2{radius, radius}, c + Vec2{radius, radius}, grey,
          [=](Vec2 p) { return norm(p - c) < radius && norm(p - c) > hole; });
  }
  void box(Vec2 c, Vec2 size, double angle, double grey) {
    const double r = norm(size) / 2;
    paint(c - Vec2{r, r}, c + Vec2{r, r}, grey, [=](Vec2 p) {
      const Vec2 q = rotated(p - c, -angle);
      return std::abs(q.x) < size.x / 2 && std::abs(q.y) < size.y / 2;
    });
  }
  void blur(double sigma) {
    if (sigma <= 0) return;
    const int half = static_cast<int>(std::ceil(5 * sigma));
    std::vector<double> kernel;
    double sum = 0;
    for (int i = -half; i <= half; ++i)
      kernel.push_back(std::exp(-0.5 * i * i / (sigma * sigma))), sum += kernel.back();
    for (double& k : kernel) k /= sum;
    for (const bool rows : {true, false}) {
      const std::vector<double> in = pixels_;
      const auto from = [&](int x, int y) -> double {
        return in[static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x)];
      };
      std::fill(pixels_.begin(), pixels_.end(), 0.0);
      for (int y = 0; y < height_; ++y)
        for (int i = -half; i <= half; ++i) {
          const double k = kernel[static_cast<std::size_t>(i + half)];
          const int v = rows ? y : std::clamp(y + i, 0, height_ - 1), shift = rows ? i : 0;
          double* const out = &at(0, y);
          const int low = std::clamp(-shift, 0, width_), high = std::clamp(width_ - shift, 0, width_);
          for (int x = 0; x < low; ++x) out[x] += k * from(0, v);
          for (int x = low; x < high; ++x) out[x] += k * from(x + shift, v);
          for (int x = high; x < width_; ++x) out[x] += k * from(width_ - 1, v);
        }
    }
  }
  /// Brightness rising by `per_px` of its value from the image's centre on.
  void light(Vec2 per_px) {
    for (int y = 0; y < height_; ++y)
      for (int x = 0; x < width_; ++x) at(x, y) *= 1 + per_px.x * (x - width_ / 2.0) + per_px.y * (y - height_ / 2.0);
  }
  vision::Image image(double noise, std::mt19937_64& random) {
    vision::Image out{width_, height_, {}};
    std::normal_distribution<double> normal(0, 1);
    out.pixels.reserve(pixels_.size());
    for (const double p : pixels_)
      out.pixels.push_back(
          static_cast<std::uint8_t>(std::clamp(std::lround(p + (noise > 0 ? noise * normal(random) : 0.0)), 0L, 255L)));
    return out;
  }
  double& at(int x, int y) {
    return pixels_[static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x)];
  }

 private:
  int width_, height_;
  std::vector<double> pixels_;
};

}  // namespace gantry::test
