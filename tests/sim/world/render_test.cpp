#include "sim/world/render.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <numbers>

#include "tests/sim/world/sample.hpp"

namespace gantry::sim {
namespace {

View over(const BoardTruth& nominal, Vec2 board_point) {
  View v;
  v.focus = nominal.to_machine(board_point, 0);
  v.width_px = 640, v.height_px = 512;
  v.mm_per_px = 0.02;
  v.noise = 0;
  v.greys.falloff = 0;
  return v;
}

struct Blob {
  Vec2 at;
  double area_px = 0;
};
/// The judge: centre and area from grey-value moments over the board's level (M1's neighbourhood holds nothing else).
Blob moments(const vision::Image& image, const Greys& g) {
  double sum = 0, sx = 0, sy = 0;
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) {
      const double w = image.at(x, y) - g.board;
      if (w <= 0) continue;
      sum += w, sx += w * x, sy += w * y;
    }
  return {{sx / sum, sy / sum}, sum / (g.mark_bright - g.board)};
}

BoardTruth board_at(const BoardPlacement& p) { return {board_plan(sample::recipe()), {100, 80, 0}, p}; }

TEST(Render, a_mark_stands_where_the_camera_model_puts_it) {
  const BoardTruth nominal = board_at({});
  const View v = over(nominal, {10, 10});
  const Blob b = moments(render(v, &nominal, 1), v.greys);
  EXPECT_NEAR(b.at.x, 319.5, 0.01);
  EXPECT_NEAR(b.at.y, 255.5, 0.01);
  EXPECT_NEAR(b.area_px, std::numbers::pi * 50 * 50, 0.002 * std::numbers::pi * 50 * 50);
}

TEST(Render, moving_the_hidden_board_by_d_moves_the_picture_by_d) {
  const BoardTruth nominal = board_at({});
  const View v = over(nominal, {10, 10});
  for (const Vec2 d : {Vec2{0.5, 0}, Vec2{0, 0.5}, Vec2{-0.317, 0.233}, Vec2{0.0031, -0.0047}}) {
    BoardPlacement p;
    p.shift = d;
    const BoardTruth moved = board_at(p);
    const Blob b = moments(render(v, &moved, 1), v.greys);
    EXPECT_NEAR(b.at.x, 319.5 + d.x / 0.02, 0.01) << "columns grow with X";
    EXPECT_NEAR(b.at.y, 255.5 - d.y / 0.02, 0.01) << "rows grow against Y";
  }
  BoardPlacement turn;
  turn.rotation_rad = 0.02;
  const BoardTruth turned = board_at(turn);
  const Vec2 expected = rotated({10, 10}, 0.02) - Vec2{10, 10};
  const Blob b = moments(render(v, &turned, 1), v.greys);
  EXPECT_NEAR(b.at.x, 319.5 + expected.x / 0.02, 0.01);
  EXPECT_NEAR(b.at.y, 255.5 - expected.y / 0.02, 0.01);
}

TEST(Render, has_no_bias_over_sub_pixel_phases) {
  const BoardTruth nominal = board_at({});
  for (int k = 0; k < 16; ++k) {
    View v = over(nominal, {10, 10});
    v.focus.x += k * 0.02 / 16;
    v.focus.y += k * 0.02 * 3 / 16;
    const Blob b = moments(render(v, &nominal, 1), v.greys);
    EXPECT_NEAR(b.at.x, 319.5 - k / 16.0, 0.008);
    EXPECT_NEAR(b.at.y, 255.5 + k * 3 / 16.0, 0.008);
  }
}

TEST(Render, a_mark_that_was_taken_away_is_not_there) {
  BoardTruth board = board_at({});
  board.plan.marks.erase(board.plan.marks.begin());
  const View v = over(board, {10, 10});
  const vision::Image image = render(v, &board, 1);
  EXPECT_EQ(*std::max_element(image.pixels.begin(), image.pixels.end()), 95) << "bare board";
}

TEST(Render, without_light_or_board_there_is_nothing_to_see) {
  const BoardTruth board = board_at({});
  View v = over(board, {10, 10});
  v.light = false;
  vision::Image image = render(v, &board, 1);
  EXPECT_EQ(*std::max_element(image.pixels.begin(), image.pixels.end()), 6);
  v.light = true;
  image = render(v, nullptr, 1);
  EXPECT_EQ(*std::max_element(image.pixels.begin(), image.pixels.end()), 45);
}

TEST(Render, noise_has_the_sigma_asked_for_and_depends_on_the_seed_alone) {
  const BoardTruth board = board_at({});
  View v = over(board, {90, 30});  // bare board
  v.noise = 4;
  const vision::Image a = render(v, &board, 9), again = render(v, &board, 9), other = render(v, &board, 10);
  EXPECT_EQ(a.pixels, again.pixels);
  EXPECT_NE(a.pixels, other.pixels);
  double sum = 0, square = 0;
  for (const auto p : a.pixels) sum += p, square += double{1} * p * p;
  const double n = static_cast<double>(a.pixels.size()), mean = sum / n;
  EXPECT_NEAR(mean, 95, 0.05);
  EXPECT_NEAR(std::sqrt(square / n - mean * mean), std::sqrt(16 + 1.0 / 12), 0.05);
}

TEST(Render, motion_while_exposed_smears_and_shifts_by_half_the_displacement) {
  const BoardTruth board = board_at({});
  View v = over(board, {10, 10});
  v.drift = {0.2, 0};  // 10 px
  const vision::Image image = render(v, &board, 1);
  const Blob b = moments(image, v.greys);
  EXPECT_NEAR(b.at.x, 319.5 - 5, 0.1) << "the camera moved on, the mark fell back";
  EXPECT_NEAR(b.at.y, 255.5, 0.02);
}

TEST(Render, parts_stand_in_the_picture_where_they_stand_on_the_board) {
  BoardPlacement p;
  p.rotation_rad = -0.015;
  p.shift = {0.4, 0.3};
  const BoardTruth board = board_at(p);
  View v = over(board, {60, 40});
  v.mm_per_px = 0.06;
  const vision::Image image = render(v, &board, 1);
  // Judge: a point is dark where the machine point under the pixel lies in the part's true rectangle.
  const auto solids = solids_of({}, &board);
  const Solid& relay = solids[1];
  int wrong = 0, dark = 0;
  for (int y = 0; y < image.height; y += 3)
    for (int x = 0; x < image.width; x += 3) {
      const Vec2 m{v.focus.x + (x - 319.5) * 0.06, v.focus.y - (y - 255.5) * 0.06};
      const Vec2 own = rotated(m - Vec2{relay.centre.x, relay.centre.y}, -relay.rotation_rad);
      const double depth = std::max(std::abs(own.x) - 10, std::abs(own.y) - 5);
      if (std::abs(depth) < 0.3) continue;
      const bool is_dark = image.at(x, y) < 78;
      dark += is_dark;
      wrong += is_dark != (depth < 0);
    }
  EXPECT_EQ(wrong, 0);
  EXPECT_GT(dark, 1000);
}

}  // namespace
}  // namespace gantry::sim
