// A host that stops the loop for some ms while axes move fast: the simulated machine tolerates it as the machine file
// says (stop_after_missed: sim), the drives catch up, and an axis that really does not follow is still found (R33).
#include <random>

#include "app/job/limits.hpp"
#include "motion/path/moves.hpp"
#include "tests/app/cycle/loop_bench.hpp"

namespace gantry::test {
namespace {

using cycle::State;

/// Under way on X and Y together at full speed.
void travel(LoopBench& b) {
  b.operate();
  b.enable();
  b.home();
  const motion::Limits limits = job::limits_of(b.machine);
  AxisVec far = b.now.target;
  far[0] = 450, far[1] = 350;
  b.play(motion::line_move(limits, b.now.target, far));
  ASSERT_TRUE(b.until([&] { return b.now.path_speed > 0.99 * b.machine.axes[0].v_max; }, 5000));
}

TEST(StalledHost, stalls_that_are_tolerated_stop_no_motion) {
  for (const unsigned seed : {1u, 2u, 3u, 4u, 5u, 6u, 7u, 8u}) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    LoopBench b(reference_machine(), false);
    travel(b);
    // From single long ones to a burst in which nearly every cycle is late.
    const int longest = std::uniform_int_distribution(2, b.setup.stop_after_missed)(random);
    const int apart = std::uniform_int_distribution(1, 40)(random);
    while (b.now.state == State::Running && b.now.path_speed > 0) {
      b.tick(std::uniform_int_distribution(1, longest)(random));
      b.ticks(std::uniform_int_distribution(0, apart)(random));
    }
    EXPECT_EQ(b.told(Fault::FollowingError), 0) << "stalls of up to " << longest << " cycles, " << apart << " apart";
  }
}

/// What the stalls of a host that wakes the loop too late did to a travel.
struct Disturbed {
  int device_faults = 0, told = 0;
  double longest_step = 0;  ///< of X from one sent target to the next, mm
  bool arrived = false;
};

Disturbed travel_among_stalls(LoopBench& b) {
  travel(b);
  std::mt19937 random(17);
  Disturbed seen;
  const double far = 450;
  double last = b.now.target[0];
  while (b.now.state == State::Running) {
    b.clock.oversleep(std::uniform_int_distribution(40, b.setup.stop_after_missed)(random) * b.setup.period +
                      microseconds(30));
    for (int i = std::uniform_int_distribution(3, 60)(random); i > 0 && b.now.state == State::Running; --i) {
      b.tick();
      seen.longest_step = std::max(seen.longest_step, std::abs(b.now.target[0] - std::exchange(last, b.now.target[0])));
    }
  }
  seen.device_faults = b.told(Fault::FollowingError) + b.told(Fault::DriveFault);
  seen.told = b.told(Fault::LateCycle);
  seen.arrived = std::abs(b.now.target[0] - far) < 1e-6;
  return seen;
}

TEST(StalledHost, a_machine_in_this_process_stands_still_with_its_host) {
  LoopBench b(reference_machine(), false);
  b.clock.patient = true;
  const Disturbed seen = travel_among_stalls(b);
  EXPECT_EQ(seen.device_faults, 0);
  EXPECT_GT(seen.told, 3);
  EXPECT_LE(seen.longest_step, 1.0001 * b.machine.axes[0].v_max * 1e-3);
  EXPECT_TRUE(seen.arrived);
  b.clock.oversleep((b.setup.stop_after_missed + 1) * b.setup.period + microseconds(30));
  b.tick();
  EXPECT_EQ(b.told(Fault::ControllerStalled), 1);
}

TEST(StalledHost, stalls_that_no_drive_can_make_up_for_are_what_that_test_is_about) {
  LoopBench b(reference_machine(), false);
  const Disturbed seen = travel_among_stalls(b);
  EXPECT_GT(seen.device_faults, 0);
  EXPECT_GT(seen.longest_step, 10);
}

TEST(StalledHost, an_axis_that_is_held_is_found_among_stalls_too) {
  for (const int every : {0, 25, 60}) {
    SCOPED_TRACE(every);
    LoopBench b(reference_machine(), false);
    travel(b);
    b.segment.motor(b.machine.x).set_stalled(true);
    const auto& x = b.machine.axes[0];
    // Time to leave the window, to be told of it, and three cycles (R33); a stall hides it for as long as it lasts and
    // the drive may take to catch up.
    const double window_s = x.following_base / x.v_max + x.following_per_speed_s;
    const int limit = static_cast<int>(window_s * 1000) + 2 + 3 + (every > 0 ? 14 + 12 : 0);
    int cycles = 0;
    for (; b.told(Fault::FollowingError) == 0 && cycles < 500; ++cycles) {
      const bool stall = every > 0 && cycles > 0 && cycles % every == 0;
      b.tick(stall ? 14 : 1);
    }
    EXPECT_LE(cycles, limit);
  }
}

}  // namespace
}  // namespace gantry::test
