#include "motion/plan/certificate.hpp"

#include <algorithm>
#include <fmt/format.h>

#include "motion/plan/gap.hpp"
#include "motion/plan/verify.hpp"

namespace gantry::motion {
namespace {

/// Overlapping bodies have no nearest points: the middle of what their boxes share.
Vec3 middle_of_overlap(const Solid& a, const Solid& b) {
  const auto middle = [&](double Vec3::*c, Vec3 n) {
    const double a_half = extent(a, n), b_half = extent(b, n);
    return (std::max(a.centre.*c - a_half, b.centre.*c - b_half) +
            std::min(a.centre.*c + a_half, b.centre.*c + b_half)) /
           2;
  };
  return {middle(&Vec3::x, {1, 0, 0}), middle(&Vec3::y, {0, 1, 0}), middle(&Vec3::z, {0, 0, 1})};
}

/// True distances of the nearest pairs. Proofs are lower bounds, so only pairs whose bound lies below the best are
/// measured.
void measure_nearest(const Scene& scene, const AxisVec& from, const AxisVec& to, const Margins& margins,
                     std::span<const PairProof> proofs, std::size_t motion, NearPairs& nearest) {
  for (const PairProof& p : proofs) {
    if (p.room_mm >= nearest.others.distance_mm && p.room_mm >= nearest.by_design.distance_mm) continue;
    NearPair& best = margins.by_design(p.head, p.standing) ? nearest.by_design : nearest.others;
    if (p.room_mm >= best.distance_mm) continue;
    const SceneBody &a = scene.head()[p.head], &b = scene.standing()[p.standing];
    const Vec3 start = scene.carried(a, from), sweep = scene.carried(a, to) - start;
    const Solid body = moved(a.solid, start);
    const Gap gap = measure_gap(body, sweep, b.solid);
    const double distance = std::max(p.room_mm, gap.lower);
    if (distance >= best.distance_mm) continue;
    best = {distance, p.head, p.standing, motion,
            gap.upper > 0 ? gap.on_standing : middle_of_overlap(moved(body, sweep), b.solid)};
  }
}

}  // namespace

std::string describe(const Scene& scene, const Hit& hit) {
  return fmt::format("{} {} {} at {}", scene.head()[hit.head].name,
                     hit.clearance_mm > 0 ? fmt::format("comes within {:.3g} mm of", hit.clearance_mm) : "meets",
                     scene.standing()[hit.standing].name, scene.told(hit.point));
}

Result<Certificate> certify(const Scene& scene, std::span<const AxisVec> polyline, const ClearanceRules& rules,
                            double extra_mm, const Breath& breath, const NearPairs& known) {
  const auto margins = make_margins(scene, rules.clearance_mm, rules.approaches, extra_mm);
  if (!margins) return tl::unexpected(margins.error());
  Certificate out{scene.hash(), rules.clearance_mm, extra_mm, 0, 0, known};
  std::vector<PairProof> proofs;
  for (std::size_t i = 0; i + 1 < polyline.size(); ++i) {
    if (i > 0 && !go_on(breath)) return given_up();
    const AxisVec &from = polyline[i], &to = polyline[i + 1];
    proofs.clear();
    if (const auto hit = first_hit(scene, from, to, *margins, &proofs))
      return fail(Fault::Collision, fmt::format("{}, {:.0f} % along motion {} of {}", describe(scene, *hit),
                                                100 * hit->fraction, i + 1, polyline.size() - 1));
    if (proofs.size() != scene.head().size() * scene.standing().size())
      return fail(Fault::Internal, "the sweep has left out a pair of bodies");
    for (const PairProof& p : proofs)
      if (!holds(scene, from, to, p, margins->of(p.head, p.standing)))
        return fail(Fault::Internal, fmt::format("the two collision checks disagree on {} and {}",
                                                 scene.head()[p.head].name, scene.standing()[p.standing].name));
    measure_nearest(scene, from, to, *margins, proofs, i, out.nearest);
    out.pairs += proofs.size();
    ++out.motions;
  }
  return out;
}

}  // namespace gantry::motion
