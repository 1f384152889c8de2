// A scene alone, without machine and recipe: a document in YAML or JSON, lengths in mm and angles in deg as bare
// numbers; world X right, Y back, Z up. Bodies of the head stand about its tip; the axes X, Y and Z carry the tip.
//   workspace_tip: {min: [0, 0, 0], max: [400, 300, 90]}
//   required_clearance_mm: 0.5
//   head:      [{name: needle, type: capsule, center: [0, 0, 10], radius: 0.2, length: 19}]
//   obstacles: [{name: block, type: box, center: [200, 150, 10], size: [40, 30, 20], yaw_deg: 15}]
// Types: box (size), cylinder (radius, length; axis Z), capsule (radius, length between the centres of its spheres;
// axis Z), sphere (radius). A body of the head with `on_turn: true` turns with C about the upright line through the
// tip; then `turn_deg: [min, max]` is the range of C, else -180 to 180. `keep_out` lists zones that the head must not
// enter; they are bodies as the others.
#pragma once
#include <string>
#include <string_view>

#include "config/machine.hpp"

namespace gantry::motion {

/// As a machine of X, Y, Z and, where a body turns, C (the fourth; rad), without drives, for Scene. `name`: of the
/// text, for mistakes. Every mistake at once with its location; Fault 4xx.
Checked<config::Machine> parse_scene(std::string_view text, const std::string& name);
Checked<config::Machine> load_scene(const std::string& path);

}  // namespace gantry::motion
