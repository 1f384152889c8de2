// What lies beyond the axes wherever the board may lie, told once for each cause: a point at the point, a board that is
// too thick or too far off at the board, a retract at its material, the room that the rules leave at the rules.
//   Reach reach(recipe, machine, mistakes);
//   reach.look({.tool = "needle", .tip = tip, .lift = 3, .around = 5, .location = dot.location, .what = "dot 'a'"});
//   reach.tell();
#pragma once
#include <functional>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "config/machine.hpp"
#include "config/yaml.hpp"
#include "recipes/recipe.hpp"

namespace gantry::recipes {

class Reach {
 public:
  /// A tool's tip at a point of the machine frame, and how far it leaves that.
  struct Ask {
    std::string_view tool;
    Vec3 tip;            ///< where it works with everything in its nominal place
    double lift = 0;     ///< mm that it goes up from there
    double window = 0;   ///< mm up and down that the surface may be off
    double around = 0;   ///< mm to every side that the board may be off
    double by_turn = 0;  ///< mm of `around` that its rotation makes
    Location location;
    std::string what;
    const Material* material = nullptr;  ///< whose `retract` the lift is; null: it is none
    bool by_tail = false;                ///< it is its `tail_lift`
    bool on_board = true;                ///< it goes where the board goes
  };

  /// All outlive it.
  Reach(const Recipe& recipe, const config::Machine& machine, config::Mistakes& mistakes)
      : recipe_(recipe), machine_(machine), mistakes_(mistakes) {}

  /// False: it is out of reach, which tell() tells. A tool that the machine lacks is told elsewhere.
  bool look(Ask ask);
  void tell();

 private:
  enum class Cause { Point, Lift, Window, Around };
  struct Miss {
    Ask ask;
    Cause cause = Cause::Point;
    AxisId axis;
    double least = 0, most = 0;  ///< of that axis
  };

  [[nodiscard]] std::string needs(const Miss& miss) const;
  void tell_points();
  void tell_each(std::set<std::pair<int, int>>& told, const std::function<bool(const Miss&)>& which);
  /// Of a tool, or of all: "". True: most of its points are out of reach, and that is told.
  bool tell_of_most(std::string_view tool);
  void tell_lifts();
  void tell_rules(Cause cause);
  [[nodiscard]] Location rules_location(const Miss& miss) const;

  const Recipe& recipe_;
  const config::Machine& machine_;
  config::Mistakes& mistakes_;
  std::vector<Miss> misses_;
  std::map<std::string_view, std::size_t> looked_;  ///< by tool: at what goes where the board goes
};

}  // namespace gantry::recipes
