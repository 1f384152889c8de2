// Beads whose plan is slower than their material's speed, and where it is not merely a corner that slows them down: a
// curve too tight for the speed, corners so near that it is never reached, or so few ticks that a whole number of them
// makes a difference; and beads that come to a stop with the valve open, though a corner tolerance is there to pass
// corners without. Known before anything moves.
//   std::vector<SlowBead> slow;   add_slow_beads(slow, recipe, block.segments(), machine);   in_words(slow[0], recipe);
// Not of materials with `flow_follows_speed`.
#pragma once
#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "config/machine.hpp"
#include "core/breath.hpp"
#include "motion/types.hpp"
#include "recipes/recipe.hpp"

namespace gantry::job {

struct SlowBead {
  std::uint32_t feature = 0;  ///< index in Recipe::features
  double asked_mm_s = 0;
  double steady_mm_s = 0;   ///< the speed that it holds where it is too slow; 0: it never holds one
  double sags_s = 0;        ///< so long it is too slow, and comes down to steady_mm_s; 0: it holds it
  double fastest_mm_s = 0;  ///< that it comes to
  std::optional<double> begins_slowly_mm_s{};  ///< where the valve opens, if it speeds up from there to its end
  double at_speed = 0;                         ///< share of its length within `speed_tolerance`, 0..1
  bool narrowly = false;  ///< within it by so little that a job finds it slow, or does not: its drives lag
  double lags = 0;        ///< then, where its curve is the reason: the part that they take; steady_mm_s would do
  /// Where it is slow only because a bead takes whole ticks: how long it takes, and how long it would take else.
  double lasts_s = 0, would_last_s = 0;
  double tick_s = 0;
  /// How often it stands in mid bead, where neither a tolerance of 0 nor a corner that leads straight back asks for
  /// it, and how far from where the valve opens first. 0: never;
  /// else nothing of the above is known.
  std::size_t stands = 0;
  double stands_at_mm = 0;
};

/// Of the beads of these segments, in their order.
void add_slow_beads(std::vector<SlowBead>& to, const recipes::Recipe& recipe,
                    const std::deque<motion::Segment>& segments, const config::Machine& machine,
                    const Breath& breath = {});

/// "stands still 3 times with its valve open, first 12.3 mm from where that opens: no path ..."
std::string standstill_in_words(std::size_t times, double at_mm, const recipes::Bead& bead,
                                const recipes::Material& material);

/// Corners of it that lead straight back: to rest in each is as near to the recipe as to turn within its tolerance.
std::size_t reversals(const recipes::Bead& bead);

/// "planned at 88 mm/s instead of 100 mm/s: the axes' limits allow no more on its curve, radius 3 mm; ..."
std::string in_words(const SlowBead& bead, const recipes::Recipe& recipe);

}  // namespace gantry::job
