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
  EXPECT_TRUE(job.collisions.empty());

  ASSERT_TRUE(owner.jog(words("X", "-120 mm")));
  const auto free = owner.home();
  EXPECT_TRUE(free) << to_text(free.error());
}

}  // namespace
}  // namespace gantry
