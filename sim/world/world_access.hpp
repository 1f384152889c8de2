// What a program may ask the virtual world, whether it lives in this process (SimulatedMachine) or behind a socket
// (WorldClient). It is what a person standing beside the machine could see or do: put a board in, look at what was
// dispensed, count the crashes. Control never passes through here; it passes the bus.
//   world.load_board(recipe); world.begin_job();  ... run ...  world.deposits();
#pragma once
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/axis_vec.hpp"
#include "core/error.hpp"
#include "core/steady_speed.hpp"
#include "core/vec.hpp"
#include "recipes/recipe.hpp"
#include "vision/camera.hpp"

namespace gantry::sim {

/// A needle that is farther from its bead's start stands there no longer.
inline constexpr double kSetOut_mm = 0.005;

/// How fast the needle went over the board while the valve was open, over five syncs at a time.
struct DepositSpeed {
  double asked_mm_s = 0;  ///< that of the recipe
  double least_mm_s = 0, most_mm_s = 0;
  double within_5_percent = 0;        ///< share of the length, 0..1, at the asked speed but for 5 %
  double volume_per_length = 0;       ///< from a valve with a steady flow: 1 is what the asked speed gives
  double within_tolerance = 1;        ///< share of the length, 0..1, within the material's tolerance ...
  std::optional<double> held_mm_s{};  ///< ... and of the speeds that it kept for 50 ms the one farthest off
  std::optional<Sag> sag{};           ///< where it was too slow for longer than a corner makes it
  double stood_s = 0;                 ///< over its start, from above, since its valve opened first
};

/// What lies on the board after the valve was open once. Board frame, mm; z is the height over the true surface.
inline constexpr const char* kPurgeKind = "purge";
struct Deposit {
  std::string id;                ///< of the feature it lies on by its own geometry; empty: it lies on none
  std::string kind;              ///< "dot", "bead", or "purge": a shot at the purge place, whose id is "purge" as well
  std::vector<Vec3> nominal_mm;  ///< where the recipe wants the needle
  std::vector<Vec3> board_mm;    ///< the needle while the valve was open (dot: at opening)
  /// Largest lateral distance between the two, ends and corners included; not a number where it lies on no feature.
  double error_mm = std::numeric_limits<double>::quiet_NaN();
  double gap_mm = 0;  ///< of the needle over what it lies on, farthest from the nominal gap; on no feature: at opening
  double asked_gap_mm = std::numeric_limits<double>::quiet_NaN();  ///< that of the recipe
  std::uint64_t opened_cycle = 0, closed_cycle = 0;                ///< closed 0: the valve is still open
  /// Where it was cut and joined again, one after the other: mm that are missing between the two, negative where the
  /// second lies over the first.
  std::vector<double> joins_mm{};
  std::optional<DepositSpeed> speed{};  ///< of a bead on its feature
  double open_s = 0;                    ///< how long the valve was open, in all its shots; 0: it is still open
};

/// Bodies that have met. Counted once until they have been apart again.
struct Collision {
  std::string moving, standing;
  Vec3 at;  ///< machine frame, mm
  std::uint64_t cycle = 0;
  double t_s = 0;  ///< since begin_job()
};

/// What a script has made of an input.
struct ScriptedInput {
  std::string entry;  ///< "hold.yaml:1:3: press at feature bead 1": what has changed it last; empty: nothing has
  bool more = false;  ///< an entry is left that waits for nothing but time
};

class WorldAccess {
 public:
  virtual ~WorldAccess() = default;
  virtual vision::Camera& camera() = 0;
  /// Puts a new board of this recipe into the machine; where it lies is the world's secret (placement text, else seed).
  virtual Result<void> load_board(const recipes::Recipe& recipe) = 0;
  /// A board of this very recipe lies in the machine already (the world outlives the controller): a job that resumes
  /// does not load one.
  virtual Result<bool> holds_board(const recipes::Recipe& recipe) = 0;
  /// From here on deposits and collisions are counted anew. A job that resumes does not call it.
  virtual Result<void> begin_job() = 0;
  virtual Result<std::vector<Deposit>> deposits() = 0;
  virtual Result<std::vector<Collision>> collisions() = 0;
  /// The world writes its deposits of the job to a CSV file (by its own hand, also when it is another process).
  virtual Result<void> write_deposits(const std::string& path) = 0;
  /// The hidden truth for the report: "dx=1.3 mm, dy=-0.7 mm, rot=0.8 deg, dz=0.12 mm".
  virtual Result<std::string> placement() = 0;
  /// Entries of a world script (sim/script/script.hpp), YAML.
  virtual Result<void> add_script(std::string_view yaml) = 0;
  /// Entries whose instant has not come in the job that ends, each once: "crash.yaml:3:5: lose_frames at feature dot
  /// 7". Those that wait for nothing of a job, but for a cycle or for time, count where the machine ends with it.
  enum class Machine { GoesOn, Ends };
  virtual Result<std::vector<std::string>> script_left(Machine machine) = 0;
  /// From any thread: whoever waits for an answer of this world waits no longer, and gets Fault::WorldUnreachable, as
  /// does every question until the next job's holds_board(). Of a world in this process, which answers at once,
  /// nothing.
  virtual void give_up() {}
  /// Where each axis really stands, mm or rad, as somebody sees it who looks at the machine; nothing where nobody can
  /// say (a world in another process).
  virtual std::optional<AxisVec> axes() { return std::nullopt; }
  /// `input`: a bit of the loop's input word. A world in another process says nothing.
  virtual ScriptedInput scripted_input([[maybe_unused]] unsigned input) { return {}; }
};

}  // namespace gantry::sim
