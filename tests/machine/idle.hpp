// An owner that is idle: up, enabled, referenced, at rest, with a script of what is to come from SYNC0 number 20000 on.
//   Idle idle("[{at: cycle 20000, do: cut_link, station: z}]");   idle.pass_to(20'500);   idle.now()
#pragma once
#include <string>

#include "tests/machine/rig.hpp"

namespace gantry::test {

inline constexpr std::uint32_t kAllAxes = 0b11111;  // X, Y, Z, C, U
inline constexpr CycleIndex kTrouble = 20'000;      // the axes stand, enabled and referenced

struct Idle {
  explicit Idle(const std::string& script, const std::function<void(config::Machine&)>& change = {})
      : rig({.placement = "dx=0 mm", .script = script, .change = change}) {
    const auto up = rig.owner().bring_up();
    EXPECT_TRUE(up) << to_text(up.error());
    const auto homed = rig.owner().home();
    EXPECT_TRUE(homed) << to_text(homed.error());
    EXPECT_EQ(now().enabled, kAllAxes);
    EXPECT_LT(now().cycle, kTrouble - 100);
    pass_to(kTrouble - 100);
    stood_at = now().actual;
  }
  [[nodiscard]] const cycle::Snapshot& now() const { return rig.machine().axes.empty() ? none : owner().latest(); }
  [[nodiscard]] run::Owner& owner() const { return const_cast<Rig&>(rig).owner(); }
  void step() {
    const CycleIndex before = now().cycle;
    const auto alive = owner().idle();
    ASSERT_TRUE(alive) << to_text(alive.error());
    longest_idle = std::max(longest_idle, now().cycle - before);
  }
  void pass_to(CycleIndex cycle) {
    while (now().cycle < cycle && !testing::Test::HasFatalFailure()) step();
  }
  template <class Condition>
  bool until(Condition condition, int limit) {
    const CycleIndex end = now().cycle + limit;
    while (!condition() && now().cycle < end && !testing::Test::HasFatalFailure()) step();
    return condition();
  }
  [[nodiscard]] bool whole() const { return now().al_states == 8 && now().working_counter == now().expected; }

  Rig rig;
  cycle::Snapshot none;
  AxisVec stood_at{};
  CycleIndex longest_idle = 0;
};

}  // namespace gantry::test
