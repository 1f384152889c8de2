// Whether beads were dispensed at their speed: what the loop shows in every cycle, against the plan at the same
// position of the path. A hold closes the valve, which is FeatureWatch's to see; an override does not, and neither does
// a path that runs low.
//   SpeedWatch watch(recipe, tick_s);
//   watch.begin(block.segments());   each snapshot: watch.see({...});   watch.end();
//   for (const OffSpeed& each : watch.off_speed()) ...
// Only where the plan itself is steady: in ramps and at corners a small shift in position is a large one in speed. A
// plan that stands in mid bead, though corners may be rounded, is told whatever becomes of it.
#pragma once
#include <cstdint>
#include <deque>
#include <optional>
#include <vector>

#include "motion/types.hpp"
#include "recipes/recipe.hpp"

namespace gantry::job {

/// One cycle of a block.
struct SpeedCycle {
  std::uint32_t feature = motion::kTravel;
  bool valve_open = false;
  double path_speed_mm_s = 0;
};

/// A bead that left its speed while it was dispensed.
struct OffSpeed {
  std::uint32_t feature = 0;  ///< index in Recipe::features
  double asked_mm_s = 0;
  double worst_mm_s = 0;
  double length_mm = 0;  ///< of the bead, in all
  double due_mm = 0;     ///< what it should have been in that time, where that is more
  /// How often it has stood in mid bead by plan, where nothing in the recipe asks for it, and how far from where its
  /// valve opens first.
  std::size_t stands = 0;
  double stands_at_mm = 0;
};

class SpeedWatch {
 public:
  /// `recipe` outlives it.
  SpeedWatch(const recipes::Recipe& recipe, double tick_s) : recipe_(recipe), tick_s_(tick_s) {}

  /// What plays from now on; it stays where it is until end().
  void begin(const std::deque<motion::Segment>& segments);
  void end();
  void see(const SpeedCycle& cycle);
  /// Beads of which more was off speed than their material's tolerance, or that have stood, in the order in which they
  /// were dispensed.
  [[nodiscard]] std::vector<OffSpeed> off_speed() const;

 private:
  void enter(std::uint32_t feature);
  void go_on(double by_mm);
  /// The path has come to the end of this segment.
  void leave(const motion::Segment& segment);
  OffSpeed& seen();
  /// The planned speed at the position reached, where it is steady from some cycles before to some after.
  [[nodiscard]] std::optional<double> steady_speed() const;
  void judge(double path_speed_mm_s);

  const recipes::Recipe& recipe_;
  double tick_s_;
  const std::deque<motion::Segment>* segments_ = nullptr;
  std::size_t next_ = 0;  ///< where the next feature is looked for

  const recipes::Material* material_ = nullptr;  ///< of the bead that the path is on; null: none that is judged
  std::uint32_t feature_ = motion::kTravel;
  std::size_t segment_ = 0;  ///< of the position reached ...
  double s_mm_ = 0;          ///< ... and how far it is into it
  double t_s_ = 0;           ///< when the plan comes to it
  bool wet_ = false;         ///< by plan the valve is told to open before it, and to shut behind it
  double wet_mm_ = 0;        ///< how far it is from there to the segment's start
  bool valve_open_ = false;  ///< in this cycle
  bool may_round_ = false;   ///< corners may be rounded
  double last_mm_s_ = 0;
  std::optional<int> open_ticks_;  ///< since the valve was told to open
  std::vector<OffSpeed> seen_;
};

}  // namespace gantry::job
