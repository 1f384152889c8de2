#include "vision/gates.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

#include "vision/words.hpp"

namespace gantry::vision {
namespace {

/// One sector's own edge against the fit: how far it is shifted and how strong it is.
struct SectorSums {
  double shift = 0, shift_weight = 0;  // sum r dI/dn, sum (dI/dn)^2
  double step = 0, step_weight = 0;    // sum r (Phi - 1/2), sum (Phi - 1/2)^2
  double square = 0, count = 0;        // sum r^2
};

/// Pixels around and inside the shape, averaged in blocks so that noise does not decide.
struct Level {
  double sdf = 0;    ///< px from the edge
  double share = 0;  ///< (grey - expected) / contrast
};

void for_box(const Image& image, Vec2 centre, double reach, int stride, auto&& visit) {
  const auto low = [&](double c) { return std::max(0, static_cast<int>(std::floor(c - reach))); };
  const int x_end = std::min(image.width, static_cast<int>(std::ceil(centre.x + reach)) + 1);
  const int y_end = std::min(image.height, static_cast<int>(std::ceil(centre.y + reach)) + 1);
  for (int y = low(centre.y); y + stride <= y_end; y += stride)
    for (int x = low(centre.x); x + stride <= x_end; x += stride) visit(x, y);
}

SectorMask bad_sectors(const Image& image, const MarkModel& model, const ShapeFit& fit, const FindRules& rules) {
  const double band = band_px(model, {});
  std::array<SectorSums, kSectors> sums{};
  for_box(image, fit.at_px, reach_px(model.shape) * fit.scale + band, 1, [&](int x, int y) {
    const Vec2 at{1.0 * x, 1.0 * y};
    if (std::abs(fit.scale * distance(model.shape, (at - fit.at_px) * (1 / fit.scale)).value) > band) return;
    const Expected e = expected_at(model, fit, at);
    SectorSums& s = sums[sector_of(at - fit.at_px)];
    const double r = image.at(x, y) - e.grey, half = e.inside - 0.5;
    s.shift += r * e.per_shift, s.shift_weight += e.per_shift * e.per_shift;
    s.step += r * half, s.step_weight += half * half;
    s.square += r * r, s.count += 1;
  });
  SectorMask bad{};
  for (std::size_t i = 0; i < kSectors; ++i) {
    const SectorSums& s = sums[i];
    if (s.shift_weight <= 0 || s.step_weight <= 0) {
      bad[i] = true;
      continue;
    }
    const double shift_sigma = fit.noise / std::sqrt(s.shift_weight);
    const double step_sigma = fit.noise / (std::sqrt(s.step_weight) * std::abs(fit.contrast));
    // The residual's energy catches what the two linear measures miss: an edge far off, which hardly changes the first.
    const double noise = fit.noise * fit.noise, off = rules.max_sector_error * fit.contrast;
    bad[i] = std::abs(s.shift / s.shift_weight) > rules.max_edge_shift_px + 3 * shift_sigma ||
             std::abs(s.step / s.step_weight / fit.contrast) > rules.max_level_error + 3 * step_sigma ||
             s.square / s.count > 1.3 * noise + off * off;
  }
  return bad;
}

int longest_run(const SectorMask& bad) {
  int longest = 0, run = 0;
  for (std::size_t i = 0; i < 2 * kSectors; ++i) {  // twice round: a run may cross the seam
    run = bad[i % kSectors] ? run + 1 : 0;
    longest = std::max(longest, run);
  }
  return std::min(longest, static_cast<int>(kSectors));
}

std::vector<Level> levels(const Image& image, const MarkModel& model, const ShapeFit& fit, double out_to) {
  constexpr int kBlock = 4;
  std::vector<Level> out;
  for_box(image, fit.at_px, reach_px(model.shape) * fit.scale + out_to, kBlock, [&](int x, int y) {
    double grey = 0;
    for (int j = 0; j < kBlock; ++j)
      for (int i = 0; i < kBlock; ++i) grey += image.at(x + i, y + j);
    const Expected e = expected_at(model, fit, {x + (kBlock - 1) / 2.0, y + (kBlock - 1) / 2.0});
    out.push_back({e.sdf, (grey / (kBlock * kBlock) - e.grey) / fit.contrast});
  });
  return out;
}

/// Median deviation of the blocks whose distance from the edge lies in [from, to); 0 when there are too few to say.
double median_between(const std::vector<Level>& all, double from, double to) {
  std::vector<double> in;
  for (const Level& l : all)
    if (l.sdf >= from && l.sdf < to) in.push_back(l.share);
  if (in.size() < 6) return 0;
  const auto middle = in.begin() + static_cast<std::ptrdiff_t>(in.size() / 2);
  std::nth_element(in.begin(), middle, in.end());
  return *middle;
}

}  // namespace

std::string reject_fit(const MarkModel& model, const ShapeFit& fit, const FindRules& rules) {
  if ((fit.contrast > 0) != model.bright)
    return fmt::format("it is {} than what surrounds it", model.bright ? "darker" : "brighter");
  if (std::abs(fit.contrast) < rules.min_contrast)
    return fmt::format("its contrast of {:.0f} grey levels is below {:.0f}", std::abs(fit.contrast),
                       rules.min_contrast);
  if (std::abs(fit.scale - 1) > rules.max_scale_error)
    return fmt::format("its size is {:.1f} % of the mark's", 100 * fit.scale);
  if (fit.noise > rules.max_noise_share * std::abs(fit.contrast)) return "its surroundings do not look like a mark's";
  if (fit.blur_px > std::max(3.0, rules.max_blur_share * reach_px(model.shape)))
    return "its edge is blurred over " + length(fit.blur_px, rules.mm_per_px);
  return {};
}

Judgement judge(const Image& image, const MarkModel& model, const ShapeFit& fit, const FindRules& rules) {
  Judgement j;
  j.rejected = reject_fit(model, fit, rules);
  if (!j.rejected.empty()) return j;
  if (!fit.converged) {
    j.rejected = "the fit does not settle";
    return j;
  }

  // Inside: a ring, a via or a letter has the edge of a disc but not its face. Around: a disc within a disc.
  const double depth = depth_px(model.shape) * fit.scale, clear = 3 * fit.blur_px + 3;
  const std::vector<Level> all = levels(image, model, fit, 0.25 * depth + clear);
  const double allowed = rules.max_level_error + 3 * fit.noise / 4 / std::abs(fit.contrast);
  std::size_t inside = 0, same = 0;
  for (const Level& l : all)
    if (l.sdf < -clear) ++inside, same += std::abs(l.share) <= allowed;
  j.interior = inside == 0 ? 1.0 : static_cast<double>(same) / static_cast<double>(inside);
  constexpr int kRings = 6;
  for (int k = 0; k < kRings; ++k) {
    const double width = (depth - clear) / kRings, from = -depth + k * width;
    if (std::abs(median_between(all, from, from + width)) > rules.max_level_error)
      j.rejected = "its inside has another grey " + length(-from - width / 2, rules.mm_per_px) + " from its edge";
  }
  for (int k = 0; k < 2 && j.rejected.empty(); ++k) {
    const double width = 0.125 * depth, from = clear + k * width;
    if (std::abs(median_between(all, from, from + width)) > rules.max_level_error)
      j.rejected = "there is another edge around it, " + length(from, rules.mm_per_px) + " out";
  }
  if (j.rejected.empty() && j.interior < rules.min_interior)
    j.rejected = fmt::format("only {:.0f} % of its inside has one grey", 100 * j.interior);

  j.bad = bad_sectors(image, model, fit, rules);
  const auto bad = std::count(j.bad.begin(), j.bad.end(), true);
  j.coverage = 1 - static_cast<double>(bad) / static_cast<double>(kSectors);
  if (!j.rejected.empty()) return j;
  if (j.coverage < rules.min_coverage)
    j.rejected = fmt::format("its edge shows in {} of {} sectors", static_cast<int>(kSectors) - bad, kSectors);
  else if (longest_run(j.bad) > rules.max_gap_sectors)
    j.rejected = fmt::format("its edge is missing over {} of {} sectors in a row", longest_run(j.bad), kSectors);
  j.look_alike = !j.rejected.empty();
  return j;
}

}  // namespace gantry::vision
