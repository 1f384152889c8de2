// From the machine file to the plain values that the loop takes. The one place where names become bits
// and indices.
#pragma once
#include "app/cycle/loop_setup.hpp"
#include "config/machine.hpp"
#include "core/error.hpp"

namespace gantry::run {

/// What the loop runs on, which decides how much lateness is a fault.
enum class Host {
  Hardware,     ///< drives of steel behind an interface
  Wire,         ///< a simulated machine behind an interface: stalls of its host are forgiven, lost frames are not
  VirtualTime,  ///< a simulated machine in this process that steps with the loop
  WallClock,    ///< the same under the wall clock: when the host stalls, its bus stands still too
};

/// Layouts of the drives in their stations' images, scales, limits, I/O bits. Fault::Inconsistent when the machine asks
/// for more than the loop holds or a profile lacks what CSP needs.
Result<cycle::LoopSetup> compose_loop(const config::Machine& machine, Host host);

/// Adds the homing objects of every axis to its stations' start-up rows, so that they are written (and written again
/// after a power cycle) with the rest of the station's record. Fault::OutOfRange, BadUnit when a drive cannot take
/// them.
Result<void> compose_startup(config::Machine& machine);

}  // namespace gantry::run
