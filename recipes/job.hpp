// What a recipe means on a machine: blocks, each of which ends where the world must answer (an image, a probe touch) or
// where the job ends. Points stay in the board's frame until a block is planned: then to_machine() puts them into the
// machine frame, with the offset and the surface that are known by then.
//   auto job = recipes::compile(recipe, machine);                                      // Checked<Job>
//   Vec3 tip = recipes::to_machine(recipe, machine, offset, surface, dot.at, gap_mm);
#pragma once
#include <array>
#include <string>
#include <variant>
#include <vector>

#include "config/machine.hpp"
#include "core/axis_vec.hpp"
#include "core/error.hpp"
#include "core/vec.hpp"
#include "recipes/recipe.hpp"

namespace gantry::recipes {

/// Rigid placement of the board in its frame: a point p of the board lies at rotated(p, rotation) + shift + the
/// board's nominal position.
struct WorkOffset {
  Vec2 shift;
  double rotation = 0;
  bool operator==(const WorkOffset&) const = default;
};

/// Top face of the board over the board's frame: z = z0 + slope . p, mm above its nominal height.
struct Surface {
  double z0 = 0;
  Vec2 slope;
  [[nodiscard]] double at(Vec2 p) const { return z0 + dot(slope, p); }
  bool operator==(const Surface&) const = default;
};

struct LookAtMark {
  std::size_t mark = 0;  ///< index in Recipe::marks
  bool operator==(const LookAtMark&) const = default;
};
struct Touch {
  std::size_t touch = 0;  ///< index in Recipe::touches
  bool operator==(const Touch&) const = default;
};
/// Shots at the recipe's purge place, if the valve was shut for long enough.
struct PurgeNeedle {
  bool operator==(const PurgeNeedle&) const = default;
};
struct Dispense {
  std::vector<std::size_t> features;  ///< indices in Recipe::features, in the order in which they are dispensed
  bool operator==(const Dispense&) const = default;
};
struct Park {
  bool operator==(const Park&) const = default;
};
struct Block {
  std::uint32_t number = 0;  ///< from 1
  std::variant<LookAtMark, Touch, PurgeNeedle, Dispense, Park> what;
};
struct Job {
  std::vector<Block> blocks;
};

/// The features that a job dispenses: indices in Recipe::features, in the order in which it does.
std::vector<std::size_t> dispensed_by(const Job& job);

/// Marks come first, then touches on the placed board, then what needs both.
inline bool needs_offset(const Block& block) { return !std::holds_alternative<LookAtMark>(block.what); }
inline bool needs_surface(const Block& block) {
  return needs_offset(block) && !std::holds_alternative<Touch>(block.what);
}

/// Checks a recipe against a machine (frames, reach at nominal placement with the rules' margins, speeds, tools, marks)
/// and cuts it into blocks: one a mark, one a touch, one to purge, one for all features, one to park. Every mistake
/// with its location in the recipe. Fault 4xx, 5xx.
Checked<Job> compile(const Recipe& recipe, const config::Machine& machine);

struct Compiled {
  Recipe recipe;
  Job job;
};
/// A file, read and compiled: of a recipe with mistakes also what the machine lacks for it, all at once.
Checked<Compiled> load_for(const std::string& path, const config::Machine& machine);

/// What the loss of the bus costs at the speeds of this recipe, and valve leads that the virtual valve does not have;
/// for `check`.
std::vector<std::string> notes(const Recipe& recipe, const config::Machine& machine);

/// A point where a tool's tip shall be, in the machine frame, with the posture of the other axes.
/// Gives the axis vector (X Y Z C U, others 0 or their park value).
AxisVec tool_at(const config::Machine& machine, const config::Tool& tool, Vec3 tip, double needle_turn_rad);

/// Board point -> machine frame, z = height above the (offset) surface.
Vec3 to_machine(const Recipe& recipe, const config::Machine& machine, const WorkOffset& offset, const Surface& surface,
                Vec2 at, double height_mm);

/// Where the needle's tip shoots when it purges, machine frame. A frame that the machine lacks counts as its origin.
Vec3 purge_tip(const Recipe& recipe, const config::Machine& machine, const WorkOffset& offset, const Surface& surface);

/// The board ("board", from the frame's origin to its top face), its parts and its fixtures as bodies of the machine
/// frame, with the board placed by `offset`; fixtures stay where they are.
std::vector<config::Body> bodies(const Recipe& recipe, const config::Machine& machine, const WorkOffset& offset,
                                 const Surface& surface);
/// The recipe's zones to keep out of as bodies of the machine frame. They stay where they are.
std::vector<config::Body> zones(const Recipe& recipe, const config::Machine& machine);

}  // namespace gantry::recipes
