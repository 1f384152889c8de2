// Two bodies that would come nearer to each other than they may, for a picture of it: who refuses a motion because of a
// collision hangs one of these on the error.
//   return tl::unexpected(Error{Fault::Collision, words, "", std::make_shared<Meeting>(meeting)});
#pragma once
#include <string>

#include "core/axis_vec.hpp"
#include "core/vec.hpp"

namespace gantry {

struct Meeting {
  std::string head, standing;  ///< the two bodies
  AxisVec from{}, to{};        ///< the motion of the axes that is refused
  AxisVec axes{};              ///< where on it the pair first comes too near
  Vec3 machine_mm{};           ///< on the standing body, machine frame
  double clearance_mm = 0;     ///< what the pair was to keep
};

}  // namespace gantry
