// Ends a simulated job that stands on hold, or that a fault has stopped, and that nobody resumes: in virtual time it
// would never end.
//   HeldForEver held(owner, machine.bus.cycle, HeldForEver::Ends::Stops);   each step: held.poll();
#pragma once
#include <optional>

#include "app/run/owner.hpp"
#include "core/clock.hpp"

namespace gantry::desk {

class HeldForEver {
 public:
  /// Of jobs in real time that somebody may hold by other means than the script, the stops alone.
  enum class Ends { Stops, HoldsToo };

  HeldForEver(run::Owner& owner, Time cycle, Ends ends) : owner_(owner), cycle_(cycle), ends_(ends) {}
  /// When nothing is left in the script that would change it, or when it has stood for `kLongest`: the job ends with
  /// the fault that has stopped it, else with Fault::Inconsistent at the script's entry that presses hold.
  void poll();

  static constexpr Time kLongest = std::chrono::minutes(10);

 private:
  run::Owner& owner_;
  Time cycle_;
  Ends ends_;
  std::optional<CycleIndex> since_;  ///< it stands on hold
  CycleIndex asked_ = 0;             ///< when the script was looked at last
  int nothing_left_ = 0;             ///< looks at it in a row
};

}  // namespace gantry::desk
