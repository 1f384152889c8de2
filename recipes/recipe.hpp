// A recipe as it is written, with the location of everything in the file. Lengths in mm, angles in rad, times in s, in
// the board's frame: origin at the board's corner, X along its long edge, Z up from its nominal top face.
//   auto r = recipes::parse(text, "recipes/board.yaml");        // Checked<Recipe>: every mistake at once,
//   file:line:col
#pragma once
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "config/yaml.hpp"
#include "core/error.hpp"
#include "core/vec.hpp"

namespace gantry::recipes {

using config::Location;

/// Where the values of a board stand; line 0: it was not given.
struct BoardLocations {
  Location size, thickness, at, clamp_margin;
};

struct Board {
  Vec2 size;                ///< mm
  double thickness = 0;     ///< mm; the top face stands this far above the frame's origin
  std::string frame;        ///< work frame of the machine: "pallet"
  Vec2 at;                  ///< nominal place of the board's origin in that frame
  double clamp_margin = 0;  ///< mm kept free at the edges for the fixture (seat.cpp)
  Location frame_location{};
  BoardLocations locations{};
};

/// Something solid: a part that stands on the board's top face, or a fixture (a clamp) that stands on the pallet,
/// beside or above the board. A box, upright. A bridge is a deck and its posts.
struct Part {
  std::string name;
  Vec2 at;               ///< centre
  Vec3 size;             ///< z: its own height
  double rotation = 0;   ///< rad about Z
  bool fixture = false;  ///< stands on the pallet and does not move with the board's placement
  Location location;
  double underside = 0;  ///< of a fixture: mm over the frame's origin; 0: it stands on the pallet
  bool unread = false;   ///< something of it is a mistake, so that its values tell nothing
};

struct MarkDef {
  std::string name;
  Vec2 at;
  double diameter = 0;  ///< of the disc
  bool bright = true;   ///< brighter than the board
  Location location;
};

/// Where the values of rules stand; line 0: it was not given.
struct MarkRulesLocations {
  Location max_shift, max_rotation;
};

struct MarkRules {
  double max_residual_mm = 0.05;
  double max_shift_mm = 5;
  double max_rotation_rad = 0.05;
  int attempts = 2;
  bool symmetric_allowed = false;  ///< a board turned in its seat, or turned over, may be taken for one that is not
  MarkRulesLocations locations{};
};

struct TouchPoint {
  std::string name;
  Vec2 at;
  Location location;
};
struct TouchRules {
  double max_residual_mm = 0.1;          ///< from the plane through more than three touches
  double window_mm = 1.5;                ///< the surface must be within +- this of nominal
  std::optional<double> max_tilt_rad{};  ///< of the board; left out: surface_doubt.hpp
  Location window_location{};
};

/// Where the values of a material stand; line 0: it was not given.
struct MaterialLocations {
  Location speed, valve_open_lead, valve_close_lead, dot_time, retract, start_dwell, early_off, tail_lift, min_speed;
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
  // Within what a deposit is as it should be.
  double tolerance_mm = 0.1;        ///< beside the nominal path, and of its ends; a corner's tolerance comes on top
  double gap_tolerance_mm = 0.1;    ///< of the gap
  double speed_tolerance = 0.05;    ///< of the speed, where the bead is steady
  bool flow_follows_speed = false;  ///< the dispenser doses by the path speed: a bead at another speed is as good
  Location location{};
  double early_off = 0;         ///< mm before the end of a bead where the valve shuts
  double back_track = 0;        ///< mm back along the bead after its end, the valve shut
  double tail_lift = 0;         ///< mm that the needle rises while it goes back, or straight up where it does not
  double rejoin_within_s = 60;  ///< a bead that was cut is joined again within this since its valve shut
  double start_dwell_s = 0;     ///< at a bead's first point the needle stands so long with the valve open; then it goes
  double override_max = 1;  ///< the highest override in a job that dispenses it; that of the machine, if it is higher
  double min_speed = 0;     ///< mm/s at which a bead may begin where its whole run-up has no room; 0: from rest
  MaterialLocations locations{};
};

struct Dot {
  std::string id;  ///< "dots[3][5]" for an array's element, else its name
  Vec2 at;
  std::string material;
  Location location;
  double height_mm = 0;    ///< of what it lies on, over the board's top face
  std::string on{};        ///< the part that it lies on; empty: the board
  bool off_board = false;  ///< it may leave the board
};
struct Bead {
  std::string id;
  std::vector<Vec3> points;  ///< z over the board's top face; a closed bead repeats its first point at the end
  bool closed = false;
  double corner_tolerance = 0;  ///< mm; 0: stop in every corner
  std::string material;
  Location location;
  const char* kind = "polyline";  ///< how the recipe calls it: "arc"
  double curve_mm = 0;            ///< length of the curve that the points sample; 0: they are all there is
  std::string on{};               ///< the part that it lies on; empty: the board
  bool off_board = false;         ///< it may leave the board
};
using Feature = std::variant<Dot, Bead>;

inline const std::string& id_of(const Feature& feature) {
  return std::visit([](const auto& each) -> const std::string& { return each.id; }, feature);
}

/// How far a bead that goes up or down may leave its path: by its corner tolerance, and by no more than its gap bears.
double upright_tolerance_mm(double corner_tolerance_mm, const Material& material);

/// Length of a bead as the recipe draws it.
double length_mm(const Bead& bead);

/// A bead's points without the last `mm` of them.
std::vector<Vec3> without_end(const Bead& bead, double mm);
/// The path back along a bead.
struct Retrace {
  std::vector<Vec3> points;
  std::size_t looks = 0;  ///< at points of the bead: what it has cost
};
/// From a bead's end back along it by `back_mm`, or to its start, as a polyline that is off it by at most `off_mm`: the
/// first point is the bead's last.
Retrace retrace(const Bead& bead, double back_mm, double off_mm);

/// An area that is filled with parallel lines; each run of them is a bead.
struct Fill {
  std::string name;
  double area_mm2 = 0, spacing_mm = 0;
  std::size_t first = 0, beads = 0;  ///< in Recipe::features
  double bare_share = 0;             ///< of the area, that no line covers
  double bare_mm = 0;                ///< how far it is there from the nearest line at most ...
  Vec2 bare_at;                      ///< ... and where
  Location location{};
};

/// A file that the recipe is made of: itself, then its files of points.
struct Source {
  std::string file;
  std::size_t bytes = 0;
  std::string sha256;  ///< of its bytes
};

/// Shots beside the work, so that the first deposit is of fresh material.
struct Purge {
  std::string material;
  std::string frame;  ///< a frame of the machine; empty: on the board
  Vec3 at;            ///< on the board: z over its top face, and the gap comes on top; in a frame: of the needle's tip
  int shots = 0;
  double after_s = 0;  ///< only when the valve was shut for longer
  Location location, material_location{}, frame_location{}, at_location{};
};

/// What says where the board lies.
enum class Placement {
  Marks,
  Fixture,  ///< it lies at its nominal placement, by construction
};

/// In which order features are dispensed.
enum class Order {
  File,
  Shortest,  ///< with little travel between them
};

struct Recipe {
  std::string name;
  std::string file;
  Placement placement = Placement::Marks;
  Order order = Order::File;
  Board board;
  std::vector<Part> parts;
  std::vector<Part> keep_out{};  ///< zones, written as fixtures are: nothing of the head enters them
  std::vector<MarkDef> marks;
  MarkRules mark_rules;
  std::vector<TouchPoint> touches;
  TouchRules touch_rules;
  std::vector<Material> materials;
  std::optional<Purge> purge;
  std::vector<Feature> features;  ///< in the order of the file, arrays and fills expanded
  std::vector<Fill> fills;
  std::vector<Source> sources;
  std::vector<std::size_t> sequence{};  ///< indices of `features` in the order in which they are dispensed; with
                                        ///< `order: file` empty: as they stand
};

/// The same, whichever the order is: each feature once.
std::vector<std::size_t> sequence_of(const Recipe& recipe);

/// Gives the text of a file that a recipe names.
using ReadText = std::function<Result<std::string>(const std::string& name)>;

/// Budgets: 512 KiB of text; expanded 100000 features, and 100000 points of beads. Never throws. Fault 4xx, 505.
/// Without `beside` a recipe cannot name other files.
Checked<Recipe> parse(std::string_view yaml, std::string_view file, const ReadText& beside = {});
/// Reads a regular file and parses it; files of points lie in its folder.
Checked<Recipe> load(const std::string& path);

const Material* find_material(const Recipe& recipe, std::string_view name);

/// The highest override that all materials of its features and its purge allow; 1 is the recipe's speed.
double override_max(const Recipe& recipe);

}  // namespace gantry::recipes
