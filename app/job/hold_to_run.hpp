// What a client orders to jog is hold-to-run: it stands within 100 ms of its client's last word. Of those the first
// part goes by until the silence is heard, the second until targets and axes follow, and the rest is left to brake in.
//   client: says something every kBeat;   desk: ends the jog after silence(cycle);
//   jog: no faster than what stands within braking_s(machine) by the axes' own limits.
#pragma once
#include <algorithm>
#include <cmath>

#include "config/machine.hpp"
#include "core/clock.hpp"

namespace gantry::job::hold_to_run {

inline constexpr Time kStands = milliseconds(100);

/// How often a client says something at least; several times in every silence().
inline constexpr Time kBeat = milliseconds(5);

/// Who has said nothing for so long is silent: 36 ms at a cycle of 1 ms, 18 ms at one of 10 ms.
constexpr Time silence(Time cycle) { return milliseconds(38) - 2 * cycle; }

/// Until the word was read, the silence is seen, the loop knows it and the last target was sent a cycle passes for
/// each; and the thread that waits between cycles is woken late.
constexpr Time latency(Time cycle) { return 4 * cycle + milliseconds(1); }

/// Seconds that are left to brake in; not above 0 where axes answer so late that there are none.
inline double braking_s(const config::Machine& machine) {
  double answers_s = 0;  // all axes wait for the one that answers last
  for (const config::Axis& axis : machine.axes)
    if (axis.kind == config::AxisKind::Streamed) answers_s = std::max(answers_s, axis.response_delay_s);
  return seconds(kStands - silence(machine.bus.cycle) - latency(machine.bus.cycle)) - answers_s;
}

/// The speed that is never exceeded by what stands `within_s` after it was told to, whenever that is. The worst moment
/// is the end of the largest acceleration on the way to it: that has to be let go first, and has its share of the speed
/// until then. With acceleration A = min(a, sqrt(v j)) there, standing takes A/j + (A/j + v/A): 3 sqrt(v/j), or 2 a/j +
/// v/a where v is above a²/j.
inline double speed_that_stands(double within_s, double a, double j) {
  if (within_s <= 0) return 0;
  if (within_s < 3 * a / j) return j * within_s * within_s / 9;
  return a * (within_s - 2 * a / j);
}

}  // namespace gantry::job::hold_to_run
