#include "sim/world/render.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "sim/random.hpp"

namespace gantry::sim {

namespace {

constexpr int kSamples = 8;  ///< per pixel edge

/// Pixels and the board's plane: an affine map both ways (turn, scale, mirror in y).
class Projection {
 public:
  Projection(const View& view, const BoardTruth& board)
      : board_(board),
        focus_(view.focus),
        scale_(view.mm_per_px),
        centre_{(view.width_px - 1) / 2.0, (view.height_px - 1) / 2.0} {
    origin_ = cast({0, 0});
    per_column_ = cast({1, 0}) - origin_;
    per_row_ = cast({0, 1}) - origin_;
  }
  [[nodiscard]] Vec2 to_board(Vec2 pixel) const { return origin_ + per_column_ * pixel.x + per_row_ * pixel.y; }
  [[nodiscard]] Vec2 to_pixel(Vec2 board) const {
    const Vec3 m = board_.to_machine(board, 0);
    return {centre_.x + (m.x - focus_.x) / scale_, centre_.y - (m.y - focus_.y) / scale_};
  }
  /// Motion of the camera in the machine frame, as motion of what a ray meets in the board's frame.
  [[nodiscard]] Vec2 turned(Vec2 machine) const { return rotated(machine, -board_.rotation()); }
  [[nodiscard]] double scale() const { return scale_; }

 private:
  [[nodiscard]] Vec2 cast(Vec2 pixel) const {
    const Vec3 b = board_.to_board(
        {focus_.x + (pixel.x - centre_.x) * scale_, focus_.y - (pixel.y - centre_.y) * scale_, focus_.z});
    return {b.x, b.y};
  }
  const BoardTruth& board_;
  Vec3 focus_;
  double scale_;
  Vec2 centre_, origin_, per_column_, per_row_;
};

/// Columns [first, last] of a row; empty when last < first.
struct Span {
  int first = 0, last = -1;
};

Span clipped(double from, double to, int width) {
  if (!(from <= to)) return {};
  return {static_cast<int>(std::ceil(std::clamp(from, 0.0, static_cast<double>(width)))),
          static_cast<int>(std::floor(std::clamp(to, -1.0, width - 1.0)))};
}

struct Disc {
  Vec2 at;  ///< board frame, mm
  double radius = 0;
  Vec2 at_px;
  double radius_px = 0;

  Disc(Vec2 centre, double diameter, const Projection& p)
      : at(centre), radius(diameter / 2), at_px(p.to_pixel(centre)), radius_px(radius / p.scale()) {}
  [[nodiscard]] bool holds(Vec2 b) const { return dot(b - at, b - at) <= radius * radius; }
  /// Columns of a row that lie deeper than `depth` px inside.
  [[nodiscard]] Span inside(int row, double depth, int width) const {
    const double r = radius_px - depth, dy = row - at_px.y;
    if (r <= 0 || std::abs(dy) > r) return {};
    const double half = std::sqrt(r * r - dy * dy);
    return clipped(at_px.x - half, at_px.x + half, width);
  }
  [[nodiscard]] double top_px() const { return at_px.y - radius_px; }
  [[nodiscard]] double bottom_px() const { return at_px.y + radius_px; }
};

struct Rectangle {
  Vec2 centre, half;
  double turn = 0;
  std::array<Vec2, 4> corners_px;

  Rectangle(Vec2 at, Vec2 size, double rotation, const Projection& p) : centre(at), half(size * 0.5), turn(rotation) {
    const std::array<Vec2, 4> signs{Vec2{-1, -1}, Vec2{1, -1}, Vec2{1, 1}, Vec2{-1, 1}};
    for (std::size_t i = 0; i < 4; ++i)
      corners_px[i] = p.to_pixel(at + rotated({signs[i].x * half.x, signs[i].y * half.y}, rotation));
  }
  [[nodiscard]] bool holds(Vec2 b) const {
    const Vec2 own = rotated(b - centre, -turn);
    return std::abs(own.x) <= half.x && std::abs(own.y) <= half.y;
  }
  [[nodiscard]] Span inside(int row, double depth, int width) const {
    double from = 0, to = width - 1;
    for (std::size_t i = 0; i < 4; ++i) {
      const Vec2 a = corners_px[i], edge = corners_px[(i + 1) % 4] - a;
      // The image is mirrored: corners that run counter-clockwise on the board have their inside to the right.
      const Vec2 inward = Vec2{edge.y, -edge.x} * (1 / norm(edge));
      const double rest = inward.y * (row - a.y) - inward.x * a.x - depth;  // inward.x * column + rest >= 0
      if (std::abs(inward.x) < 1e-12) {
        if (rest < 0) return {};
      } else if (inward.x > 0) {
        from = std::max(from, -rest / inward.x);
      } else {
        to = std::min(to, -rest / inward.x);
      }
    }
    return clipped(from, to, width);
  }
  [[nodiscard]] double top_px() const {
    return std::min({corners_px[0].y, corners_px[1].y, corners_px[2].y, corners_px[3].y});
  }
  [[nodiscard]] double bottom_px() const {
    return std::max({corners_px[0].y, corners_px[1].y, corners_px[2].y, corners_px[3].y});
  }
};

class Canvas {
 public:
  Canvas(const View& view, double ground)
      : width_(view.width_px),
        height_(view.height_px),
        values_(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_), static_cast<float>(ground)) {}

