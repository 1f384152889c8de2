#include "motion/plan/find_path.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>

#include "motion/plan/lift_over.hpp"

namespace gantry::motion {
namespace {

/// A job waits for it, and one that is refused is refused at once: about a tenth of a second.
constexpr SearchBudget kBudget{.cuts = 10000};
constexpr double kLimitRounding = 1e-9;  // places of a job are turned and shifted with its board

/// Where one of the ends is itself too near to a body, no path helps: said first, since no lift-over changes it.
std::optional<Error> end_taken(const Scene& scene, const AxisVec& from, const AxisVec& to, const Margins& margins) {
  for (const bool start : {true, false}) {
    const AxisVec& at = start ? from : to;
    if (const auto hit = first_hit(scene, at, at, margins))
      return collision(scene, *hit, at, at,
                       fmt::format("where the motion {}, {}; no path leads there", start ? "starts" : "ends",
                                   describe(scene, *hit)));
  }
  return std::nullopt;
}

std::string_view why_not(const SearchAnswer& found) {
  if (found.status != SearchStatus::NoPath) return "none found";
  switch (found.closed_in) {
    case ClosedIn::Start: return "there is no path: where it starts is a pocket, closed in all around";
    case ClosedIn::Goal: return "there is no path: where it ends is a pocket, closed in all around";
    case ClosedIn::Neither: break;
  }
  return "there is no path: what stands between goes from side to side";
}

std::string no_lower(const Scene& scene, const Margins& margins) {
  if (!margins.lowest_mm) return "";
  return fmt::format(", with {} no lower than {:.2f} mm, where it is above wet deposits", scene.axes()[scene.z()].name,
                     *margins.lowest_mm);
}

AxisVec within_limits(const Scene& scene, AxisVec q) {
  for (std::size_t i = 0; i < scene.axes().size(); ++i)
    q[i] = std::clamp(q[i], scene.axes()[i].p_min, scene.axes()[i].p_max);
  return q;
}

/// Homing may leave axes beyond their limits: from there straight to where these begin, and on.
SearchAnswer around(const Scene& scene, const AxisVec& from, const AxisVec& to, const Margins& margins) {
  if (!beyond_limits(scene, from, kLimitRounding)) return search_around(scene, from, to, margins, kBudget, nullptr);
  const AxisVec inside = within_limits(scene, from);
  if (!is_clear(scene, from, inside, margins)) return {};
  SearchAnswer found = search_path(scene, inside, within_limits(scene, to), margins, kBudget);
  if (found.status != SearchStatus::Ok) return found;
  found.points.insert(found.points.begin(), from);
  if (found.points.back() != to) found.points.push_back(to);
  return found;
}

/// A way that was found before leads along bodies at the very clearance: where it, or what it leads along, lies
/// elsewhere by tenths of a millimetre, its corners give way by so much. False: they cannot.
class WayAgain {
 public:
  static constexpr std::array kSteps_mm{0.0, 0.05, 0.15, 0.4, 1.0, 2.0};

  /// A corner gives way by `most_mm` at most.
  WayAgain(const Scene& scene, const Margins& margins, std::vector<AxisVec>& way, double most_mm)
      : scene_(scene), margins_(margins), way_(way), most_mm_(most_mm), z_(scene.z()) {}

  bool make_free() {
    for (std::size_t i = 0; i < way_.size(); ++i)
      if (!is_allowed(i, way_[i])) return false;
    for (int pass = 0; pass < kPasses; ++pass) {
      bool all = true;
      for (std::size_t i = 1; i < way_.size(); ++i) all = (is_free(way_[i - 1], way_[i]) || give_way(i)) && all;
      if (all) return true;
    }
    return false;
  }

 private:
  static constexpr int kPasses = 3;

