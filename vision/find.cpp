#include "vision/find.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <optional>

#include "vision/candidates.hpp"
#include "vision/words.hpp"

namespace gantry::vision {
namespace {

struct Tried {
  ShapeFit fit;
  Judgement judgement;
  double correlation = 0;
};

bool alike(const std::vector<Tried>& tried, Vec2 at, double within) {
  return std::any_of(tried.begin(), tried.end(), [&](const Tried& t) { return norm(t.fit.at_px - at) < within; });
}

/// Coarse fit first, which turns most candidates away; then all pixels; then once more without the sectors that a stain
/// or glare spoils.
std::optional<Tried> try_candidate(const Image& image, const MarkModel& model, const Candidate& candidate,
                                   const FindRules& rules, const std::vector<Tried>& before) {
  const double reach = reach_px(model.shape);
  ShapeFit start;
  start.at_px = candidate.at_px;
  start.blur_px = std::clamp(0.05 * reach, 1.0, 4.0);
  const int stride = std::clamp(static_cast<int>(reach / 16), 1, 4);
  const double wide = std::clamp(0.35 * depth_px(model.shape), 4.0, 20.0);
  const ShapeFit coarse = fit_shape(image, model, start, {stride, 14, 0.5, wide, {}});
  if (alike(before, coarse.at_px, 0.25 * reach)) return std::nullopt;

  FindRules loose = rules;
  loose.max_scale_error *= 1.5, loose.min_contrast *= 0.7, loose.max_blur_share *= 2;
  Tried t{coarse, {}, candidate.score};
  t.judgement.rejected = reject_fit(model, coarse, loose);
  if (!t.judgement.rejected.empty()) return t;

  t.fit = fit_shape(image, model, coarse, {1, 12, 0.05, 0, {}});
  t.judgement = judge(image, model, t.fit, rules);
  const SectorMask bad = t.judgement.bad;
  if (t.judgement.rejected.empty() && std::count(bad.begin(), bad.end(), true) > 0) {
    t.fit = fit_shape(image, model, t.fit, {1, 12, 0, 0, bad});
    t.judgement = judge(image, model, t.fit, rules);
  }
  return t;
}

}  // namespace

Result<FoundMark> find_mark(const Image& image, const MarkModel& model, Vec2 expected_px, double search_radius_px,
                            const FindRules& rules) {
  const double reach = reach_px(model.shape), mm = rules.mm_per_px;
  const auto position = [&](Vec2 at_px) { return vision::position(at_px, expected_px, mm); };
  const auto pixels =
      static_cast<std::size_t>(std::max(image.width, 0)) * static_cast<std::size_t>(std::max(image.height, 0));
  if (pixels == 0 || image.pixels.size() != pixels)
    return fail(Fault::MarkNotFound, "the camera's frame is empty or has another size than it says");
  if (!(reach >= 2) || reach > std::min(image.width, image.height) / 2.0)
    return fail(Fault::MarkNotFound,
                fmt::format("a mark of {} across cannot be found in an image of {} x {}", length(2 * reach, mm),
                            length(image.width, mm), length(image.height, mm)));

  std::vector<Tried> tried;
  for (const Candidate& c : find_candidates(image, model, expected_px, search_radius_px, rules.candidates))
    if (auto t = try_candidate(image, model, c, rules, tried))
      if (norm(t->fit.at_px - expected_px) <= search_radius_px) tried.push_back(*std::move(t));

  const Tried *best = nullptr, *second = nullptr;  // by coverage, among what passed or may be a damaged mark
  for (const Tried& t : tried) {
    const bool passed = t.judgement.rejected.empty();
    if (!passed && !t.judgement.look_alike) continue;
    const auto better = [&](const Tried* than) {
      if (than == nullptr) return true;
      const bool than_passed = than->judgement.rejected.empty();
      return passed != than_passed ? passed : t.judgement.coverage > than->judgement.coverage;
    };
    if (better(best))
      second = best, best = &t;
    else if (better(second))
      second = &t;
  }

  if (best == nullptr || !best->judgement.rejected.empty()) {
    if (best == nullptr && !tried.empty()) best = &tried.front();
    const std::string why = best == nullptr ? std::string("nothing there resembles it")
                                            : fmt::format("what looks most like it, at {}, is none: {}",
                                                          position(best->fit.at_px), best->judgement.rejected);
    return fail(Fault::MarkNotFound,
                fmt::format("no mark within {} of where it should be: {}", length(search_radius_px, mm), why));
  }
  if (second != nullptr &&
      (second->judgement.rejected.empty() || best->judgement.coverage - second->judgement.coverage < rules.min_margin))
    return fail(Fault::MarkAmbiguous,
                fmt::format("two things look like the mark: at {} ({:.0f} % of the edge seen) and at {} ({:.0f} %)",
                            position(best->fit.at_px), 100 * best->judgement.coverage, position(second->fit.at_px),
                            100 * second->judgement.coverage));

  const ShapeFit& f = best->fit;
  return FoundMark{f.at_px, f.sigma_px, f.scale, f.blur_px, f.contrast, f.noise, best->judgement.coverage};
}

}  // namespace gantry::vision
