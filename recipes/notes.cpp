#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <numbers>

#include "config/quick_stop.hpp"
#include "core/units.hpp"
#include "recipes/bus_notes.hpp"
#include "recipes/covered.hpp"
#include "recipes/job.hpp"
#include "recipes/surface_doubt.hpp"

namespace gantry::recipes {
namespace {

double watchdog_s(const config::Machine& machine, StationId station) {
  return machine.stations[station.value].profile.watchdog_ms * 1e-3;
}

/// Distance that the head travels after the bus is lost at a speed: until its drives' watchdogs bite at that speed,
/// then the braking distance, as hard as allowed.
double stopping_mm(const config::Machine& machine, double speed_mm_s) {
  double most = 0;
  for (const AxisId id : {machine.x, machine.y}) {
    const config::Axis& axis = machine.axes[id.value];
    for (const config::DriveRef& drive : axis.drives)
      most =
          std::max(most, speed_mm_s * watchdog_s(machine, drive.station) + speed_mm_s * speed_mm_s / (2 * axis.a_max));
  }
  return most;
}

/// The virtual valve acts as late as the machine file says; another lead, or one that is no whole number of cycles,
/// shows in a dry run as an early or late valve.
void add_lead(const Material& m, std::string_view key, double lead_s, const config::Machine& machine, double lag_s,
              std::string_view acts, std::vector<std::string>& to) {
  constexpr double kSame_s = 0.5e-3;
  const double cycle_s = seconds(machine.bus.cycle), told_s = std::round(lead_s / cycle_s) * cycle_s;
  const double late_s = lag_s - told_s;
  if (std::abs(late_s) <= kSame_s) return;
  const std::string told =
      std::abs(told_s - lead_s) <= kSame_s
          ? std::string()
          : fmt::format(", which is {:.6g} ms in cycles of {:.6g} ms", told_s * 1e3, cycle_s * 1e3);
  to.push_back(
      fmt::format("{}: {} is {:.6g} ms{}, but the virtual valve {} {:.6g} ms after it is told: a dry run shows it "
                  "{:.6g} ms {}, {:.2f} mm on a bead",
                  m.name, key, lead_s * 1e3, told, acts, lag_s * 1e3, std::abs(late_s) * 1e3,
                  late_s > 0 ? "late" : "early", std::abs(late_s) * m.speed));
}

std::string tolerances_in_words(const Material& m) {
  return fmt::format("{}: a deposit is good within {:.6g} mm of its place, {:.6g} mm of its gap{}", m.name,
                     m.tolerance_mm, m.gap_tolerance_mm,
                     m.flow_follows_speed ? std::string("; its flow follows the speed")
                                          : fmt::format(" and {:.6g} % of its speed", m.speed_tolerance * 100));
}

double longest_watchdog_s(const config::Machine& machine) {
  double longest = 0;
  for (const config::Axis& axis : machine.axes)
    for (const config::DriveRef& drive : axis.drives) longest = std::max(longest, watchdog_s(machine, drive.station));
  return longest;
}

/// Axes whose drives are not known to brake by themselves, as "X, Z".
std::string left_to_stations(const config::Machine& machine) {
  std::string names;
  for (const config::Axis& axis : machine.axes) {
    const bool hoped_for = config::quick_stop_of(machine, axis) != config::QuickStop::Brakes;
    if (axis.kind == config::AxisKind::Streamed && hoped_for) names += (names.empty() ? "" : ", ") + axis.name;
  }
  return names;
}

/// What is taken for granted where touches do not measure the tilt.
void add_tilt(const Recipe& recipe, const config::Machine& machine, std::vector<std::string>& to) {
  const std::size_t touches = recipe.touches.size();
  const double slope = max_unmeasured_slope(recipe.touch_rules),
               simulated = std::numbers::sqrt2 * machine.sim.tilt_spread_rad;
  std::string note = fmt::format(
      "{} touch{}: the board is taken to be level {}, within {:.3g} deg ({})", touches, touches == 1 ? "" : "es",
      touches == 1 ? "in both directions" : "across the line through them", units::deg(std::atan(slope)),
      recipe.touch_rules.max_tilt_rad ? "`touch_rules.max_tilt`" : "`touch_rules.max_tilt` is left out");
  if (simulated > slope)
    note += fmt::format(
        "; the simulated machine's boards tilt by up to {:.3g} deg (`sim.board.tilt_spread`), and the "
        "needle may meet one that does",
        units::deg(simulated));
  to.push_back(std::move(note));
}

/// Marks and touches that may disagree by more than a deposit may be off.
void add_residuals(const Recipe& recipe, std::vector<std::string>& to) {
  const auto least = [&](double Material::*tolerance) {
    return std::ranges::min_element(recipe.materials, {}, tolerance);
  };
  if (recipe.materials.empty()) return;
  const auto add = [&](const char* key, double residual_mm, const char* what, const Material& m, double tolerance_mm,
                       const char* tolerance) {
    if (residual_mm > tolerance_mm)
      to.push_back(
          fmt::format("`{}.max_residual` of {:.6g} mm is more than `{}` of '{}', {:.6g} mm: a job goes on "
                      "with {} that disagree by more than its deposits may be off; write {:.6g} mm or less",
                      key, residual_mm, tolerance, m.name, tolerance_mm, what, tolerance_mm));
  };
  if (recipe.marks.size() > 1) {
    const auto m = least(&Material::tolerance_mm);
    add("mark_rules", recipe.mark_rules.max_residual_mm, "marks", *m, m->tolerance_mm, "tolerance");
  }
  if (recipe.touches.size() > 3) {
    const auto m = least(&Material::gap_tolerance_mm);
    add("touch_rules", recipe.touch_rules.max_residual_mm, "touches", *m, m->gap_tolerance_mm, "gap_tolerance");
  }
}

/// Fills that leave out more than strips of that width leave beside them.
void add_bare(const Recipe& recipe, std::vector<std::string>& to) {
  constexpr double kFar = 2.5, kMuch = 0.25;  // of the spacing, more than into a corner of 40 degrees; of the area
  for (const Fill& fill : recipe.fills)
    if (fill.bare_mm > kFar * fill.spacing_mm || fill.bare_share > kMuch)
      to.push_back(
          fmt::format("fill '{}' (line {}): {:.2g} % of its area is not covered, up to {:.3g} mm from the nearest "
                      "line, at ({:.4g}, "
                      "{:.4g}) mm: lines keep half of `spacing` from the outline, so that what is narrower than {:.6g} "
                      "mm gets none; "
                      "lower `spacing`, turn the lines by `angle`, or draw that part by itself",
                      fill.name, fill.location.line, fill.bare_share * 100, fill.bare_mm, fill.bare_at.x,
                      fill.bare_at.y, fill.spacing_mm));
}

}  // namespace

std::vector<std::string> notes(const Recipe& recipe, const config::Machine& machine) {
  std::vector<std::string> out;
  if (recipe.marks.empty())
    out.push_back(std::string("no marks: the board is taken to lie at its nominal placement") +
                  (recipe.placement == Placement::Fixture
                       ? ", where its fixture holds it"
                       : "; as nothing says so, every job ends with defects unless the recipe has marks or "
                         "`placement: fixture`"));
  if (recipe.marks.size() == 2)
    out.push_back("two marks: nothing but their distance shows that they are the right ones");
  if (!recipe.marks.empty() && !machine.outputs[static_cast<std::size_t>(config::Output::CameraLight)])
    out.push_back("the machine has no output 'camera_light': marks are seen by whatever light there is");
  if (recipe.touches.empty()) out.push_back("no touches: the board's surface is taken to be at its nominal height");
  if (SurfaceDoubt(recipe, machine).tilt_unmeasured()) add_tilt(recipe, machine, out);
  add_residuals(recipe, out);
  add_covered(recipe, out);
  add_bare(recipe, out);
  for (const Material& m : recipe.materials) {
    out.push_back(tolerances_in_words(m));
    add_lead(m, "valve_open_lead", m.valve_open_lead, machine, machine.sim.valve_open_lag_s, "opens", out);
    add_lead(m, "valve_close_lead", m.valve_close_lead, machine, machine.sim.valve_close_lag_s, "closes", out);
  }
  return out;
}

std::vector<std::string> bus_notes(const Recipe& recipe, const config::Machine& machine) {
  std::vector<std::string> out;
  const std::string axes = left_to_stations(machine);
  const auto& valve = machine.outputs[static_cast<std::size_t>(config::Output::Valve)];
  for (const Material& m : recipe.materials) {
    if (valve) {
      // The output stays as it is until the station's own watchdog bites.
      const double open_s = watchdog_s(machine, valve->station);
      out.push_back(fmt::format(
          "{}: a bus that is lost on a bead costs {:.1f} mm of it ({:.6g} mm/s for {:.0f} ms), on a dot {:.1f} times "
          "its "
          "shot; the needle stands after {:.1f} mm (that watchdogs close the valve and brake the axes is assumed)",
          m.name, m.speed * open_s, m.speed, open_s * 1e3, open_s / m.dot_time, stopping_mm(machine, m.speed)));
    }
    if (!axes.empty()) {
      const double watchdog = longest_watchdog_s(machine);
      out.push_back(
          fmt::format("{}: when the program dies on a bead, {} are left to their stations, of which no manual says "
                      "that they brake: if nothing does, {:.1f} mm at {:.6g} mm/s until a watchdog of {:.0f} ms, and "
                      "{:.1f} mm in every 100 ms after it",
                      m.name, axes, m.speed * watchdog, m.speed, watchdog * 1e3, m.speed * 0.1));
    }
  }
  return out;
}

}  // namespace gantry::recipes
