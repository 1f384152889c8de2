// The board that truly lies in the machine: its CAD from the recipe, and where it lies, which nobody above the bus and
// the camera may know.
//   BoardTruth board(board_plan(recipe), frame_origin, draw_placement(config.sim, seed, 0, text));
//   board.to_machine({10, 20}, 0.3);   board.to_board(needle_tip);
// Board frame: origin at the board's corner, z = height over the true top face. The placement turns counter-clockwise
// about the origin, then shifts; the top face is a plane over the board's own coordinates, tilted by so little that its
// cosine is taken as 1 (1 mrad: 0.06 um over 120 mm).
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "config/machine.hpp"
#include "core/error.hpp"
#include "core/vec.hpp"
#include "recipes/recipe.hpp"
#include "sim/world/starts.hpp"

namespace gantry::sim {

/// Where the board truly lies, against its nominal placement.
struct BoardPlacement {
  Vec2 shift;
  double rotation_rad = 0;
  double z0_mm = 0;  ///< top face over nominal at the board's origin
  Vec2 slope;        ///< of the top face over board coordinates
};

/// "dx=1.3 mm, dy=-0.7 mm, rot=0.8 deg"; parts that are missing are 0. Also dz, tilt_x, tilt_y for tests of the
/// surface; these stay absent when the text does not name them. Fault 402, 404, 405, 406; where: "--sim-board:1:COL".
struct PlacementText {
  Vec2 shift;
  double rotation_rad = 0;
  std::optional<double> z0_mm, slope_x, slope_y;
};
Result<PlacementText> parse_placement(std::string_view text);

/// Draws board number `board` of this seed: height and tilt always, shift and rotation unless it is in a fixture or
/// `text` says them.
BoardPlacement draw_placement(const config::SimConfig& truth, std::uint64_t seed, std::uint64_t board,
                              const std::optional<PlacementText>& text, bool in_fixture = false);
/// The form that parse_placement reads; of a text, what it names.
std::string to_text(const BoardPlacement& placement);
std::string to_text(const PlacementText& text);

/// What a recipe says that exists physically, or ought to after dispensing.
struct BoardPlan {
  struct Feature {
    std::string id;
    bool bead = false;
    std::vector<Vec3> points;  ///< of the bead itself: z over the top face
    double gap_mm = 0;         ///< of the needle over them
    double speed_mm_s = 0;     ///< of a bead; 0: not known
    double speed_tolerance = recipes::Material{}.speed_tolerance;
  };
  std::string name;
  recipes::Board board;
  std::vector<recipes::Part> parts;
  std::vector<recipes::MarkDef> marks;
  std::vector<Feature> features;
  std::size_t touches = 0;  ///< how often a job probes it
  std::optional<recipes::Purge> purge;
  bool in_fixture = false;  ///< it lies at its nominal place, its height and tilt aside
};
BoardPlan board_plan(const recipes::Recipe& recipe);
/// Where its features begin.
Starts starts_of(const BoardPlan& plan);

/// Dirt on the board that the camera sees.
struct Stain {
  Vec2 at;
  double diameter = 0;
  double grey = 30;
};

class BoardTruth {
 public:
  BoardTruth() = default;
  /// `frame_origin`: of the work frame that the board names.
  BoardTruth(BoardPlan plan, Vec3 frame_origin, const BoardPlacement& placement);

  [[nodiscard]] Vec3 to_machine(Vec2 p, double height) const;
  /// Nominal transform: what stands on the pallet (fixtures) does not move with the board.
  [[nodiscard]] Vec3 nominal_to_machine(Vec2 p, double height) const;
  /// z: height over the true top face, which is taken as going on beyond the board's edge.
  [[nodiscard]] Vec3 to_board(Vec3 machine) const;
  [[nodiscard]] double rotation() const { return placement_.rotation_rad; }
  [[nodiscard]] bool on_board(Vec2 p) const {
    return p.x >= 0 && p.y >= 0 && p.x <= plan.board.size.x && p.y <= plan.board.size.y;
  }
  [[nodiscard]] const BoardPlacement& placement() const { return placement_; }
  [[nodiscard]] Vec3 frame_origin() const { return origin_; }
  [[nodiscard]] const Starts& starts() const { return starts_; }

  BoardPlan plan;  ///< scripts may take marks away or move them
  std::vector<Stain> stains;

 private:
  Vec3 origin_;   ///< of the work frame
  Vec3 nominal_;  ///< nominal place of the board's origin, at its top face
  BoardPlacement placement_;
  Starts starts_;  ///< features stay as they are
  double cos_ = 1, sin_ = 0;
};

}  // namespace gantry::sim
