#include "motion/plan/verify.hpp"

#include <cmath>

namespace gantry::motion {

bool holds(const Scene& scene, const AxisVec& from, const AxisVec& to, const PairProof& proof, double margin_mm) {
  constexpr double kRounding = 1e-9;  // mm on a metre, in double precision with room to spare
  const Vec3 n = proof.direction;
  if (!(std::abs(dot(n, n) - 1) < kRounding)) return false;
  const SceneBody &a = scene.head()[proof.head], &b = scene.standing()[proof.standing];
  // Furthest of the moving body along n is at one of the two ends of its motion; both are looked at.
  const double reach = extent(a.solid, n);
  const double at_from = dot(n, a.solid.centre + scene.carried(a, from)) + reach;
  const double at_to = dot(n, a.solid.centre + scene.carried(a, to)) + reach;
  const double begins = dot(n, b.solid.centre) - extent(b.solid, n);
  return begins - at_from >= margin_mm - kRounding && begins - at_to >= margin_mm - kRounding;
}

}  // namespace gantry::motion
