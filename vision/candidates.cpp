#include "vision/candidates.hpp"

#include <algorithm>
#include <cmath>

namespace gantry::vision {
namespace {

constexpr double kReducedRadius = 8;  // px that a mark's radius has on the reduced image
constexpr float kFlat = 2.0F;         // grey levels: a window with less spread than this does not correlate
constexpr double kScoreMin = 0.3;
constexpr int kMargin = 2;  // reduced px around the mark that belong to the template

/// A part of the image, averaged over factor x factor pixels. Reduced pixel (i, j) has its centre at
/// origin + (i, j) * factor in image pixels. Beyond the image its border is repeated.
struct Reduced {
  int width = 0, height = 0, factor = 1;
  Vec2 origin;
  std::vector<float> pixels;
  [[nodiscard]] const float* row(int j) const {
    return &pixels[static_cast<std::size_t>(j) * static_cast<std::size_t>(width)];
  }
};

Reduced reduce(const Image& image, int factor, int left, int top, int width, int height) {
  Reduced out{width, height, factor, {left + (factor - 1) / 2.0, top + (factor - 1) / 2.0}, {}};
  out.pixels.assign(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), 0.0F);
  const float share = 1.0F / static_cast<float>(factor * factor);
  for (int j = 0; j < height * factor; ++j) {
    const int y = std::clamp(top + j, 0, image.height - 1);
    float* const row = &out.pixels[static_cast<std::size_t>(j / factor) * static_cast<std::size_t>(width)];
    for (int i = 0; i < width; ++i) {
      int sum = 0;
      for (int k = 0; k < factor; ++k) sum += image.at(std::clamp(left + i * factor + k, 0, image.width - 1), y);
      row[i] += share * static_cast<float>(sum);
    }
  }
  return out;
}

struct Tap {
  int dx = 0, dy = 0;
  float weight = 0;
};

/// The mark as it looks on the reduced image, free of mean and of length 1.
std::vector<Tap> make_template(const MarkModel& model, int factor) {
  const int half = static_cast<int>(std::ceil(reach_px(model.shape) / factor)) + kMargin;
  std::vector<Tap> taps;
  double sum = 0;
  for (int dy = -half; dy <= half; ++dy)
    for (int dx = -half; dx <= half; ++dx) {
      const double sdf = distance(model.shape, Vec2{1.0 * dx, 1.0 * dy} * factor).value / factor;
      if (sdf > kMargin) continue;
      const double inside = 0.5 * std::erfc(sdf / (0.5 * std::sqrt(2.0)));
      taps.push_back({dx, dy, static_cast<float>(model.bright ? inside : -inside)});
      sum += taps.back().weight;
    }
  const auto mean = static_cast<float>(sum / static_cast<double>(taps.size()));
  float square = 0;
  for (Tap& tap : taps) tap.weight -= mean, square += tap.weight * tap.weight;
  for (Tap& tap : taps) tap.weight /= std::sqrt(square);
  return taps;
}

/// Correlation at every position where the template fits; a row at a time, taps outside, so that the inner loop is over
/// neighbours in memory.
Reduced correlate(const Reduced& image, const std::vector<Tap>& taps, int half) {
  Reduced out{image.width - 2 * half, image.height - 2 * half, image.factor, {}, {}};
  out.origin = image.origin + Vec2{1.0 * half, 1.0 * half} * image.factor;
  const auto width = static_cast<std::size_t>(out.width);
  out.pixels.resize(width * static_cast<std::size_t>(out.height));
  const auto n = static_cast<float>(taps.size());
  std::vector<float> product(width), sum(width), square(width);
  for (int j = 0; j < out.height; ++j) {
    std::fill(product.begin(), product.end(), 0.0F);
    std::fill(sum.begin(), sum.end(), 0.0F);
    std::fill(square.begin(), square.end(), 0.0F);
    for (const Tap& tap : taps) {
      const float* const in = image.row(j + half + tap.dy) + half + tap.dx;
      const float weight = tap.weight;
      for (std::size_t i = 0; i < width; ++i) {
        product[i] += weight * in[i];
        sum[i] += in[i];
        square[i] += in[i] * in[i];
      }
    }
    for (std::size_t i = 0; i < width; ++i) {
      const float spread = std::max(square[i] - sum[i] * sum[i] / n, n * kFlat * kFlat);
      out.pixels[static_cast<std::size_t>(j) * width + i] = product[i] / std::sqrt(spread);
    }
  }
  return out;
}

/// Offset of a parabola's peak through three neighbours, in -0.5 .. 0.5.
double peak(float before, float at, float after) {
  const float bend = before - 2 * at + after;
  return bend < 0 ? std::clamp(0.5 * static_cast<double>(before - after) / static_cast<double>(bend), -0.5, 0.5) : 0.0;
}

}  // namespace

std::vector<Candidate> find_candidates(const Image& image, const MarkModel& model, Vec2 expected_px, double radius_px,
                                       std::size_t count) {
  const double reach = reach_px(model.shape);
  const int factor = std::clamp(static_cast<int>(std::lround(reach / kReducedRadius)), 1, 32);
  const int half = static_cast<int>(std::ceil(reach / factor)) + kMargin;

  // The searched square, cut to places inside the image, plus a border for template and peak.
  const auto span = [&](double centre, int size) {
    const double from = std::clamp(centre - radius_px, 0.0, size - 1.0),
                 to = std::clamp(centre + radius_px, 0.0, size - 1.0);
    const int border = half + 1;
    const int start = static_cast<int>(std::floor(from)) - border * factor;
    return std::pair{start, static_cast<int>(std::ceil((to - from) / factor)) + 1 + 2 * border};
  };
  const auto [left, width] = span(expected_px.x, image.width);
  const auto [top, height] = span(expected_px.y, image.height);
  const Reduced scores = correlate(reduce(image, factor, left, top, width, height), make_template(model, factor), half);

  std::vector<Candidate> maxima;
  for (int j = 1; j + 1 < scores.height; ++j) {
    const float *above = scores.row(j - 1), *row = scores.row(j), *below = scores.row(j + 1);
    for (int i = 1; i + 1 < scores.width; ++i) {
      const float s = row[i];
      if (s < kScoreMin || s <= row[i - 1] || s < row[i + 1] || s <= above[i - 1] || s <= above[i] ||
          s <= above[i + 1] || s < below[i - 1] || s < below[i] || s < below[i + 1])
        continue;
      const Vec2 at =
          scores.origin + Vec2{i + peak(row[i - 1], s, row[i + 1]), j + peak(above[i], s, below[i])} * factor;
      if (norm(at - expected_px) <= radius_px + factor) maxima.push_back({at, s});
    }
  }
  std::stable_sort(maxima.begin(), maxima.end(), [](const auto& a, const auto& b) { return a.score > b.score; });

  std::vector<Candidate> best;
  for (const Candidate& m : maxima) {
    if (best.size() == count) break;
    if (std::none_of(best.begin(), best.end(), [&](const auto& b) { return norm(b.at_px - m.at_px) < 0.5 * reach; }))
      best.push_back(m);
  }
  return best;
}

}  // namespace gantry::vision
