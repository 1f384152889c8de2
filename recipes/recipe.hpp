// A recipe as it is written, with the place of everything in the file. Lengths in mm, angles in rad, times in s, in the
// board's frame: origin at the board's corner, X along its long edge, Z up from its nominal top face.
//   auto r = recipes::parse(text, "recipes/board.yaml");        // Checked<Recipe>: every mistake at once,
//   file:line:col
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "config/yaml.hpp"
#include "core/error.hpp"
#include "core/vec.hpp"

namespace gantry::recipes {

using config::Place;

struct Board {
  Vec2 size;                ///< mm
  double thickness = 0;     ///< mm; the top face stands this far above the frame's origin
  std::string frame;        ///< work frame of the machine: "pallet"
  Vec2 at;                  ///< nominal place of the board's origin in that frame
  double clamp_margin = 0;  ///< mm kept free at the edges by the fixture; informational
  Place frame_place{};
};

/// Something solid: a part that stands on the board's top face, or a fixture (a clamp) that stands on the pallet,
/// beside or above the board. A box, upright.
struct Part {
  std::string name;
  Vec2 at;               ///< centre
  Vec3 size;             ///< z: height over the board's top face; of a fixture: over the frame's origin
  double rotation = 0;   ///< rad about Z
  bool fixture = false;  ///< stands on the pallet and does not move with the board's placement
  Place place;
};

struct MarkDef {
  std::string name;
  Vec2 at;
  double diameter = 0;  ///< of the disc
  bool bright = true;   ///< brighter than the board
  Place place;
};

struct MarkRules {
  double max_residual_mm = 0.05;
  double max_shift_mm = 5;
  double max_rotation_rad = 0.05;
  int attempts = 2;
};

struct TouchPoint {
  std::string name;
  Vec2 at;
  Place place;
};
struct TouchRules {
  double max_residual_mm = 0.1;  ///< from the plane through more than three touches
  double window_mm = 1.5;        ///< the surface must be within +- this of nominal
};

struct Material {
  std::string name;
  double speed = 0;            ///< mm/s on the bead
  double gap = 0;              ///< mm between needle and surface
  double valve_open_lead = 0;  ///< s that the valve is commanded before the needle is there
  double valve_close_lead = 0;
  double dot_time = 0;     ///< s that the valve is open on a dot
  double settle_time = 0;  ///< s of standstill before a dot
  double retract = 0;      ///< mm that the needle lifts after a feature
  Place place;
};

struct Dot {
  std::string id;  ///< "dots[3][5]" for an array's element, else its name
  Vec2 at;
  std::string material;
  Place place;
};
struct Bead {
  std::string id;
  std::vector<Vec2> points;  ///< a closed bead repeats its first point at the end
  bool closed = false;
  double corner_tolerance = 0;  ///< mm; 0: stop in every corner
  std::string material;
  Place place;
};
using Feature = std::variant<Dot, Bead>;

struct Recipe {
  std::string name;
  std::string file;
  Board board;
  std::vector<Part> parts;
  std::vector<MarkDef> marks;
  MarkRules mark_rules;
  std::vector<TouchPoint> touches;
  TouchRules touch_rules;
  std::vector<Material> materials;
  std::vector<Feature> features;  ///< in the order of the file, arrays expanded
};

/// Budgets before expansion: 256 KiB of text, 100000 features. Never throws. Fault 4xx, 505.
Checked<Recipe> parse(std::string_view yaml, std::string_view file);
/// Reads a regular file and parses it.
Checked<Recipe> load(const std::string& path);

const Material* find_material(const Recipe& recipe, std::string_view name);

}  // namespace gantry::recipes
