// Phase synchronisation: where displacement, speeds and accelerations at both ends all point along one line, the
// axes move as one scalar along it, within the bounds of all of them.
#pragma once
#include "motion/profile/together.hpp"

namespace gantry::motion {

/// False, and nothing changed, when the motion lies on no line, or none was found on it.
bool move_straight(std::span<const AxisMove> axes, const Together& how, Joint& out) noexcept;

}  // namespace gantry::motion
