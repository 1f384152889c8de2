// The camera stands under a shelf: whatever goes up from there is refused, and the head is led out sideways.
#include "app/job/jog.hpp"
#include "tests/machine/rig.hpp"

namespace gantry {
namespace {

job::JogWords words(const char* axis, const char* by) { return {.by = {{axis, by}}, .speed = "100 mm/s"}; }

TEST(UnderAShelf, jog_home_park_and_run_are_refused_with_both_bodies_and_nothing_moves) {
  // Between the camera (60 mm to the right; its top is 38 mm over the zero of Z) and the carriage (from 65 mm on).
  test::Rig rig({.placement = "dx=0 mm", .change = [](config::Machine& m) {
                   m.scene.push_back({"shelf", {config::Shape::Kind::Box, {20, 40, 2}}, {260, 150, 13}, 0, false});
                 }});
  run::Owner& owner = rig.owner();
  ASSERT_TRUE(owner.bring_up());
  ASSERT_TRUE(owner.home());
  for (const auto& [axis, by] : {std::pair{"Y", "152 mm"}, {"Z", "-31 mm"}, {"X", "202 mm"}}) {
    const auto jogged = owner.jog(words(axis, by));
    ASSERT_TRUE(jogged) << to_text(jogged.error());
  }
  const AxisVec stood = owner.latest().target;
  const auto refused = [&](const std::string& what, const Error& e) {
    EXPECT_EQ(e.fault, Fault::Collision) << what;
    for (const char* word : {"camera_body", "shelf"})
      EXPECT_NE(e.message.find(word), std::string::npos) << what << ": " << e.message;
    EXPECT_EQ(owner.latest().target, stood) << what << " moved";
  };
  const auto up = owner.jog(words("Z", "20 mm"));
  ASSERT_FALSE(up);
  refused("jog", up.error());
  const auto home = owner.home();
  ASSERT_FALSE(home);
  refused("home", home.error());
  const auto park = owner.park();
  ASSERT_FALSE(park);
  refused("park", park.error());
  const record::JobResult job = rig.run("recipes/demo-board.yaml");
  ASSERT_FALSE(job.errors.empty());
  refused("run", job.errors.front());
  EXPECT_NE(job.errors.front().message.find(" mm [machine "), std::string::npos)
      << "in the coordinates of its board: " << job.errors.front().message;
  EXPECT_TRUE(job.collisions.empty());

  ASSERT_TRUE(owner.jog(words("X", "-120 mm")));
  const auto free = owner.home();
  EXPECT_TRUE(free) << to_text(free.error());
}

/// The turn and the lift have lost their supply, and with it their reference; X, Y and Z still say where the head is.
TEST(UnderAShelf, home_is_refused_too_when_turn_and_lift_have_lost_their_reference_and_these_alone_lead_out) {
  test::Rig rig({.placement = "dx=0 mm", .change = [](config::Machine& m) {
                   m.scene.push_back({"shelf", {config::Shape::Kind::Box, {20, 40, 2}}, {260, 150, 13}, 0, false});
                 }});
  run::Owner& owner = rig.owner();
  ASSERT_TRUE(owner.bring_up());
  const auto early = owner.home({"C", "U"});
  ASSERT_FALSE(early) << "nothing says where the head stands";
  EXPECT_EQ(early.error().fault, Fault::NotReferenced);
  ASSERT_TRUE(owner.home());
  for (const auto& [axis, by] : {std::pair{"Y", "152 mm"}, {"Z", "-31 mm"}, {"X", "202 mm"}}) {
    const auto jogged = owner.jog(words(axis, by));
    ASSERT_TRUE(jogged) << to_text(jogged.error());
  }
  ASSERT_TRUE(owner.world()->load_board(test::load_recipe("recipes/demo-board.yaml")));
  ASSERT_TRUE(owner.world()->add_script("{do: power_cycle, station: cu, dark: 200 ms}"));
  const auto pass = [&](CycleIndex cycles) {
    for (const CycleIndex end = owner.latest().cycle + cycles; owner.latest().cycle < end;) ASSERT_TRUE(owner.idle());
  };
  pass(5000);
  ASSERT_TRUE(owner.order({.kind = run::OrderKind::Reset}));
  const auto cleared = test::answer_of_reset(owner);
  ASSERT_TRUE(cleared) << to_text(cleared.error());
  const AxisVec stood = owner.latest().target;
  const auto expect_stands = [&] {
    for (const AxisId axis : {rig.machine().x, rig.machine().y, rig.machine().z})
      EXPECT_EQ(owner.latest().target[axis.value], stood[axis.value]);
  };
  EXPECT_FALSE(owner.jog(words("X", "-120 mm")));
  const auto home = owner.home();
  ASSERT_FALSE(home);
  EXPECT_EQ(home.error().fault, Fault::Collision);
  for (const char* word : {"camera_body", "shelf", "gantry home C U"})
    EXPECT_NE(home.error().message.find(word), std::string::npos) << home.error().message;
  const record::JobResult job = rig.run("recipes/demo-board.yaml");
  ASSERT_FALSE(job.errors.empty()) << "a job that would home first";
  EXPECT_EQ(job.errors.front().fault, Fault::Collision);
  expect_stands();

  const auto alone = owner.home({"C", "U"});
  ASSERT_TRUE(alone) << to_text(alone.error());
  expect_stands();
  ASSERT_TRUE(owner.jog(words("X", "-120 mm")));
  const auto free = owner.home();
  EXPECT_TRUE(free) << to_text(free.error());
  const auto collisions = owner.world()->collisions();
  ASSERT_TRUE(collisions);
  EXPECT_TRUE(collisions->empty());
}

}  // namespace
}  // namespace gantry