  float* row(int y) { return values_.data() + static_cast<std::size_t>(y) * static_cast<std::size_t>(width_); }
  [[nodiscard]] int width() const { return width_; }
  [[nodiscard]] int height() const { return height_; }

  template <class Shape>
  void paint(const Shape& shape, double grey, const Projection& projection, Vec2 drift_mm) {
    // Half a pixel's diagonal, and what the shape moves in the image during the exposure.
    const double edge = 0.75 + norm(drift_mm) / projection.scale();
    const int top = static_cast<int>(std::clamp(std::floor(shape.top_px() - edge), 0.0, height_ - 1.0));
    const int bottom = static_cast<int>(std::clamp(std::ceil(shape.bottom_px() + edge), -1.0, height_ - 1.0));
    const Vec2 drift = projection.turned(drift_mm);
    const auto value = static_cast<float>(grey);
    for (int y = top; y <= bottom; ++y) {
      const Span outer = shape.inside(y, -edge, width_), inner = shape.inside(y, edge, width_);
      float* const line = row(y);
      for (int x = outer.first; x <= outer.last; ++x) {
        if (x == inner.first && inner.last >= inner.first) {
          std::fill(line + inner.first, line + inner.last + 1, value);
          x = inner.last;
          continue;
        }
        const auto covered = static_cast<float>(coverage(shape, projection, x, y, drift));
        line[x] += (value - line[x]) * covered;
      }
    }
  }

 private:
  template <class Shape>
  static double coverage(const Shape& shape, const Projection& projection, int x, int y, Vec2 drift) {
    int hits = 0;
    for (int j = 0; j < kSamples; ++j)
      for (int i = 0; i < kSamples; ++i) {
        const Vec2 sample{x + (i + 0.5) / kSamples - 0.5, y + (j + 0.5) / kSamples - 0.5};
        // Each sample looks at its own instant of the exposure; 37 is odd, so that all 64 instants occur once.
        const double instant = (((j * kSamples + i) * 37) % (kSamples * kSamples) + 0.5) / (kSamples * kSamples);
        hits += shape.holds(projection.to_board(sample) + drift * instant) ? 1 : 0;
      }
    return static_cast<double>(hits) / (kSamples * kSamples);
  }

