// How much higher than its touches say the board may be. One touch does not measure the tilt, two do not measure it
// across the line through them: it is bounded by `touch_rules.max_tilt` there. Touches that lie close together measure
// it, but what each of them is off by grows with the distance from them.
//   SurfaceDoubt doubt(recipe, machine);   doubt.mm(dot.at);      // mm; 0 with three touches that lie far apart
#pragma once
#include <optional>

#include "config/machine.hpp"
#include "config/yaml.hpp"
#include "core/tilt_known.hpp"
#include "core/vec.hpp"
#include "recipes/recipe.hpp"

namespace gantry::recipes {

/// Measured heights and following error may take this much of a gap.
inline constexpr double kHeightSlack_mm = 0.05;

/// mm per mm. Of a tilt that touches have measured, and of one that they have not.
double max_measured_slope(const TouchRules& rules);
double max_unmeasured_slope(const TouchRules& rules);

class SurfaceDoubt {
 public:
  /// A recipe without touches states that the surface is where its drawing has it: there is no doubt then.
  SurfaceDoubt(const Recipe& recipe, const config::Machine& machine);
  /// What a height that was touched may be off by.
  [[nodiscard]] double touch_error_mm() const { return touch_error_mm_; }

  /// Over a point of the board. Between two points it is at most the greater of theirs.
  [[nodiscard]] double mm(Vec2 p) const;
  /// The most over a rectangle.
  [[nodiscard]] double mm(Vec2 centre, Vec2 size, double rotation_rad) const;
  /// From `p` to the nearest point at which the touches say how high the board is.
  [[nodiscard]] double distance_mm(Vec2 p) const;
  /// The touches leave the tilt open, in one direction or in both.
  [[nodiscard]] bool tilt_unmeasured() const;

 private:
  std::optional<TiltKnown> known_;
  double slope_ = 0, touch_error_mm_ = 0;
};

/// Why the needle might meet the board while it dispenses, in words; nothing where it stays over it.
std::optional<std::string> reaches_board(const Recipe& recipe, const SurfaceDoubt& doubt, const Feature& feature);

/// Every feature, and a purge on the board, whose needle might meet the board. Fault::Collision.
void check_surface_doubt(const Recipe& recipe, const config::Machine& machine, config::Mistakes& mistakes);

}  // namespace gantry::recipes
