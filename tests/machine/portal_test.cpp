// A bridge over the board that is neither passed over nor under. The judge knows three boxes and where the needle is in
// each millisecond; that nothing else of the head touches is the world's to say.
#include <cmath>

#include "tests/machine/rig.hpp"

namespace gantry {
namespace {

TEST(Portal, the_head_goes_around_it_and_both_dots_lie_where_they_should) {
  test::Rig rig({.placement = "dx=0.6 mm, dy=-0.4 mm, rot=0.3 deg"});
  const Vec3 origin = config::find_frame(rig.machine(), "pallet")->origin;
  const Vec2 middle{origin.x + 30, origin.y + 42};
  const double needle_radius = 0.8;
  int beside = 0, left = 0, right = 0;
  bool through = false;
  rig.on_step = [&](run::Owner& owner) {
    const auto& s = owner.latest();
    if (s.block == 0) return;
    const Vec2 from_middle = Vec2{s.actual[rig.machine().x.value], s.actual[rig.machine().y.value]} - middle;
    (from_middle.x < 0 ? left : right) += 1;
    if (std::abs(from_middle.x) > 3 + needle_radius) return;
    const bool off_its_end = std::abs(from_middle.y) > 30 + needle_radius;
    beside += off_its_end;
    through = through || !off_its_end;
  };
  const auto result = rig.run("recipes/portal.yaml");
  EXPECT_EQ(result.exit_code, ExitCode::Done) << (result.errors.empty() ? "" : to_text(result.errors.front()));
  EXPECT_TRUE(result.collisions.empty());
  EXPECT_EQ(result.deposits.size(), 2u);
  EXPECT_GT(beside, 10) << "it has been passed";
  EXPECT_GT(left, 100);
  EXPECT_GT(right, 100);
  EXPECT_FALSE(through);
}

}  // namespace
}  // namespace gantry
