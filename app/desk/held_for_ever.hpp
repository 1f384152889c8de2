// Ends a dry run that stands on hold and that nobody resumes: its time is virtual, so that it would never end.
//   HeldForEver held(owner, machine.bus.cycle);   each step: held.poll();
#pragma once
#include <optional>

#include "app/run/owner.hpp"
#include "core/clock.hpp"

namespace gantry::desk {

class HeldForEver {
 public:
  HeldForEver(run::Owner& owner, Time cycle) : owner_(owner), cycle_(cycle) {}
  /// Fault::Inconsistent at the script's entry that presses hold, when nothing is left in the script that would change
  /// it, or when it has stood for `kLongest`.
  void poll();

  static constexpr Time kLongest = std::chrono::minutes(10);

 private:
  run::Owner& owner_;
  Time cycle_;
  std::optional<CycleIndex> since_;  ///< it stands on hold
  CycleIndex asked_ = 0;             ///< when the script was looked at last
  int nothing_left_ = 0;             ///< looks at it in a row
};

}  // namespace gantry::desk
