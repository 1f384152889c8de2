// How far a proof at the nominal placement reaches: touches and features whose motions are not free wherever the
// recipe's rules let the board lie. They are proved again when the board is found, and may be refused then, after marks
// and touches.
//   auto named = only_when_placed(machine, recipe, job);      // Result<std::vector<OnlyWhenPlaced>>
#pragma once
#include <functional>
#include <string>
#include <vector>

#include "config/machine.hpp"
#include "core/breath.hpp"
#include "core/error.hpp"
#include "recipes/job.hpp"

namespace gantry::job {

struct OnlyWhenPlaced {
  std::string feature;  ///< or "touch t1"
  Error why;            ///< what it may meet, with the recipe's line
};

/// Seen from the board, whatever stays (the machine's bodies, fixtures, zones) may be off by the rules' shift, by their
/// turn times the distance of the furthest feature or touch from the board's origin, and in height by the touches'
/// window; the head, which does not turn with the board, by the turn times each body's reach from the needle, or the
/// stylus (what turns with C does). Each body is grown by that, and each feature planned among them, down from the safe
/// height and up again. What carries the board is not grown: the needle's distance to it is by design. A tilt that
/// touches measure is not counted. Fault::Aborted when the breath says no. `count` is called with each feature that is
/// planned.
Result<std::vector<OnlyWhenPlaced>> only_when_placed(const config::Machine& machine, const recipes::Recipe& recipe,
                                                     const recipes::Job& job, const Breath& breath = {},
                                                     const std::function<void()>& count = {});
/// Whether a job of this recipe finds out where the board lies; else there is nothing to ask.
bool asks_wherever(const recipes::Recipe& recipe);

/// "'a', 'b' and 3 more (a: why)".
std::string to_text(const std::vector<OnlyWhenPlaced>& features);

}  // namespace gantry::job
