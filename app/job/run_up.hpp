// How a bead begins: at its speed, after a run-up; and where a body is in the way of that, the next of these
// that is free:
//   a shorter one, at the highest of 16 even steps of speed above the material's `min_speed`
//   one from above: down from `retract` and forward at the same time, at the bead's speed
//   none: from rest, straight down onto the first point, where `min_speed` is 0
// A bead that was cut is joined by the same rules, where it was cut; its run-up comes down onto what lies, from above
// means from `retract` over it. Where no whole one leads there, one that goes along what lies for some mm is tried
// first.
//   auto begun = plan_begin(limits, spec, material, is_free);     begun->motion, begun->how
// Pure: which one it is depends on the arguments and on what `is_free` says.
#pragma once
#include <cstdint>
#include <functional>
#include <string>

#include "core/error.hpp"
#include "motion/path/bead.hpp"
#include "recipes/recipe.hpp"

namespace gantry::job {

struct RunUp {
  enum class Kind : std::uint8_t { Whole, Shorter, FromAbove, FromRest };
  Kind kind = Kind::Whole;
  std::uint32_t feature = 0;  ///< index in Recipe::features
  double mm = 0;              ///< along the bead's direction
  double entry_mm_s = 0;      ///< at the bead's first point, or where it is joined
  bool joins = false;         ///< a bead that was cut
  std::string blocked{};      ///< why it is not whole: "its run-up of 0.85 mm: needle comes within 2 mm of post at ..."
};

struct BegunBead {
  motion::BeadMotion motion;
  RunUp how;
};

/// Whether the needle may come to its bead like this. Fault::Aborted ends the search.
using IsFree = std::function<Result<void>(const motion::BeadMotion&, RunUp::Kind)>;

/// What nothing is in the way of is begun whole, and whatever it is where the material has a `start_dwell`. The error
/// is that of the whole run-up, which names it and the body; those of plan_bead() that have nothing to do with room are
/// passed on.
Result<BegunBead> plan_begin(const motion::Limits& limits, motion::BeadSpec spec, const recipes::Material& material,
                             const IsFree& is_free);

/// "begins at 12 mm/s instead of 20 mm/s, after a run-up of 0.31 mm; its run-up of 0.85 mm: needle comes within ..."
std::string in_words(const RunUp& run_up, const recipes::Material& material);

}  // namespace gantry::job
