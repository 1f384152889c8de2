// A machine one side of which is altered, used as a person would: brought up, homed, jogged.
//   const Outcome out = drive([](auto& m) { station(m, "x").profile.clock_bits = 32; });
//   EXPECT_EQ(out.wrong, "");   out.works   to_text(out.why)
// The judge is the virtual world: an axis that the controller calls referenced must stand where the controller
// believes, and one that was jogged must have gone by that displacement.
#pragma once
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "config/machine.hpp"
#include "core/error.hpp"
#include "sim/station/habits.hpp"

namespace gantry::test {

struct Outcome {
  bool works = false;
  Error why;
  std::string wrong;  ///< why neither of the two; empty: it is fine
  std::string said;   ///< what was told meanwhile
  double z_mm = 0;    ///< where the world has Z at the end
};

using Habits = std::vector<std::pair<const char*, sim::StationHabits>>;

/// `wired` alters the simulated machine alone; `script` is of its world.
Outcome drive(const std::function<void(config::Machine&)>& wired, const Habits& habits = {},
              const std::string& script = "");

/// A station that is not what it says.
struct Lie {
  const char* what;
  const char* station;
  sim::StationHabits habits;
  std::function<void(config::Machine&)> wired{};
  std::vector<const char*> refused{};  ///< what the reason names; empty: it works as well
  const char* script = "";             ///< of its world
};

/// Uses that machine: it works as well, or is refused by those names. GANTRY_SHOW prints what came of it.
Outcome expect_as_well_or_refused(const Lie& lie);

/// Modes, switches and error codes of all drives are in no PDO.
void by_sdo(config::Machine& machine);

}  // namespace gantry::test
