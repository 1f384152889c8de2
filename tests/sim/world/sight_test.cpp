// The rendered camera before the real vision: two pieces of code that know nothing of each other must agree on where a
// mark is, and the negative controls must show.
#include <cmath>
#include <gtest/gtest.h>

#include "recipes/recipe.hpp"
#include "sim/random.hpp"
#include "sim/world/render.hpp"
#include "vision/camera_model.hpp"
#include "vision/find.hpp"

namespace gantry::sim {
namespace {

class Sight : public testing::Test {
 protected:
  Sight() : machine(config::load_machine("config/machines/dispenser.yaml").value()) {
    recipe = recipes::load("recipes/demo-board.yaml").value();
    frame = config::find_frame(machine, recipe.board.frame)->origin;
  }
  BoardTruth board_at(const BoardPlacement& p) const { return {board_plan(recipe), frame, p}; }

  /// Where vision sees a mark, in the machine frame, when the camera stands over the mark's nominal place.
  Result<Vec2> seen(const BoardTruth& board, std::size_t mark, std::uint64_t seed) const {
    View v;
    v.focus = board_at({}).to_machine(recipe.marks[mark].at, 0);
    v.width_px = machine.camera.width_px, v.height_px = machine.camera.height_px;
    v.mm_per_px = machine.camera.mm_per_px;
    v.noise = machine.sim.camera_noise;
    const vision::Image image = render(v, &board, seed);
    const vision::CameraModel model(machine.camera);
    const auto found = vision::find_mark(
        image, {vision::Disc{model.length_px(recipe.marks[mark].diameter)}, recipe.marks[mark].bright},
        {(v.width_px - 1) / 2.0, (v.height_px - 1) / 2.0}, model.length_px(machine.camera.search_mm));
    if (!found) return tl::unexpected(found.error());
    const Vec2 off = model.to_mm(found->at_px);
    return Vec2{v.focus.x + off.x, v.focus.y + off.y};
  }

  config::Machine machine;
  recipes::Recipe recipe;
  Vec3 frame;
};

TEST_F(Sight, vision_finds_every_mark_of_misplaced_boards_within_a_micrometre) {
  constexpr std::uint64_t kSeed = 404;
  double square = 0, worst = 0;
  int n = 0;
  for (std::uint64_t b = 0; b < 6; ++b) {
    const BoardTruth board = board_at(draw_placement(machine.sim, kSeed, b, std::nullopt));
    for (std::size_t m = 0; m < recipe.marks.size(); ++m) {
      const auto at = seen(board, m, mix(kSeed, b * 10 + m));
      ASSERT_TRUE(at) << "seed " << kSeed << " board " << b << ": " << to_text(at.error());
      const Vec3 truth = board.to_machine(recipe.marks[m].at, 0);
      const double error = std::hypot(at->x - truth.x, at->y - truth.y);
      square += error * error, worst = std::max(worst, error), ++n;
    }
  }
  EXPECT_LT(std::sqrt(square / n), 0.0005) << "mm rms";
  EXPECT_LT(worst, 0.001) << "mm";
}

TEST_F(Sight, moving_the_hidden_board_by_d_moves_what_is_seen_by_d) {
  const auto before = seen(board_at({}), 0, 1);
  ASSERT_TRUE(before);
  for (const Vec2 d : {Vec2{1.3, -0.7}, Vec2{-2, 2}, Vec2{0.004, 0.003}}) {
    BoardPlacement p;
    p.shift = d;
    const auto after = seen(board_at(p), 0, 2);
    ASSERT_TRUE(after) << to_text(after.error());
    EXPECT_NEAR(after->x - before->x, d.x, 0.001);
    EXPECT_NEAR(after->y - before->y, d.y, 0.001);
  }
}

TEST_F(Sight, a_mark_that_was_taken_away_is_not_found) {
  BoardTruth board = board_at({});
  for (std::size_t m = 0; m < recipe.marks.size(); ++m) {
    std::erase_if(board.plan.marks, [&](const recipes::MarkDef& d) { return d.name == recipe.marks[m].name; });
    const auto at = seen(board, m, 3);
    ASSERT_FALSE(at) << recipe.marks[m].name;
    EXPECT_EQ(at.error().fault, Fault::MarkNotFound);
  }
}

}  // namespace
}  // namespace gantry::sim
