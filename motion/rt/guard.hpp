// The last look at a target before it goes to the drives: finite, within the soft limits, no step that the axis's speed
// limit does not allow, and no change of steps that its acceleration limit does not. Planned motion never fails it;
// what fails it is a mistake of ours and must not be sent.
//   Verdict v = check_target(limits, before_last, last_sent, next, missed_ticks);   if (v.fault != Fault::None) -> axis
//   stop
#pragma once
#include "core/fault.hpp"
#include "core/id.hpp"
#include "motion/types.hpp"

namespace gantry::motion {

struct Verdict {
  Fault fault = Fault::None;  ///< TargetNotFinite, SoftLimit, TargetStep
  AxisId axis = kNoAxis;
};

/// before_last: the target of the tick before that of `last`. missed_ticks: ticks that a stall skipped since `last` was
/// sent. `axes`: bit n: axis n is looked at (axes that are not referenced have no limits yet).
Verdict check_target(const Limits& limits, const AxisVec& before_last, const AxisVec& last, const AxisVec& next,
                     int missed_ticks = 0, std::uint32_t axes = 0xFFFFFFFFu) noexcept;

}  // namespace gantry::motion
