#include "motion/plan/find_path.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

#include "motion/plan/give_way.hpp"
#include "motion/plan/lift_over.hpp"

namespace gantry::motion {
namespace {

/// A job waits for it, and one that is refused is refused at once: about a tenth of a second.
constexpr SearchBudget kBudget{.cuts = 10000};

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

/// Around what stands between, as found before or anew.
SearchAnswer around_or_known(const Scene& scene, const AxisVec& from, const AxisVec& to, const Margins& margins,
                             double clearance_mm, const KnownWays* known) {
  const auto ways = known != nullptr ? known->like(from, to, clearance_mm) : std::nullopt;
  if (!ways) return around(scene, from, to, margins);
  SearchAnswer again;
  if (ways->empty()) return again;
  auto way = give_way(scene, *ways, margins);
  if (!way) return around(scene, from, to, margins);
  again.status = SearchStatus::Ok, again.kind = PathKind::Detour, again.points = *std::move(way);
  return again;
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