  [[nodiscard]] bool is_free(const AxisVec& from, const AxisVec& to) const {
    return is_clear(scene_, from, to, margins_);
  }
  [[nodiscard]] bool is_allowed(std::size_t i, const AxisVec& q) const {
    if (i == 0 || i + 1 == way_.size()) return true;
    const double end = std::min(way_.front()[z_], way_.back()[z_]);
    return !beyond_limits(scene_, q, kLimitRounding) &&
           !(margins_.lowest_mm && q[z_] < std::min(*margins_.lowest_mm, end));
  }
  /// Of the leg that ends at `i`: the corner at one of its ends, or both, by the least step that frees it.
  bool give_way(std::size_t i) {
    const bool first = i - 1 > 0, second = i + 1 < way_.size();
    for (const double step : kSteps_mm) {
      if (step == 0) continue;
      if (step > most_mm_) break;
      for (int x = -1; x <= 1; ++x)
        for (int y = -1; y <= 1; ++y)
          for (int z = 0; z <= 1; ++z)
            for (const auto& [of_first, of_second] : {std::pair{true, true}, {true, false}, {false, true}}) {
              if ((of_first && !first) || (of_second && !second) || (x == 0 && y == 0 && z == 0)) continue;
              AxisVec a = way_[i - 1], b = way_[i];
              for (AxisVec* q : {&a, &b}) {
                if (q == &a ? !of_first : !of_second) continue;
                (*q)[scene_.x()] += x * step, (*q)[scene_.y()] += y * step, (*q)[z_] += z * step;
              }
              if (!is_allowed(i - 1, a) || !is_allowed(i, b) || !is_free(a, b)) continue;
              if (of_first && !is_free(way_[i - 2], a)) continue;
              if (of_second && !is_free(b, way_[i + 1])) continue;
              way_[i - 1] = a, way_[i] = b;
              return true;
            }
    }
    return false;
  }

  const Scene& scene_;
  const Margins& margins_;
  std::vector<AxisVec>& way_;
  double most_mm_;
  std::size_t z_;
};

/// Around what stands between, as found before or anew.
SearchAnswer around_or_known(const Scene& scene, const AxisVec& from, const AxisVec& to, const Margins& margins,
                             double clearance_mm, const KnownWays* known) {
  if (known != nullptr) {
    SearchAnswer again;
    again.status = SearchStatus::Ok, again.kind = PathKind::Detour;
    if (auto ways = known->like(from, to, clearance_mm)) {
      if (ways->empty()) return {};
      // As it was, if it can be, and else moved as little as it takes.
      for (const double most_mm : WayAgain::kSteps_mm)
        for (const std::vector<AxisVec>& known_way : *ways) {
          std::vector<AxisVec> way = known_way;
          if (!WayAgain(scene, margins, way, most_mm).make_free()) continue;
          again.points = std::move(way);
          return again;
        }
    }
  }
  return around(scene, from, to, margins);
}

}  // namespace

Result<Path> find_path(const Scene& scene, const AxisVec& from, const AxisVec& to, const PathRules& rules,
                       double extra_mm, const Measuring& measuring, const KnownWays* known) {
  auto beyond = beyond_limits(scene, to, kLimitRounding);
  for (std::size_t i = 0; i < scene.axes().size() && !beyond; ++i)
    if (!std::isfinite(from[i])) beyond = i;
  if (beyond) {
    const Scene::Axis& a = scene.axes()[*beyond];
    return fail(Fault::OutOfReach, fmt::format("axis {} would go to {:.3f}; its limits are {:.3f} and {:.3f}", a.name,
                                               to[*beyond], a.p_min, a.p_max));
  }
  auto margins = make_margins(scene, rules.clearance_mm, rules.approaches, extra_mm);
  if (!margins) return tl::unexpected(margins.error());
  margins->lowest_mm = rules.lowest_mm;

  Path path{from == to ? PathKind::Standstill : PathKind::Straight, {from, to}, {}};
  if (const auto straight = first_hit(scene, from, to, *margins)) {
    if (auto taken = end_taken(scene, from, to, *margins)) return tl::unexpected(*std::move(taken));
    if (auto over = lift_over(scene, from, to, *margins)) {
      path.kind = PathKind::LiftOver;
      path.points = std::move(over->points);
    } else {
      SearchAnswer found = around_or_known(scene, from, to, *margins, rules.clearance_mm + extra_mm, known);
      if (found.status != SearchStatus::Ok)
        return tl::unexpected(
            collision(scene, *straight, from, to,
                      fmt::format("{}; tried: straight (free for {:.0f} %), lift-over ({}), around ({}{})",
                                  describe(scene, *straight), 100 * straight->fraction, over.error().why,
                                  why_not(found), no_lower(scene, *margins))));
      path.kind = found.kind;
      path.points = std::move(found.points);
    }
  }
  auto certificate = certify(scene, path.points, rules, extra_mm, {}, measuring);
  if (!certificate) return tl::unexpected(certificate.error());
  path.certificate = *std::move(certificate);
  return path;
}

}  // namespace gantry::motion
