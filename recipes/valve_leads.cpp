#include "recipes/valve_leads.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <set>

#include "motion/profile/planner.hpp"

namespace gantry::recipes {
namespace {

motion::Bounds bounds(const config::Axis& axis) { return {axis.v_max, axis.a_max, axis.j_max}; }

/// Down from the retract height to the gap, from rest to rest.
double descent_s(const config::Machine& machine, const Material& m) {
  if (m.retract <= 0) return 0;
  return motion::duration(motion::move({0, 0, 0}, {m.retract, 0, 0}, bounds(machine.axes[machine.z.value])).profile);
}

/// From rest to the material's speed along the first leg of a bead; none where the needle stands at its start. A speed
/// beyond the axes is told elsewhere.
double run_up_s(const config::Machine& machine, const Material& m, const Bead& bead) {
  if (m.start_dwell_s > 0) return 0;
  const Vec3 leg = bead.points[1] - bead.points[0];
  const Vec3 direction = leg * (1 / std::max(norm(leg), 1e-9));
  motion::Bounds along{m.speed, 1e9, 1e9};
  for (const auto& [part, id] :
       {std::pair{direction.x, machine.x}, {direction.y, machine.y}, {direction.z, machine.z}}) {
    if (std::abs(part) < 1e-9) continue;
    const motion::Bounds axis = bounds(machine.axes[id.value]);
    along.a = std::min(along.a, axis.a / std::abs(part));
    along.j = std::min(along.j, axis.j / std::abs(part));
  }
  return motion::duration(motion::change_speed({0, 0, 0}, m.speed, along).profile);
}

/// How long the last stretch to a feature takes (the descent, then the wait or the run-up), and how long the valve is
/// to be open on the feature. A bead takes whole cycles; where `early_off` shuts the valve is not bound to them.
struct Times {
  double last_stretch_s = 0, open_s = 0;
  const char* more_room = "";
};
Times times(const config::Machine& machine, const Material& m, const Dot&) {
  return {descent_s(machine, m) + m.settle_time, m.dot_time, "'settle_time' or 'retract'"};
}
Times times(const config::Machine& machine, const Material& m, const Bead& bead) {
  return {descent_s(machine, m) + run_up_s(machine, m, bead),
          std::max(seconds(machine.bus.cycle), m.start_dwell_s + (length_mm(bead) - m.early_off) / m.speed),
          "'retract'"};
}

constexpr double kRounding_s = 1e-9;

Location given(Location written, Location otherwise) { return written.line > 0 ? written : otherwise; }

/// The valve is switched, and the needle sent on, once in a cycle.
void check_cycles(const Material& m, double cycle_s, config::Mistakes& mistakes) {
  const auto judge = [&](const char* key, double value_s, Location where, const char* otherwise) {
    if (value_s >= cycle_s - kRounding_s) return;
    mistakes.add(
        Fault::Inconsistent,
        fmt::format("material '{}': '{}' of {:.6g} ms is less than a cycle of the machine, and nothing that is "
                    "dispensed takes less; write {:.6g} ms or more{}",
                    m.name, key, value_s * 1e3, cycle_s * 1e3, otherwise),
        given(where, m.location));
  };
  judge("dot_time", m.dot_time, m.locations.dot_time, "");
  if (m.start_dwell_s > 0) judge("start_dwell", m.start_dwell_s, m.locations.start_dwell, ", or leave it out");
}

/// Of a bead `early_off` leaves nothing, or what the needle goes in less than a cycle of the machine, in which the
/// valve may not open at all. Where it is open before, in `start_dwell`, anything will do.
bool leaves_too_little(const Material& m, const Bead& bead, double cycle_s) {
  const double least_mm = m.early_off > 0 && m.start_dwell_s <= 0 ? (cycle_s - kRounding_s) * m.speed : 0;
  return length_mm(bead) - m.early_off <= least_mm;
}

}  // namespace

void check_valve_leads(const Recipe& recipe, const config::Machine& machine, config::Mistakes& mistakes) {
  const double cycle_s = seconds(machine.bus.cycle);
  for (const Material& m : recipe.materials) check_cycles(m, cycle_s, mistakes);
  std::set<std::string_view> early_off_told;
  std::set<std::pair<std::string_view, bool>> told;  // material, and whether the lead is the opening one
  const auto judge = [&](const auto& feature) {
    const Material* m = find_material(recipe, feature.material);
    if (m == nullptr) return;
    if constexpr (std::is_same_v<std::decay_t<decltype(feature)>, Bead>)
      if (leaves_too_little(*m, feature, cycle_s)) {
        if (early_off_told.insert(m->name).second)
          mistakes.add(Fault::Inconsistent,
                       fmt::format("'early_off' of material '{}' is {:.6g} mm, and '{}' is only {:.6g} mm long: the "
                                   "valve would not open on it, or for less than a cycle of the machine; write less, "
                                   "make the bead longer, or use another material",
                                   m->name, m->early_off, feature.id, length_mm(feature)),
                       given(m->locations.early_off, feature.location));
        return;
      }
    const Times t = times(machine, *m, feature);
    if (m->valve_open_lead > t.last_stretch_s && told.insert({m->name, true}).second)
      mistakes.add(Fault::NoSolution,
                   fmt::format("material '{}': 'valve_open_lead' of {:.6g} ms opens the valve before the needle is on "
                               "the last stretch to '{}'; write {:.6g} ms or less, or more {}",
                               m->name, m->valve_open_lead * 1e3, feature.id,
                               std::floor(t.last_stretch_s * 1e3 * 10) / 10, t.more_room),
                   given(m->locations.valve_open_lead, m->location));
    // One that shuts what is below a cycle already has its mistake.
    if (t.open_s >= cycle_s - kRounding_s &&
        m->valve_close_lead > m->valve_open_lead + t.open_s - cycle_s + kRounding_s &&
        told.insert({m->name, false}).second)
      mistakes.add(
          Fault::Inconsistent,
          fmt::format("material '{}': 'valve_close_lead' of {:.6g} ms closes the valve before it has been open for a "
                      "cycle of the machine on '{}', which takes {:.6g} ms; write {:.6g} ms or less, or a longer "
                      "'valve_open_lead'",
                      m->name, m->valve_close_lead * 1e3, feature.id, t.open_s * 1e3,
                      std::max(0.0, m->valve_open_lead + t.open_s - cycle_s) * 1e3),
          given(m->locations.valve_close_lead, m->location));
  };
  if (recipe.purge)
    judge(Dot{.id = "purge", .at = {}, .material = recipe.purge->material, .location = recipe.purge->location});
  for (const Feature& feature : recipe.features) std::visit(judge, feature);
}

double dot_time_tolerance_s(const Material& m, double cycle_s) {
  constexpr double kRounding_s = 1e-6;
  const auto in_cycles = [&](double s) { return std::abs(s / cycle_s - std::round(s / cycle_s)) < 1e-6; };
  const bool whole = in_cycles(m.dot_time) && in_cycles(m.valve_open_lead) && in_cycles(m.valve_close_lead);
  return m.speed_tolerance * m.dot_time + (whole ? kRounding_s : cycle_s);
}

}  // namespace gantry::recipes
