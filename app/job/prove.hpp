// The proof before motion: every motion of a job at the board's nominal place, planned and certified without a machine.
#pragma once
#include "config/machine.hpp"
#include "core/axis_vec.hpp"
#include "core/error.hpp"
#include "recipes/job.hpp"

namespace gantry::job {

struct NominalProof {
  std::size_t motions = 0;
  double minimum_clearance_mm = 0;
  double duration_s = 0;  ///< of all blocks, without waiting for images
};

/// From the park position through all blocks and back. Fault::Collision, OutOfReach, SpeedNotReachable with the
/// recipe's line.
Result<NominalProof> prove_nominal(const config::Machine& machine, const recipes::Recipe& recipe,
                                   const recipes::Job& job);

}  // namespace gantry::job