  int width_, height_;
  std::vector<float> values_;
};

/// Gaussian point spread, rows first, then columns; the border repeats.
void blur(Canvas& canvas, double sigma_px) {
  const int w = canvas.width(), h = canvas.height();
  const int reach = static_cast<int>(std::ceil(3.5 * sigma_px));
  std::vector<float> kernel(static_cast<std::size_t>(2 * reach + 1));
  double sum = 0;
  for (int i = -reach; i <= reach; ++i) sum += std::exp(-0.5 * i * i / (sigma_px * sigma_px));
  for (int i = -reach; i <= reach; ++i)
    kernel[static_cast<std::size_t>(i + reach)] =
        static_cast<float>(std::exp(-0.5 * i * i / (sigma_px * sigma_px)) / sum);

  // Rows pass through a ring of the last 2 reach + 1 blurred rows, which the column pass sums up.
  const auto columns = static_cast<std::size_t>(w);
  std::vector<float> padded(columns + 2 * static_cast<std::size_t>(reach));
  std::vector<std::vector<float>> ring(kernel.size(), std::vector<float>(columns));
  const auto slot = [&](int y) -> std::vector<float>& { return ring[static_cast<std::size_t>(y) % ring.size()]; };
  const auto blur_row = [&](int y) {
    const float* const in = canvas.row(y);
    std::fill_n(padded.begin(), reach, in[0]);
    std::copy_n(in, w, padded.begin() + reach);
    std::fill_n(padded.end() - reach, reach, in[w - 1]);
    std::vector<float>& out = slot(y);
    std::fill(out.begin(), out.end(), 0.0f);
    for (std::size_t k = 0; k < kernel.size(); ++k) {
      const float weight = kernel[k];
      const float* const from = padded.data() + k;
      for (std::size_t x = 0; x < columns; ++x) out[x] += weight * from[x];
    }
  };
  for (int y = 0; y < std::min(reach, h); ++y) blur_row(y);
  for (int y = 0; y < h; ++y) {
    if (y + reach < h) blur_row(y + reach);
    float* const out = canvas.row(y);
    std::fill_n(out, w, 0.0f);
    for (std::size_t k = 0; k < kernel.size(); ++k) {
      const float weight = kernel[k];
      const float* const from = slot(std::clamp(y + static_cast<int>(k) - reach, 0, h - 1)).data();
      for (std::size_t x = 0; x < columns; ++x) out[x] += weight * from[x];
    }
  }
}

constexpr std::size_t kNormals = 4096;

/// Normal deviates at the middle of 4096 equal slices of probability (inverted by bisection of erfc).
const std::array<float, kNormals>& normals() {
  static const std::array<float, kNormals> table = [] {
    std::array<float, kNormals> out{};
    for (std::size_t i = 0; i < kNormals; ++i) {
      const double p = (static_cast<double>(i) + 0.5) / kNormals;
      double low = -5, high = 5;
      for (int n = 0; n < 60; ++n) {
        const double middle = (low + high) / 2;
        (0.5 * std::erfc(-middle / std::sqrt(2.0)) < p ? low : high) = middle;
      }
      out[i] = static_cast<float>((low + high) / 2);
    }
    return out;
  }();
  return table;
}

/// Light that falls off towards the corners, sensor noise, 8 bit.
vision::Image exposed(Canvas& canvas, const View& view, std::uint64_t seed) {
  const int w = canvas.width(), h = canvas.height();
  vision::Image image{w, h, std::vector<std::uint8_t>(static_cast<std::size_t>(w) * static_cast<std::size_t>(h))};
  const double cx = (w - 1) / 2.0, cy = (h - 1) / 2.0, corner2 = std::max(cx * cx + cy * cy, 1.0);
  std::vector<float> column(static_cast<std::size_t>(w));
  for (int x = 0; x < w; ++x)
    column[static_cast<std::size_t>(x)] = static_cast<float>(view.greys.falloff * (x - cx) * (x - cx) / corner2);
  constexpr unsigned kPerWord = 5;  // 12 bits each
  const auto sigma = static_cast<float>(view.noise);
  const auto words = static_cast<std::uint64_t>(w) / kPerWord + 1;
  for (int y = 0; y < h; ++y) {
    const float* const in = canvas.row(y);
    std::uint8_t* const out = image.pixels.data() + static_cast<std::size_t>(y) * static_cast<std::size_t>(w);
    const auto left = static_cast<float>(1 - view.greys.falloff * (y - cy) * (y - cy) / corner2);
    std::uint64_t word = 0;
    for (int x = 0; x < w; ++x) {
      const unsigned part = static_cast<unsigned>(x) % kPerWord;
      if (part == 0)
        word = mix(seed + static_cast<std::uint64_t>(y) * words + static_cast<std::uint64_t>(x) / kPerWord);
      const float noise = normals()[(word >> (12 * part)) & (kNormals - 1)] * sigma;
      const float lit = view.light ? in[x] * (left - column[static_cast<std::size_t>(x)]) : in[x];
      out[x] = static_cast<std::uint8_t>(std::clamp(lit + noise + 0.5f, 0.0f, 255.0f));
    }
  }
  return image;
}

}  // namespace

vision::Image render(const View& view, const BoardTruth* board, std::uint64_t noise_seed) {
  const Greys& g = view.greys;
  Canvas canvas(view, view.light ? g.pallet : g.dark);
  if (view.light && board != nullptr) {
    const Projection projection(view, *board);
    const Vec2 size = board->plan.board.size;
    canvas.paint(Rectangle(size * 0.5, size, 0, projection), g.board, projection, view.drift);
    for (const recipes::MarkDef& mark : board->plan.marks)
      canvas.paint(Disc(mark.at, mark.diameter, projection), mark.bright ? g.mark_bright : g.mark_dark, projection,
                   view.drift);
    for (const Stain& stain : board->stains)
      canvas.paint(Disc(stain.at, stain.diameter, projection), stain.grey, projection, view.drift);
    for (const recipes::Part& part : board->plan.parts) {
      Vec2 at = part.at;
      double turn = part.rotation;
      if (part.fixture) {  // stands on the pallet: seen from the board it moves the other way
        const Vec3 seen = board->to_board(board->nominal_to_machine(part.at, 0));
        at = {seen.x, seen.y};
        turn -= board->rotation();
      }
      canvas.paint(Rectangle(at, {part.size.x, part.size.y}, turn, projection), g.part, projection, view.drift);
    }
    const Vec3 middle = board->to_board(view.focus);
    constexpr double kMostBlur_px = 8;
    blur(canvas, std::min(std::hypot(view.blur_px, view.defocus_px_per_mm * middle.z), kMostBlur_px));
  }
  return exposed(canvas, view, noise_seed);
}

}  // namespace gantry::sim
