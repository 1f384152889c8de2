// From the machine file to the plain values that the loop takes. The one place where names become bits
// and indices.
#pragma once
#include "app/cycle/loop_setup.hpp"
#include "config/machine.hpp"
#include "core/error.hpp"

namespace gantry::run {

/// Layouts of the drives in their stations' images, scales, limits, I/O bits. Fault::Inconsistent when the machine asks
/// for more than the loop holds or a profile lacks what CSP needs.
Result<cycle::LoopSetup> compose_loop(const config::Machine& machine, bool hardware);

/// Adds the homing objects of every axis to its stations' start-up rows, so that they are written (and written again
/// after a power cycle) with the rest of the station's record. Fault::OutOfRange, BadUnit when a drive cannot take
/// them.
Result<void> compose_startup(config::Machine& machine);

}  // namespace gantry::run
