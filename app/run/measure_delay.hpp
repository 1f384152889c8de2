// How far an axis lags its command, found from its own position (6064h) at constant speed: there and back, so that
// friction and backlash, which have a sign, fall out. The motion is an owner's jog, proved like any.
//   auto found = measure_delay(owner, machine, {.axis = "X"});
// An open-loop drive shows its command as its position: there is nothing to measure, and it is refused.
#pragma once
#include <functional>
#include <string>

#include "app/run/owner.hpp"

namespace gantry::run {

struct DelayWords {
  std::string axis;
  std::string speed{};  ///< "50 mm/s", "45 deg/s"; "" takes what suits the axis
};

/// mm/s or rad/s. What can be refused before anything moves is refused here: Fault::Usage (no such axis, a speed that
/// is none, or more or less than the axis is moved with), Refused (open loop), PositionedAxisInMove, OutOfReach (the
/// axis is shorter than it takes).
Result<double> measuring_speed(const config::Machine& machine, const DelayWords& words);

/// One cycle is taken for the route of 6064h to the loop (DC: it is the position of the last SYNC0); a drive that shows
/// an older one seems that much later. What measuring_speed() refuses, Refused (the lag is not constant),
/// OutOfReach (too little travel is left), and what a jog may come to.
Result<config::MeasuredDelay> measure_delay(Owner& owner, const config::Machine& machine, const DelayWords& words,
                                            const std::function<void()>& poll = {});

}  // namespace gantry::run
