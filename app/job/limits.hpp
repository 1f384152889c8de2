// The bounds that motions of a machine are planned under.
#pragma once
#include "config/machine.hpp"
#include "motion/types.hpp"

namespace gantry::job {

/// Position limits, speed, acceleration and jerk of every axis, and the length of a tick.
motion::Limits limits_of(const config::Machine& machine);

}  // namespace gantry::job
