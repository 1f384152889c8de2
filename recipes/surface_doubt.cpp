#include "recipes/surface_doubt.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>

#include "core/units.hpp"

namespace gantry::recipes {
namespace {

// Where the recipe does not state `max_tilt`: what three touches show is believed up to 2 mm over 100 mm, a board that
// nobody has measured is taken to be seated better than that.
constexpr double kMeasuredSlope = 0.02;
constexpr double kUnmeasuredTilt_rad = units::rad(0.15);

double unmeasured_tilt_rad(const TouchRules& rules) { return rules.max_tilt_rad.value_or(kUnmeasuredTilt_rad); }

/// Speed of the touch that counts, over a cycle, and a count of its axis.
double touch_error_of(const config::Machine& machine) {
  const double per_mm = machine.axes[machine.z.value].counts_per_unit;
  return machine.probe.speed_mm_s * seconds(machine.bus.cycle) + (per_mm > 0 ? 1 / per_mm : 0);
}

/// At the worst of these points, the needle over them by the material's gap.
std::optional<std::string> reaches(const Recipe& recipe, const SurfaceDoubt& doubt, std::span<const Vec3> points,
                                   const std::string& material) {
  const Material* m = find_material(recipe, material);
  if (m == nullptr || points.empty()) return std::nullopt;
  const Vec2 p = flat(*std::max_element(points.begin(), points.end(),
                                        [&](Vec3 a, Vec3 b) { return doubt.mm(flat(a)) < doubt.mm(flat(b)); }));
  const double higher_mm = doubt.mm(p), room_mm = std::max(0.0, m->gap - kHeightSlack_mm);
  if (higher_mm <= room_mm) return std::nullopt;
  std::string why = fmt::format(
      "at ({:.2f}, {:.2f}) the board may be {:.3f} mm higher than the touches say, and the needle would "
      "meet it: its gap is {:.6g} mm, {:.6g} mm of that for what a measured height is off by. ",
      p.x, p.y, higher_mm, m->gap, kHeightSlack_mm);
  if (!doubt.tilt_unmeasured())
    return why + fmt::format(
                     "Each touch may be off by {:.3g} mm, most of it what the probe goes in a cycle at its speed, "
                     "and that grows from where the touches lie to there; put them farther apart, or let the "
                     "probe go more slowly (`probe.speed` of the machine)",
                     doubt.touch_error_mm());
  const bool one = recipe.touches.size() == 1;
  why +=
      fmt::format("{}, and `touch_rules.max_tilt` lets it tilt by {:.3g} deg{}",
                  one ? "One touch does not measure a tilt" : "The touches do not measure the tilt across their line",
                  units::deg(unmeasured_tilt_rad(recipe.touch_rules)),
                  recipe.touch_rules.max_tilt_rad ? "" : ", as it does where it is left out");
  return why + fmt::format(
                   "; {}, put a touch within {:.3g} mm of there (it is {:.3g} mm away), or state a smaller "
                   "max_tilt if the board's seat holds it so level",
                   one ? "add two touches, not on one line with it" : "add a touch beside their line",
                   room_mm / max_unmeasured_slope(recipe.touch_rules), doubt.distance_mm(p));
}

}  // namespace

double max_measured_slope(const TouchRules& rules) {
  return rules.max_tilt_rad ? std::tan(*rules.max_tilt_rad) : kMeasuredSlope;
}
double max_unmeasured_slope(const TouchRules& rules) { return std::tan(unmeasured_tilt_rad(rules)); }

SurfaceDoubt::SurfaceDoubt(const Recipe& recipe, const config::Machine& machine)
    : slope_(max_unmeasured_slope(recipe.touch_rules)), touch_error_mm_(touch_error_of(machine)) {
  if (recipe.touches.empty()) return;
  std::vector<Vec2> points;
  for (const TouchPoint& touch : recipe.touches) points.push_back(touch.at);
  known_.emplace(points);
}

double SurfaceDoubt::distance_mm(Vec2 p) const { return known_ ? known_->distance_mm(p) : 0; }

bool SurfaceDoubt::tilt_unmeasured() const { return known_ && !(known_->along_known && known_->across_known); }

double SurfaceDoubt::mm(Vec2 p) const {
  if (!known_) return 0;
  return slope_ * known_->distance_mm(p) + std::max(0.0, touch_error_mm_ * known_->leverage(p) - kHeightSlack_mm);
}

double SurfaceDoubt::mm(Vec2 centre, Vec2 size, double rotation_rad) const {
  double most = 0;
  for (const Vec2 corner : {Vec2{size.x, size.y}, Vec2{size.x, -size.y}, Vec2{-size.x, size.y}, Vec2{-size.x, -size.y}})
    most = std::max(most, mm(centre + rotated(corner * 0.5, rotation_rad)));
  return most;
}

std::optional<std::string> reaches_board(const Recipe& recipe, const SurfaceDoubt& doubt, const Feature& feature) {
  if (const auto* dot = std::get_if<Dot>(&feature))
    return reaches(recipe, doubt, std::array{Vec3{dot->at.x, dot->at.y, 0}}, dot->material);
  const auto& bead = std::get<Bead>(feature);
  return reaches(recipe, doubt, bead.points, bead.material);
}

void check_surface_doubt(const Recipe& recipe, const config::Machine& machine, config::Mistakes& mistakes) {
  if (recipe.touches.empty()) return;
  const SurfaceDoubt doubt(recipe, machine);
  Location last_told;  // an array is one line of the recipe: it is told once
  for (const Feature& feature : recipe.features) {
    const Location location = std::visit([](const auto& f) { return f.location; }, feature);
    if (location == last_told) continue;
    const auto why = reaches_board(recipe, doubt, feature);
    if (!why) continue;
    mistakes.add(
        Fault::Collision,
        fmt::format("{} '{}': {}", std::holds_alternative<Dot>(feature) ? "dot" : "bead", id_of(feature), *why),
        location);
    last_told = location;
  }
  if (recipe.purge && recipe.purge->frame.empty())
    if (const auto why = reaches(recipe, doubt, std::array{recipe.purge->at}, recipe.purge->material))
      mistakes.add(Fault::Collision, "purging: " + *why, recipe.purge->at_location);
}

}  // namespace gantry::recipes
