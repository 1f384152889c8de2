// What stands around the head while a job runs: the machine's own bodies, the board and its parts where they are
// believed to be, the zones that nothing enters, and how near each tool may come to what it works on.
//   Surroundings s(machine, recipe, belief);   find_path(s.scene(), from, to, s.travelling(from));
// Every pair of bodies keeps the machine's clearance, but for a pair that is named here, in a step that is named here:
//   a touch       probe and board                   touching()
//   dispensing    needle and what it dispenses on   dispensing()
//   on the way    the same two, where the last step has left a tool nearer than the clearance: it comes no nearer
// A board that is thinner than the clearance brings what it lies on near to the tool as well: that pair keeps the
// board's thickness more. Nothing else inherits anything, however low it stands.
#pragma once
#include <deque>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "app/job/job_state.hpp"
#include "config/machine.hpp"
#include "core/breath.hpp"
#include "motion/plan/find_path.hpp"
#include "motion/plan/scene.hpp"
#include "motion/types.hpp"
#include "recipes/job.hpp"
#include "recipes/surface_doubt.hpp"

namespace gantry::job {

inline constexpr const char* kBoard = "board";

/// Where the board is, and how far it may be from there.
struct Belief {
  recipes::WorkOffset offset;
  recipes::Surface surface;
  double shift_mm = 0;      ///< the board's origin may be this far off in the plane
  double rotation_rad = 0;  ///< and it may be turned about it by so much
  double upwards_mm = 0;    ///< its surface may be this much higher
  /// Touched and settled, and what the touches leave open of it.
  std::optional<recipes::SurfaceDoubt> doubt{};
};

/// What is believed before anything was measured: nominal, and off by what the recipe's rules allow.
Belief unmeasured(const recipes::Recipe& recipe);
/// What is believed with what is known: a settled offset is taken as it is, a settled surface as it is where touches
/// say so, and higher by what they leave open elsewhere.
Belief belief_of(const config::Machine& machine, const recipes::Recipe& recipe, const Knowledge& known);

/// What the needle works on: so near to a body's top, which is so high over the board's.
struct Work {
  double gap_mm = 0;
  std::string on = kBoard;
  double top_mm = 0;
  double cut_mm = 0;    ///< corners that go up or down may be cut by so much, and by half of the gap at most
  double alone_mm = 0;  ///< the needle comes and leaves straight down and up, within so much of there
};

/// Where a tool that works on the board would be lower than the board may be.
struct BelowBoard {
  std::string body;
  std::size_t segment = 0;  ///< of those that were looked at
  double by_mm = 0;
  std::string at;  ///< in words
};

class Surroundings {
 public:
  /// The machine's own bodies alone.
  explicit Surroundings(const config::Machine& machine);
  Surroundings(const config::Machine& machine, const recipes::Recipe& recipe, const Belief& belief);

  /// From here on points are told in the coordinates of that board, where it is believed to be.
  void tell_in(const config::Machine& machine, const recipes::Recipe& recipe);

  /// Every body as large as it may be by belief.
  [[nodiscard]] const motion::Scene& scene() const { return scene_; }
  /// The same while the probe goes down and up again. It goes until it meets the board, so that what rides on the board
  /// is then as far below the tool's lowest point as by drawing: it is not grown by the height that is not known. (A
  /// touch ends at the window's lower end; board and parts may differ in height by the whole window.)
  [[nodiscard]] const motion::Scene& scene_of_touch() const { return scene_of_touch_; }

  /// What the touches leave open of the surface, once it is settled.
  [[nodiscard]] const std::optional<recipes::SurfaceDoubt>& doubt() const { return belief_.doubt; }

  /// From `now` to anywhere: a tool that stands nearer than the clearance to what it works on comes no nearer.
  [[nodiscard]] motion::PathRules travelling(const AxisVec& now) const;
  /// From anywhere to anywhere, where no body is to be near to another.
  [[nodiscard]] motion::PathRules apart() const { return {.clearance_mm = clearance_mm_, .approaches = {}}; }
  /// To the point from where the probe goes down: `approach_mm` over the highest that the board may be.
  [[nodiscard]] motion::PathRules approaching(const AxisVec& now, double approach_mm) const;
  /// Down until the probe touches, up again: it may go `press_mm` below the surface as believed. For scene_of_touch().
  [[nodiscard]] motion::PathRules touching(double press_mm) const;
  /// The needle keeps its gap to what it dispenses on, and may be as near to the board under that as it then is.
  [[nodiscard]] motion::PathRules dispensing(const std::vector<Work>& works) const;
  /// Full clearance, but for bodies that stand nearer to each other now, whichever they are: they come no nearer.
  [[nodiscard]] motion::PathRules no_nearer_than(const AxisVec& now) const;

  /// The board stands among the bodies as a level box up to where its highest corner may be, and tools that work on it
  /// may be within that box. This looks at its face itself: a tool that works on it stays over it, and where it stands
  /// lower at first it goes no deeper. Nothing before the surface is settled.
  [[nodiscard]] std::optional<BelowBoard> below_board(const std::deque<motion::Segment>& segments,
                                                      const Breath& breath = {}) const;

  /// The same box lets the needle as near as the lowest corner asks for. This looks at the faces themselves: as over a
  /// level board the needle keeps its gap, but for the slack, over what it dispenses on. Fault::Collision names the
  /// body and the point. Nothing before the surface is settled.
  [[nodiscard]] Result<void> keeps_gap(std::span<const motion::Segment> segments, const Work& work) const;

 private:
  /// What is dispensed on: a rectangle in the board's plane, so high over the board's face.
  struct Face {
    Vec2 centre, size;
    double rotation_rad = 0, top_mm = 0;
  };
  /// Of a straight motion of a head body's lower end the part that is over a face which is wider by the radius, in the
  /// board's coordinates. Nothing where none is.
  [[nodiscard]] static std::optional<std::pair<Vec3, Vec3>> over(const Face& face, Vec3 from, Vec3 to,
                                                                 double radius_mm);
  /// Where it may be over the board: the least height over its face.
  [[nodiscard]] std::optional<double> least_height(Vec3 from, Vec3 to, double radius_mm) const;
  /// Over what is dispensed on.
  [[nodiscard]] static double gap_kept_mm(const Work& work);
  void add_recipe(const config::Machine& machine, const recipes::Recipe& recipe);
  /// A tool with what it works on, or with what carries that.
  [[nodiscard]] bool by_design(const std::string& head, const std::string& standing) const;
  void let_near(motion::PathRules& rules, const std::string& tool, const std::string& standing, double keeps_mm) const;
  /// Pairs that are nearer than the clearance now; `all`: whichever they are, else those by design.
  [[nodiscard]] motion::PathRules kept(const AxisVec& now, bool all) const;

  Belief belief_;
  motion::Scene scene_, scene_of_touch_;
  double clearance_mm_ = 0;
  std::string needle_, probe_;          ///< bodies of the head; empty: the tool has none
  std::set<std::string> dispensed_on_;  ///< parts
  /// The board's box reaches to where its highest corner may be; elsewhere the surface is lower by up to `uneven_mm_`,
  /// and so is a part's top than its box.
  double highest_mm_ = 0, uneven_mm_ = 0;
  std::map<std::string, Face> faces_;  ///< of the board, and of the parts that are dispensed on
  /// Bodies of the machine that the board lies on, and how far their top is below its nominal surface.
  std::vector<std::pair<std::string, double>> carriers_;
};

}  // namespace gantry::job
