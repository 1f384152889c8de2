#include "app/job/prove_homing.hpp"

#include <gtest/gtest.h>

#include "tests/app/job/reference.hpp"

namespace gantry::job {
namespace {

struct ProveHoming : testing::Test {
  config::Machine machine = test::reference();
  AxisVec at(double x, double y, double z, double u = 0) {
    AxisVec q = test::parked(machine);
    q[machine.x.value] = x, q[machine.y.value] = y, q[machine.z.value] = z, q[machine.u->value] = u;
    return q;
  }
  Result<void> prove(const AxisVec& from) { return prove_homing(machine, Surroundings(machine), from); }
  void refused(const AxisVec& from, std::initializer_list<const char*> words) {
    const auto proof = prove(from);
    ASSERT_FALSE(proof);
    EXPECT_EQ(proof.error().fault, Fault::Collision);
    for (const char* word : words)
      EXPECT_NE(proof.error().message.find(word), std::string::npos) << proof.error().message;
  }
};

TEST_F(ProveHoming, the_reference_machine_homes_from_wherever_it_works) {
  for (const double x : {20.0, 150.0, 300.0})
    for (const double y : {20.0, 120.0, 250.0})
      for (const double z : {-2.0, -20.0, -38.0}) EXPECT_TRUE(prove(at(x, y, z))) << x << ' ' << y << ' ' << z;
}

/// Z goes first, and up: the camera (its top 38 mm over the axis' zero) would go into the shelf over it.
TEST_F(ProveHoming, a_shelf_over_the_head_is_met_by_z) {
  const AxisVec low = at(200, 150, -30);
  machine.scene.push_back({"shelf", {config::Shape::Kind::Box, {30, 30, 2}}, {260, 150, 38 - 30 + 3.5}, 0, false});
  refused(low, {"while Z home", "camera_body", "shelf"});
  machine.scene.back().centre.x = 400;  // beside it: nothing is over the head any more
  EXPECT_TRUE(prove(low));
}

/// At the top X and Y go to their edges at the same time, each as fast as it does: the whole rectangle counts.
TEST_F(ProveHoming, a_post_beside_the_diagonal_is_in_the_rectangle) {
  const AxisVec here = at(300, 300, -2);
  machine.scene.push_back({"mast", {config::Shape::Kind::Box, {4, 4, 300}}, {60, 330, 0}, 0, false});
  refused(here, {"X", "Y", "mast"});
  machine.scene.back().centre = {480, 330, 0};
  EXPECT_TRUE(prove(here)) << "away from where the axes go";
}

/// What stands near when homing begins comes no nearer, and may stay.
TEST_F(ProveHoming, what_is_near_already_may_be_left) {
  const AxisVec here = at(200, 150, -30);
  machine.scene.push_back({"stand", {config::Shape::Kind::Box, {10, 10, 10}}, {200, 150, -70 - 1 - 5}, 0, false});
  EXPECT_TRUE(prove(here)) << "1 mm under the needle, which goes up";
}

constexpr std::uint32_t bits(std::initializer_list<AxisId> ids) {
  std::uint32_t mask = 0;
  for (const AxisId id : ids) mask |= 1u << id.value;
  return mask;
}

/// The head is placed by X, Y and Z: a turn that is lost moves no body, a lift may stand anywhere.
TEST_F(ProveHoming, what_does_not_hang_on_the_lost_axis_is_proved_as_ever) {
  const AxisVec low = at(200, 150, -30);
  const std::uint32_t lost = bits({*machine.c, *machine.u});
  EXPECT_TRUE(prove_homing(machine, Surroundings(machine), low, {.referenced = ~lost}));
  machine.scene.push_back({"shelf", {config::Shape::Kind::Box, {30, 30, 2}}, {260, 150, 38 - 30 + 3.5}, 0, false});
  const auto all = prove_homing(machine, Surroundings(machine), low, {.referenced = ~lost});
  ASSERT_FALSE(all);
  EXPECT_EQ(all.error().fault, Fault::Collision);
  for (const char* word : {"while Z home", "camera_body", "shelf", "gantry home C U"})
    EXPECT_NE(all.error().message.find(word), std::string::npos) << all.error().message;
  EXPECT_TRUE(prove_homing(machine, Surroundings(machine), low, {.referenced = ~lost, .homed = lost}));
}

/// The syringe (15 mm under the axis' zero to 55 over it) may stand 40 mm lower: with the lift down it passes under the
/// shelf, and goes up into it.
TEST_F(ProveHoming, a_shelf_over_the_syringe_is_met_by_a_lift_that_may_stand_under_it) {
  const AxisVec here = at(200, 150, -30);
  const std::uint32_t lost = bits({*machine.u});
  machine.scene.push_back({"shelf", {config::Shape::Kind::Box, {4, 4, 2}}, {212, 150, -30 + 55 + 5}, 0, false});
  const auto alone = prove_homing(machine, Surroundings(machine), here, {.referenced = ~lost, .homed = lost});
  ASSERT_FALSE(alone);
  for (const char* word : {"while U home", "syringe", "shelf", "U is not referenced", "by hand"})
    EXPECT_NE(alone.error().message.find(word), std::string::npos) << alone.error().message;
  machine.scene.back().centre.x = 260;
  EXPECT_TRUE(prove_homing(machine, Surroundings(machine), here, {.referenced = ~lost, .homed = lost}));
}

/// A needle that works stands near the board: the lift could be lower only in the board. What is under it is left.
TEST_F(ProveHoming, a_needle_at_work_rises_from_what_it_cannot_stand_in) {
  const std::uint32_t lost = bits({*machine.c, *machine.u});
  machine.scene.push_back(
      {"block", {config::Shape::Kind::Box, {30, 30, 20}}, {200, 150, -40 - 40 - 30 - 1 - 10}, 0, false});
  const AxisVec low = at(200, 150, -40);  // U stood at 30: 1 mm over the block
  EXPECT_TRUE(prove_homing(machine, Surroundings(machine), low, {.referenced = ~lost}));
  EXPECT_TRUE(prove_homing(machine, Surroundings(machine), low, {.referenced = ~lost, .homed = lost}));
}

/// At the top a lift that may be down still reaches 40 mm lower while X and Y go to their edges.
TEST_F(ProveHoming, a_lift_that_may_be_down_is_swept_over_the_rectangle) {
  const AxisVec here = at(300, 300, -2);
  machine.scene.clear();
  machine.scene.push_back({"mast", {config::Shape::Kind::Box, {4, 4, 20}}, {100, 100, -70}, 0, false});
  EXPECT_TRUE(prove(here)) << "the mast ends at -60, the probe at -46";
  const std::uint32_t lost = bits({*machine.u});
  const auto all = prove_homing(machine, Surroundings(machine), here, {.referenced = ~lost});
  ASSERT_FALSE(all);
  for (const char* word : {"X, Y", "needle", "mast", "gantry home U"})
    EXPECT_NE(all.error().message.find(word), std::string::npos) << all.error().message;
  EXPECT_TRUE(prove_homing(machine, Surroundings(machine), here, {.referenced = ~lost, .homed = lost}));
}

/// C homes from where it stands (0) to -185 deg, with X and Y to their edges: an arm to the right of the needle swings
/// over the front to the left and back of it. Alone it passes only by the front.
TEST_F(ProveHoming, an_arm_that_turns_is_swept_with_what_carries_it) {
  const AxisVec here = at(200, 150, -30);
  machine.scene.clear();
  machine.head.push_back({"arm", {config::Shape::Kind::Box, {50, 4, 4}}, {50, 0, -38}, 0, true, true});
  const std::uint32_t c = bits({*machine.c});
  const auto only_c = [&](Vec2 post, const AxisVec& from, std::uint32_t referenced = ~0u) {
    machine.scene = {{"post", {config::Shape::Kind::Box, {4, 4, 10}}, {post.x, post.y, -68}, 0, false}};
    return prove_homing(machine, Surroundings(machine), from, {.referenced = referenced, .homed = c}).has_value();
  };
  EXPECT_FALSE(only_c({200, 90}, here)) << "60 mm before the needle: swept";
  EXPECT_FALSE(only_c({140, 150}, here)) << "to its left: where it ends";
  EXPECT_TRUE(only_c({200, 210}, here)) << "behind it: not swept from 0 deg";
  EXPECT_TRUE(only_c({200, 50}, here)) << "farther than it reaches";
  EXPECT_FALSE(only_c({200, 210}, here, ~c)) << "behind it, where C may stand anywhere";
  AxisVec turned = here;
  turned[machine.c->value] = 1.5707963;
  EXPECT_FALSE(only_c({200, 200}, turned)) << "an arm that points to the back";
  // With X and Y it is swept over the rectangle down to their edges.
  machine.scene = {{"post", {config::Shape::Kind::Box, {4, 4, 10}}, {100, 60, -38 - 2}, 0, false}};
  EXPECT_FALSE(prove(at(200, 150, -2))) << "the arm passes at the post's height once Z is up";
  machine.scene.front().centre.z = -60;
  EXPECT_TRUE(prove(at(200, 150, -2)));
  machine.scene.front() = {"post", {config::Shape::Kind::Box, {4, 4, 10}}, {300, 60, -40}, 0, false};
  EXPECT_TRUE(prove(at(200, 150, -2))) << "to the right of all that";
}

TEST_F(ProveHoming, the_head_is_placed_by_x_y_and_z) {
  EXPECT_TRUE(head_is_placed(machine, ~bits({*machine.c, *machine.u})));
  for (const AxisId axis : {machine.x, machine.y, machine.z}) EXPECT_FALSE(head_is_placed(machine, ~bits({axis})));
}

/// IEC 61800-7-201, 10.4: how far an axis goes while it homes.
TEST(HomingRange, goes_to_the_edge_and_as_far_beyond_as_it_brakes) {
  config::Axis axis;
  axis.p_min = 0, axis.p_max = 100;
  axis.homing = config::Homing{.method = 17, .fast = 20, .slow = 2, .acceleration = 200, .position = -2};
  const double beyond = 20 * 0.02 + 20.0 * 20 / (2 * 200);  // 20 ms until it brakes, then v^2 / 2a
  EXPECT_NEAR(homing_range(axis, 60).low, -2 - beyond, 1e-12);
  EXPECT_EQ(homing_range(axis, 60).high, 60);
  axis.homing->method = 23;  // may run to the positive limit first
  EXPECT_GE(homing_range(axis, 60).high, 100);
  axis.homing->method = 37;  // homes where it stands
  EXPECT_EQ(homing_range(axis, 60).low, 60);
  EXPECT_EQ(homing_range(axis, 60).high, 60);
}

}  // namespace
}  // namespace gantry::job
