// What the head carries: whether its tools are there, whether a body that the proofs know ends where a tool works, and
// whether probe and camera can do what is asked of them.
#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <set>

#include "config/machine_file.hpp"
#include "config/upright.hpp"
#include "core/axis_vec.hpp"

namespace gantry::config {
namespace {

using written::MachineFile;
using written::ToolRow;

constexpr double kLeastSlack_mm = 0.1;  // of a tip and the end of its body, where nothing is kept clear

/// How far a tool's working point is from the lower end of a body.
double from_end(const Body& body, const Vec3& tip) {
  const double bottom = body.centre.z - body.shape.size.z / 2;
  const double beside_x = std::max(0.0, std::abs(tip.x - body.centre.x) - body.shape.size.x / 2),
               beside_y = std::max(0.0, std::abs(tip.y - body.centre.y) - body.shape.size.y / 2);
  return std::hypot(beside_x, beside_y, tip.z - bottom);
}

/// What touches or nearly touches the board must be known to the proofs: one that keeps every body clear knows nothing
/// of a tip that stands out of all of them.
void check_tip(const Machine& m, const ToolRow& row, Mistakes& mistakes) {
  const double slack = std::max(m.clearance_mm, kLeastSlack_mm);
  const Body* nearest = nullptr;
  for (const Body& body : m.head)
    if (nearest == nullptr || from_end(body, row.tip) < from_end(*nearest, row.tip)) nearest = &body;
  if (nearest == nullptr) return;
  if (const double off = from_end(*nearest, row.tip); off > slack)
    mistakes.add(Fault::Inconsistent,
                 fmt::format("the tip of '{}' is {:.4g} mm from the lower end of the nearest body of the head ('{}'), "
                             "more than the {:.4g} mm that are kept clear: no proof would know of it; give it a body "
                             "under head: bodies: that ends at its tip, or correct one of the two",
                             row.name, off, nearest->name, slack),
                 row.location);
  else if (row.lift_mm.value > 0 && !nearest->on_lift)
    mistakes.add(
        Fault::Inconsistent,
        fmt::format("'{}' works with the lift down, and its body '{}' does not ride on it; write on_lift: true "
                    "there, or leave `lift` out",
                    row.name, nearest->name),
        row.lift_mm.location);
}

void check_probe(const Machine& m, const MachineFile& file, Mistakes& mistakes) {
  const Axis& z = m.axes[m.z.value];
  const StationProfile& probe = m.stations[m.axes[m.probe.axis.value].drives.front().station.value].profile;
  if (m.probe.axis != m.z && z.kind == AxisKind::Streamed)
    mistakes.add(
        Fault::Inconsistent,
        fmt::format("a touch goes down by axis {}, so that its drive must latch; write axis: {}", z.name, z.name),
        file.probe.axis.location);
  else if (!find_object(probe, {0x60B8, 0}))
    mistakes.add(Fault::Inconsistent, fmt::format("{} has no probe input (60B8h)", probe.title),
                 file.probe.axis.location);
  if (m.probe.travel_mm <= m.probe.approach_mm)
    mistakes.add(
        Fault::Inconsistent,
        fmt::format("gives up after {:.6g} mm, and the surface is {:.6g} mm below where it begins (`approach`); "
                    "write more",
                    m.probe.travel_mm, m.probe.approach_mm),
        file.probe.travel_mm.location);
  if (m.probe.fast_mm_s > 0 && m.probe.fast_mm_s <= m.probe.speed_mm_s)
    mistakes.add(Fault::Inconsistent,
                 fmt::format("the first touch at {:.6g} mm/s is not faster than the one that counts, at {:.6g} mm/s "
                             "(`speed`); write more, or leave it out",
                             m.probe.fast_mm_s, m.probe.speed_mm_s),
                 file.probe.fast_mm_s.location);
  for (const auto* at : {&file.probe.speed_mm_s, &file.probe.fast_mm_s})
    if (at->given() && at->value > z.v_max)
      mistakes.add(Fault::OutOfRange,
                   fmt::format("more than v_max of axis {}, {:.6g} mm/s; write that or less", z.name, z.v_max),
                   at->location);
}

/// The axes stand still until the answer: an exposure that is not over by then has none.
void check_camera(const Machine& m, const MachineFile& file, Mistakes& mistakes) {
  if (m.camera.exposure_s >= m.camera.answer_latency_s)
    mistakes.add(
        Fault::Inconsistent,
        fmt::format("camera: an exposure of {:.6g} ms is not over when its answer takes effect, {:.6g} ms after "
                    "the trigger (`answer_latency`); write a shorter `exposure`, or a longer `answer_latency`",
                    m.camera.exposure_s * 1e3, m.camera.answer_latency_s * 1e3),
        file.camera_location);
}

/// What would never turn would be proved, and drawn, as if it stood.
void check_turn(const Machine& m, const MachineFile& file, Mistakes& mistakes) {
  if (m.c) return;
  for (const auto& row : file.head.bodies)
    if (row.on_turn)
      mistakes.add(Fault::Inconsistent,
                   fmt::format("'{}' is to turn, and no axis has the role `turn`; give it to one (roles: turn), or "
                               "leave `on_turn` out",
                               row.name),
                   row.on_turn_location);
}

/// Somewhere the axes rest; of an axis that is left out it is not known where it stands.
using Rest = std::vector<std::pair<AxisId, double>>;

/// The head's bodies there; without those of which that is not known.
std::vector<Body> head_at(const Machine& m, const Rest& rest) {
  AxisVec at{};
  for (const auto& [axis, position] : rest) at[axis.value] = position;
  const auto known = [&](std::optional<AxisId> id) {
    return !id || std::ranges::any_of(rest, [&](const auto& each) { return each.first == *id; });
  };
  std::vector<Body> out;
  if (!known(m.x) || !known(m.y) || !known(m.z)) return out;
  for (Body body : m.head) {
    if ((body.on_turn && !known(m.c)) || (body.on_lift && !known(m.u))) continue;
    if (body.on_turn && m.c) {
      const Vec2 axis = turn_axis(m), centre = axis + rotated(flat(body.centre) - axis, at[m.c->value]);
      body.centre = {centre.x, centre.y, body.centre.z};
      body.rotation_rad += at[m.c->value];
    }
    const double down_mm = body.on_lift && m.u ? at[m.u->value] : 0;
    body.centre = body.centre + Vec3{at[m.x.value], at[m.y.value], at[m.z.value] - down_mm};
    out.push_back(std::move(body));
  }
  return out;
}

struct Near {
  std::string head, standing;
  bool zone = false;
  std::size_t row = 0;  ///< of scene, or of keep_out
  double distance_mm = 0;
};
/// On every path: the clearance, and what the axes may be off it.
double kept_clear_mm(const Machine& m) {
  AxisVec off{};
  for (const Axis& axis : m.axes) off[axis.id.value] = axis.path_error;
  return m.clearance_mm + std::hypot(off[m.x.value], off[m.y.value], off[m.z.value] + (m.u ? off[m.u->value] : 0));
}
/// The nearest pair of those that stand nearer to each other than is kept clear.
std::optional<Near> too_near(const Machine& m, const Rest& rest) {
  std::optional<Near> nearest;
  const double kept_mm = kept_clear_mm(m);
  for (const Body& body : head_at(m, rest))
    for (const std::vector<Body>* bodies : {&m.scene, &m.keep_out})
      for (std::size_t i = 0; i < bodies->size(); ++i) {
        const double apart_mm = distance_mm(body, (*bodies)[i]);
        if (apart_mm >= (nearest ? nearest->distance_mm : kept_mm) && (nearest || apart_mm > 0)) continue;
        nearest = Near{body.name, (*bodies)[i].name, bodies == &m.keep_out, i, apart_mm};
      }
  return nearest;
}
std::string in_words(const Machine& m, const Near& near) {
  const char* of = near.zone ? "of the machine" : "of the scene";
  return near.distance_mm == 0
             ? fmt::format("the head's body '{}' is in '{}' {}", near.head, near.standing, of)
             : fmt::format("the head's body '{}' is {:.4g} mm from '{}' {}, and {:.4g} mm are kept clear", near.head,
                           near.distance_mm, near.standing, of, kept_clear_mm(m));
}

/// Where a job ends, bodies of the head may not stand in or beside those of the scene, nor in a zone to keep out of: it
/// could not end there, and no other begin. An axis that is not parked ends wherever the job has left it.
void check_park(const Machine& m, const MachineFile& file, Mistakes& mistakes) {
  if (const auto near = too_near(m, m.park))
    mistakes.add(Fault::Inconsistent,
                 fmt::format("park: there {}; write another position, or correct that body", in_words(m, *near)),
                 file.park.front().location);
}

/// Nor where homing ends: no job could begin there. Methods 35 and 37 leave an axis where it is.
void check_homing_end(const Machine& m, const MachineFile& file, Mistakes& mistakes) {
  Rest rest;
  for (const Axis& axis : m.axes)
    if (axis.homing && axis.kind == AxisKind::Streamed && axis.homing->method != 35 && axis.homing->method != 37)
      rest.emplace_back(axis.id, axis.homing->position);
  const auto near = too_near(m, rest);
  if (!near) return;
  mistakes.add(Fault::Inconsistent,
               fmt::format("where homing ends {}: no job could begin there; move it or make it smaller, or state "
                           "another `position` of the home edge",
                           in_words(m, *near)),
               (near->zone ? file.keep_out : file.scene)[near->row].location);
}

}  // namespace

void check_head(const Machine& m, const MachineFile& file, Mistakes& mistakes) {
  for (const std::string_view needed : {"needle", "camera", "probe"})
    if (!find_tool(m, needed))
      mistakes.add(Fault::MissingKey, fmt::format("tool '{}' is missing under head: tools:", needed),
                   file.head.tools.front().location);
  for (const auto& row : file.head.tools) {
    if (row.name != "camera") check_tip(m, row, mistakes);  // the camera's is a point in focus
    if (!row.lift_mm.given()) continue;
    if (!m.u) {
      mistakes.add(Fault::Inconsistent, "no axis has the role `lift`", row.lift_mm.location);
    } else if (const Axis& u = m.axes[m.u->value]; row.lift_mm.value < u.p_min || row.lift_mm.value > u.p_max) {
      mistakes.add(Fault::OutOfRange, outside_of(u), row.lift_mm.location);
    }
  }
  std::set<std::string> names;
  for (const auto& row : file.head.bodies) names.insert(row.name);
  for (const auto& row : file.scene)
    if (names.count(row.name))
      mistakes.add(Fault::DuplicateKey, fmt::format("the head has a body '{}' too; messages name bodies", row.name),
                   row.location);
  check_probe(m, file, mistakes);
  check_camera(m, file, mistakes);
  check_turn(m, file, mistakes);
  check_park(m, file, mistakes);
  check_homing_end(m, file, mistakes);
}

std::vector<std::string> head_notes(const Machine& m) {
  std::vector<std::string> out;
  const auto presses_in = [&](std::string_view key, double speed_mm_s, std::string_view remedy) {
    if (speed_mm_s > kVirtualProbeBears_mm_s)
      out.push_back(
          fmt::format("warning: probe: {} is {:.6g} mm/s, and the probe is pressed in for 25 ms and a stop "
                      "({:.2g} mm); the virtual one bears {:.6g} mm/s. {}",
                      key, speed_mm_s, speed_mm_s * 0.025 + speed_mm_s * speed_mm_s / (2 * m.axes[m.z.value].a_max),
                      kVirtualProbeBears_mm_s, remedy));
  };
  presses_in("speed", m.probe.speed_mm_s, "State a slow one, and `fast` for a first touch");
  presses_in("fast", m.probe.fast_mm_s, "Write that or less, or what the probe's maker allows");
  const double half_mm = std::min(m.camera.width_px, m.camera.height_px) * m.camera.mm_per_px / 2;
  if (m.camera.search_mm > half_mm)
    out.push_back(
        fmt::format("warning: camera: search looks {:.4g} mm far, and half of the image is {:.4g} mm: a mark "
                    "farther off is not in it",
                    m.camera.search_mm, half_mm));
  return out;
}

}  // namespace gantry::config
