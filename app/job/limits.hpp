// The bounds that motions of a machine are planned under.
#pragma once
#include "config/machine.hpp"
#include "motion/plan/scene.hpp"
#include "motion/types.hpp"

namespace gantry::job {

/// Position limits, speed, acceleration and jerk of every axis, and the length of a tick.
motion::Limits limits_of(const config::Machine& machine);

/// What every pair of bodies keeps on a path, over and above what the path may deviate: the machine's clearance, and
/// how far its axes may be off their path.
double kept_mm(const config::Machine& machine, const motion::Scene& scene);

}  // namespace gantry::job
