// Homing is done by the drives themselves, each axis for itself. Where it is known where the head stands, what they may
// sweep is proved before anything moves; where it is not, nothing can be proved, and the order of the machine file (Z
// first) is all that there is.
//   if (job::head_is_placed(machine, referenced))
//     if (auto free = job::prove_homing(machine, around, at, {.referenced = referenced}); !free) ...
#pragma once
#include <cstdint>
#include <vector>

#include "app/job/surroundings.hpp"
#include "config/machine.hpp"
#include "core/axis_vec.hpp"
#include "core/error.hpp"

namespace gantry::job {

/// From where to where an axis may go while it homes from `at`: to its home edge and beyond by what it needs to stop,
/// and by its method to a limit first.
struct HomingRange {
  double low = 0, high = 0;
};
HomingRange homing_range(const config::Axis& axis, double at);
/// The same where nobody knows where it stands: its whole travel, and beyond by what it needs to stop.
HomingRange homing_range(const config::Axis& axis);

/// X, Y and Z are referenced: then it is known where every body of the head is, but for the height of those on the
/// lift and how those stand that turn with C.
bool head_is_placed(const config::Machine& machine, std::uint32_t referenced);

/// Bit n: AxisId n.
struct HomingAxes {
  std::uint32_t referenced = ~0u;  ///< the others may stand anywhere in their travel
  std::uint32_t homed = ~0u;       ///< which home now; the others stand
};

/// Axes of one order home together and each as fast as it does, so that the head may be anywhere in the box that their
/// ranges span; then they stand at their home edges, and the next order begins. What stands nearer to the head than the
/// clearance when an order begins comes no nearer. The head is placed. Fault::Collision with both bodies, the axes and
/// how to get out: where axes have lost their reference, whether these alone are proved to home where the head stands.
Result<void> prove_homing(const config::Machine& machine, const Surroundings& around, const AxisVec& at,
                          const HomingAxes& axes = {});

}  // namespace gantry::job
