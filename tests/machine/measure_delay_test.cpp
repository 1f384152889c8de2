// The delay of an axis is found from its positions at constant speed. Altered is the simulator's side alone: what is
// found follows it, whatever the machine file states.
#include "app/run/measure_delay.hpp"

#include <cmath>

#include "tests/machine/idle.hpp"

namespace gantry::test {
namespace {

struct Truth {
  double lag_s, delay_s;
};

TEST(MeasuredDelay, follows_the_virtual_drive_within_what_it_says) {
  struct Case {
    const char* axis;
    std::size_t index;
    Truth truth;
  };
  for (const Case& c : {Case{"X", 0, {2e-3, 0}}, Case{"X", 0, {2e-3, 5e-3}}, Case{"X", 0, {9e-3, 0}},
                        Case{"Y", 1, {3e-3, 0}}, Case{"Y", 1, {3e-3, 8e-3}}, Case{"Z", 2, {1.5e-3, 3.3e-3}}}) {
    Rig rig({.placement = "dx=0 mm", .wired = [&](auto& m) {
               m.sim.axes[c.index].lag_s = c.truth.lag_s;
               m.sim.axes[c.index].delay_s = c.truth.delay_s;
             }});
    ASSERT_TRUE(rig.owner().bring_up());
    ASSERT_TRUE(rig.owner().home());
    double low = 1e9, high = -1e9;
    const config::Axis& axis = rig.machine().axes[c.index];
    const auto found = run::measure_delay(rig.owner(), rig.machine(), {.axis = c.axis}, [&] {
      low = std::min(low, rig.owner().latest().target[c.index]);
      high = std::max(high, rig.owner().latest().target[c.index]);
    });
    ASSERT_TRUE(found) << c.axis << ": " << to_text(found.error());
    // Drives interpolate over one cycle (1 ms).
    const double truth_s = 1e-3 + c.truth.lag_s + c.truth.delay_s;
    EXPECT_LE(std::abs(found->delay_s - truth_s), found->within_s) << c.axis << ": " << found->delay_s;
    EXPECT_LT(found->within_s, 0.1e-3) << c.axis;
    EXPECT_GE(low, axis.p_min - 2.001) << "homing leaves it at its switch";
    EXPECT_LE(high, axis.p_max + 1.001);
    EXPECT_EQ(rig.owner().latest().state, cycle::State::Ready);
  }
}

TEST(MeasuredDelay, is_refused_of_an_open_loop_axis_and_of_what_is_no_axis) {
  Rig rig({.placement = "dx=0 mm"});
  ASSERT_TRUE(rig.owner().bring_up());
  ASSERT_TRUE(rig.owner().home());
  const AxisVec stood = rig.owner().latest().target;
  for (const auto& [axis, fault, words] : {std::tuple{"C", Fault::Refused, "its 6064h is the command"},
                                           {"U", Fault::Refused, "its 6064h is the command"},
                                           {"Q", Fault::Usage, "known: X"}}) {
    const auto found = run::measure_delay(rig.owner(), rig.machine(), {.axis = axis});
    ASSERT_FALSE(found) << axis;
    EXPECT_EQ(found.error().fault, fault) << to_text(found.error());
    EXPECT_NE(to_text(found.error()).find(words), std::string::npos) << to_text(found.error());
  }
  const auto far = run::measure_delay(rig.owner(), rig.machine(), {.axis = "Z", .speed = "150 mm/s"});
  ASSERT_FALSE(far);
  EXPECT_EQ(far.error().fault, Fault::OutOfReach) << to_text(far.error());
  const auto absurd = run::measure_delay(rig.owner(), rig.machine(), {.axis = "X", .speed = "1e6 mm/s"});
  ASSERT_FALSE(absurd);
  EXPECT_EQ(absurd.error().fault, Fault::Usage) << to_text(absurd.error());
  EXPECT_NE(to_text(absurd.error()).find("v_max of axis X, 500 mm/s"), std::string::npos) << to_text(absurd.error());
  EXPECT_EQ(rig.owner().latest().target, stood) << "nothing has moved";
}

// Where the machine is not homed nothing is known of its limits.
TEST(MeasuredDelay, is_refused_of_a_machine_that_is_not_homed) {
  Rig rig({.placement = "dx=0 mm"});
  ASSERT_TRUE(rig.owner().bring_up());
  const auto found = run::measure_delay(rig.owner(), rig.machine(), {.axis = "X"});
  ASSERT_FALSE(found);
  EXPECT_EQ(found.error().fault, Fault::NotReferenced) << to_text(found.error());
}

}  // namespace
}  // namespace gantry::test
