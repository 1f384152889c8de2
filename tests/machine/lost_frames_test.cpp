// Frames that are lost while axes move: the drives stand at the last target that came to them, and what comes when the
// line is whole again must not make them leap.
#include <cmath>

#include "tests/machine/idle.hpp"

namespace gantry {
namespace {

using cycle::State;
using run::OrderKind;
using test::Idle;

struct Motion {
  std::size_t axis;
  const char* name;
  double to_mm, back_mm, speed_mm_s;
};

/// By hand: the last target that was heard, and three more (`frames_lost_max`) at full speed; then the target stands.
/// Judged by where the world says the axis is.
TEST(LostFrames, leave_the_axes_where_they_were_going_to_be_within_three_cycles_however_many_they_are) {
  Idle idle("[]");
  run::Owner& owner = idle.owner();
  for (const Motion& m : {Motion{0, "X", 400, 50, 500}, {1, "Y", 350, 50, 500}, {2, "Z", -70, -5, 150}})
    for (const char* what : {"lose_frames, count: 3", "lose_frames, count: 10", "lose_frames, count: 60",
                             "delay_frames, count: 60, by: 4 ms"}) {
      SCOPED_TRACE(std::string(m.name) + ", " + what);
      const double from = idle.now().actual[m.axis], forth = m.to_mm - from, back = m.back_mm - from;
      const double by = std::abs(forth) > std::abs(back) ? forth : back, way = by > 0 ? 1 : -1;
      bool lost = false, told = false;
      double heard = 0, farthest = -1e9;
      owner.on_step([&] {
        const cycle::Snapshot& s = owner.latest();
        const double fast = (s.target[m.axis] - heard) * way / 0.001;
        if (told && !s.answered) lost = true;
        if (!lost) heard = s.target[m.axis];
        if (lost) farthest = std::max(farthest, ((*owner.world()->axes())[m.axis] - heard) * way);
        if (told || s.state != State::Running || fast < 0.99 * m.speed_mm_s) return;
        told = true;
        EXPECT_TRUE(owner.world()->add_script(std::string("{do: ") + what + "}"));
      });
      EXPECT_FALSE(
          owner.jog({.by = {{m.name, std::to_string(by) + " mm"}}, .speed = std::to_string(m.speed_mm_s) + " mm/s"}));
      idle.pass_to(idle.now().cycle + 500);
      owner.on_step({});
      ASSERT_TRUE(lost);
      const double end = ((*owner.world()->axes())[m.axis] - heard) * way;
      EXPECT_LE(farthest, m.speed_mm_s * 0.003 + 0.002);
      EXPECT_GE(end, -0.002) << "it does not go back either";
      EXPECT_EQ(idle.now().latched, Fault::FramesLost);
      EXPECT_EQ(idle.now().enabled, test::kAllAxes) << "an axis-wise stop leaves the torque";
      ASSERT_TRUE(owner.order({.kind = OrderKind::Reset, .value = 1}));
      ASSERT_TRUE(test::answer_of_reset(owner));
      EXPECT_EQ(idle.now().state, State::Ready);
      EXPECT_EQ(idle.now().referenced, test::kAllAxes);
    }
}

}  // namespace
}  // namespace gantry
