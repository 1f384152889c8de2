#include "motion/plan/certificate.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <limits>

#include "motion/plan/gap.hpp"
#include "motion/plan/verify.hpp"

namespace gantry::motion {
namespace {

/// True distance of the nearest pair. Proofs are lower bounds, so only pairs whose bound lies below the best are
/// measured.
void measure_nearest(const Scene& scene, std::span<const PairProof> proofs, MotionProof& motion) {
  motion.min_clearance_mm = std::numeric_limits<double>::infinity();
  for (const PairProof& p : proofs) {
    if (p.room_mm >= motion.min_clearance_mm) continue;
    const SceneBody &a = scene.head()[p.head], &b = scene.standing()[p.standing];
    const Vec3 start = scene.carried(a, motion.from), sweep = scene.carried(a, motion.to) - start;
    const double distance = std::max(p.room_mm, measure_gap(moved(a.solid, start), sweep, b.solid).lower);
    if (distance >= motion.min_clearance_mm) continue;
    motion.min_clearance_mm = distance;
    motion.head = a.name, motion.standing = b.name;
  }
}

}  // namespace

std::string describe(const Scene& scene, const Hit& hit) {
  return fmt::format("{} {} {} at ({:.2f}, {:.2f}, {:.2f}) mm", scene.head()[hit.head].name,
                     hit.clearance_mm > 0 ? fmt::format("comes within {:.3g} mm of", hit.clearance_mm) : "meets",
                     scene.standing()[hit.standing].name, hit.point.x, hit.point.y, hit.point.z);
}

Result<Certificate> certify(const Scene& scene, std::span<const AxisVec> polyline, const ClearanceRules& rules,
                            double extra_mm, const Breath& breath) {
  const auto margins = make_margins(scene, rules.clearance_mm, rules.approaches, extra_mm);
  if (!margins) return tl::unexpected(margins.error());
  Certificate out{scene.hash(), rules.clearance_mm, extra_mm, {}, 0, std::numeric_limits<double>::infinity()};
  std::vector<PairProof> proofs;
  for (std::size_t i = 0; i + 1 < polyline.size(); ++i) {
    if (i > 0 && !go_on(breath)) return given_up();
    MotionProof motion;
    motion.from = polyline[i], motion.to = polyline[i + 1];
    proofs.clear();
    if (const auto hit = first_hit(scene, motion.from, motion.to, *margins, &proofs))
      return fail(Fault::Collision, fmt::format("{}, {:.0f} % along motion {} of {}", describe(scene, *hit),
                                                100 * hit->fraction, i + 1, polyline.size() - 1));
    motion.pairs = proofs.size();
    if (motion.pairs != scene.head().size() * scene.standing().size())
      return fail(Fault::Internal, "the sweep has left out a pair of bodies");
    for (const PairProof& p : proofs)
      if (!holds(scene, motion.from, motion.to, p, margins->of(p.head, p.standing)))
        return fail(Fault::Internal, fmt::format("the two collision checks disagree on {} and {}",
                                                 scene.head()[p.head].name, scene.standing()[p.standing].name));
    measure_nearest(scene, proofs, motion);
    out.pairs += motion.pairs;
    out.min_clearance_mm = std::min(out.min_clearance_mm, motion.min_clearance_mm);
    out.motions.push_back(std::move(motion));
  }
  return out;
}

}  // namespace gantry::motion
