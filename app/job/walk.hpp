// A walk: one axis goes a short distance and back, to be watched by a person who then says which axis moved and which
// way. It is for a machine that nobody has homed yet, so that nothing knows where the head stands.
//   auto planned = plan_walk(machine, around, at, axis, false);     control.play(*planned, Purpose::Walk);
#pragma once
#include <string>

#include "app/job/proven_block.hpp"
#include "app/job/surroundings.hpp"
#include "config/machine.hpp"
#include "core/axis_vec.hpp"
#include "core/error.hpp"

namespace gantry::job {

/// The farthest that any axis goes: 1 mm, or 3 degrees. mm or rad.
double walk_most(const config::Axis& axis) noexcept;
/// How far an axis goes first, in its coordinate (mm or rad): up it; the lift, which counts downwards, down it, so that
/// what it carries goes up. Its counts take no motor farther than walk_most() whose station could be taken for its own.
double walk_by(const config::Machine& machine, const config::Axis& axis) noexcept;
/// Twice that in a second, and no more than the axis can. mm/s or rad/s.
double walk_speed(const config::Machine& machine, const config::Axis& axis) noexcept;
/// "+1 mm at 2 mm/s", "-3 deg at 6 deg/s".
std::string walk_in_words(const config::Machine& machine, const config::Axis& axis);

/// By walk_by(), a moment at rest, and back to where it stands. Where
/// all axes are referenced it is proved like a jog. Where they are not, nothing can be proved among bodies, as in
/// homing: what holds then is its length, which the loop watches (Purpose::Walk), and that a person keeps the distance
/// free. Fault::OutOfReach, Collision.
Result<ProvenBlock> plan_walk(const config::Machine& machine, const Surroundings& around, const AxisVec& at,
                              const config::Axis& axis, bool all_referenced);

}  // namespace gantry::job
