// What scripts do to the bus and its drives.
//   do_action(action, segment, machine);   // between two frames, on the thread that owns the segment
#pragma once
#include "config/machine.hpp"
#include "sim/script/world_event.hpp"

namespace gantry::sim {

class Segment;

/// The action names what the machine has (sim/script/names.hpp).
void do_action(const BusAction& action, Segment& segment, const config::Machine& machine);

}  // namespace gantry::sim
