// Random pairs and random plans, judged by code that shares nothing with the planner: closed forms of
// tests/motion/plan/prism_distance.hpp, along a motion by golden sections and by walking as far as the distance allows;
// plans also by the simulated world (world_judge.hpp), where some boxes lean and parts touch each other.
//   PairTally t = try_pairs(100000, seed);   // t.false_free must be 0
#pragma once
#include <cstdint>

namespace gantry::test {

struct PairTally {
  int free = 0, hit = 0;
  int false_free = 0;     ///< called free, but they come as near as the margin and 1e-9 mm
  int false_hits = 0;     ///< called a hit, but they keep more than the margin and 1e-6 mm
  int close_calls = 0;    ///< called a hit, but they keep more than the margin, by at most 1e-6 mm
  int disagreements = 0;  ///< of is_clear() and first_hit(), or a proof that the second check refuses
};
/// A quarter of them at the margin to within a micrometre, down to 1e-10 mm. Thin foils, needles, a common grid.
PairTally try_pairs(int count, std::uint64_t seed);

struct PlanTally {
  int ok = 0, no_path = 0, budget = 0, taken = 0;  ///< taken: an end collides
  int colliding = 0;                               ///< paths that the judge finds a collision on
  int in_world = 0;                                ///< paths on which the simulated world sees one
  int unseen = 0;                                  ///< ends that collide, on which the world sees nothing
  int refused = 0;                                 ///< paths that the second check refuses
  int disproved = 0;                               ///< "no path", but chance has found one that the judge finds free
  int longer = 0;                                  ///< than the lift-over
  int different = 0;                               ///< asked again, another answer
};
PlanTally try_plans(int count, std::uint64_t seed);

}  // namespace gantry::test
