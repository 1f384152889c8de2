// Work offset and surface from measured points, and the camera's convention.
#include <Eigen/Geometry>
#include <gtest/gtest.h>
#include <random>

#include "vision/camera_model.hpp"
#include "vision/fit_offset.hpp"
#include "vision/fit_surface.hpp"

namespace gantry::vision {
namespace {

constexpr std::uint64_t kSeed = 7;
const std::vector<Vec2> kCorners{{5, 5}, {115, 5}, {115, 75}, {5, 75}};

std::vector<MarkPair> placed(const std::vector<Vec2>& nominal, Vec2 shift, double rotation) {
  std::vector<MarkPair> out;
  for (std::size_t i = 0; i < nominal.size(); ++i)
    out.push_back({std::string(1, static_cast<char>('A' + i)), nominal[i], rotated(nominal[i], rotation) + shift});
  return out;
}

TEST(FitOffset, returns_turn_about_the_origin_and_then_shift) {
  for (std::size_t n = 2; n <= 4; ++n) {
    const auto marks =
        placed({kCorners.begin(), kCorners.begin() + static_cast<std::ptrdiff_t>(n)}, {1.3, -0.7}, 0.014);
    const auto fit = fit_offset(marks, {});
    ASSERT_TRUE(fit) << fit.error().message;
    EXPECT_NEAR(fit->shift_mm.x, 1.3, 1e-12);
    EXPECT_NEAR(fit->shift_mm.y, -0.7, 1e-12);
    EXPECT_NEAR(fit->rotation_rad, 0.014, 1e-12);
    EXPECT_LT(fit->max_mm, 1e-12);
    EXPECT_EQ(fit->redundancy, static_cast<int>(2 * n) - 3);
  }
}

TEST(FitOffset, agrees_with_eigens_umeyama_on_noisy_marks) {
  std::mt19937_64 random(kSeed);
  std::uniform_real_distribution<double> u(-1, 1);
  for (int k = 0; k < 500; ++k) {
    std::vector<MarkPair> marks;
    const int n = 2 + k % 7;
    const double turn = 3 * u(random);
    const Vec2 shift{50 * u(random), 50 * u(random)};
    Eigen::MatrixXd a(2, n), b(2, n);
    for (int i = 0; i < n; ++i) {
      const Vec2 p{100 * u(random), 100 * u(random)}, q = rotated(p, turn) + shift + Vec2{u(random), u(random)};
      marks.push_back({"m", p, q});
      a.col(i) << p.x, p.y;
      b.col(i) << q.x, q.y;
    }
    const Eigen::MatrixXd t = Eigen::umeyama(a, b, false);
    const OffsetFit fit = fit_rigid(marks);
    EXPECT_NEAR(std::remainder(fit.rotation_rad - std::atan2(t(1, 0), t(0, 0)), 2 * M_PI), 0, 1e-9);
    EXPECT_NEAR(fit.shift_mm.x, t(0, 2), 1e-7);
    EXPECT_NEAR(fit.shift_mm.y, t(1, 2), 1e-7);
  }
}

TEST(FitOffset, needs_two_marks_at_two_places) {
  EXPECT_EQ(fit_offset({}, {}).error().fault, Fault::MarksTooFew);
  EXPECT_EQ(fit_offset(placed({{5, 5}}, {}, 0), {}).error().fault, Fault::MarksTooFew);
  EXPECT_EQ(fit_offset(placed({{5, 5}, {5, 5}, {5, 5}}, {}, 0), {}).error().fault, Fault::MarksTooFew);
}

TEST(FitOffset, names_the_mark_that_disagrees_and_does_not_drop_it) {
  auto marks = placed(kCorners, {1, 1}, 0.01);
  marks[2].found_mm = marks[2].found_mm + Vec2{0.4, 0.1};
  const auto fit = fit_offset(marks, {});
  ASSERT_FALSE(fit);
  EXPECT_EQ(fit.error().fault, Fault::ResidualTooLarge);
  EXPECT_NE(fit.error().message.find("without C the others agree"), std::string::npos) << fit.error().message;
  for (const char* name : {"A 0.", "B 0.", "C 0.", "D 0."})
    EXPECT_NE(fit.error().message.find(name), std::string::npos) << fit.error().message;
}

TEST(FitOffset, says_when_it_cannot_tell_which_mark_is_wrong) {
  auto three = placed({kCorners.begin(), kCorners.begin() + 3}, {}, 0);
  three[0].found_mm.x += 0.5;
  EXPECT_NE(fit_offset(three, {}).error().message.find("cannot tell which"), std::string::npos);
  auto two_bad = placed(kCorners, {}, 0);
  two_bad[0].found_mm.x += 0.5, two_bad[1].found_mm.y += 0.7;
  EXPECT_NE(fit_offset(two_bad, {}).error().message.find("no single mark"), std::string::npos);
}

TEST(FitOffset, a_stretched_board_shows_as_residuals_and_is_refused) {
  auto marks = placed(kCorners, {}, 0);
  for (MarkPair& m : marks) m.found_mm = m.found_mm * 1.002;
  EXPECT_EQ(fit_offset(marks, {}).error().fault, Fault::ResidualTooLarge);
}

TEST(FitOffset, one_mark_off_by_more_than_the_rule_allows_is_never_accepted) {
  std::mt19937_64 random(kSeed);
  std::normal_distribution<double> noise(0, 0.003);
  std::uniform_real_distribution<double> turn(0, 2 * M_PI);
  int accepted = 0;
  for (int k = 0; k < 1000; ++k) {
    auto marks = placed(kCorners, {1.2, -0.4}, 0.02);
    for (MarkPair& m : marks) m.found_mm = m.found_mm + Vec2{noise(random), noise(random)};
    EXPECT_TRUE(fit_offset(marks, {}));
    MarkPair& wrong = marks[static_cast<std::size_t>(k % 4)];
    wrong.found_mm = wrong.found_mm + rotated({0.3, 0}, turn(random));
    accepted += fit_offset(marks, {}).has_value();
  }
  EXPECT_EQ(accepted, 0) << "seed " << kSeed;
}

TEST(FitOffset, refuses_a_board_that_lies_where_it_cannot) {
  EXPECT_NE(fit_offset(placed(kCorners, {6, 0}, 0), {}).error().message.find("6.000 mm"), std::string::npos);
  EXPECT_NE(fit_offset(placed(kCorners, {}, 0.1), {}).error().message.find("turned"), std::string::npos);
  auto lost = placed(kCorners, {}, 0);
  lost[0].found_mm.x = std::nan("");
  EXPECT_FALSE(fit_offset(lost, {}));
}

TEST(FitSurface, one_touch_is_level_two_give_the_tilt_along_their_line_three_a_plane) {
  const auto height = [](Vec2 p) { return 0.4 + 0.003 * p.x - 0.002 * p.y; };
  std::vector<TouchedHeight> touches;
  const std::vector<Vec2> at{{10, 10}, {110, 10}, {60, 70}, {20, 60}};
  for (const Vec2 p : at) touches.push_back({"t", p, height(p)});

  const auto one = fit_surface({touches.data(), 1}, {});
  ASSERT_TRUE(one);
  EXPECT_EQ(one->slope, Vec2{});
  EXPECT_DOUBLE_EQ(one->at({50, 50}), height({10, 10}));

  const auto two = fit_surface({touches.data(), 2}, {});
  ASSERT_TRUE(two);
  EXPECT_NEAR(two->slope.x, 0.003, 1e-12);
  EXPECT_NEAR(two->slope.y, 0, 1e-12);
  EXPECT_NEAR(two->at({110, 10}), height({110, 10}), 1e-12);
  EXPECT_EQ(two->rank, 2);

  for (std::size_t n : {3U, 4U}) {
    const auto plane = fit_surface({touches.data(), n}, {});
    ASSERT_TRUE(plane);
    EXPECT_NEAR(plane->slope.x, 0.003, 1e-12);
    EXPECT_NEAR(plane->slope.y, -0.002, 1e-12);
    EXPECT_NEAR(plane->z0_mm, 0.4, 1e-12);
    EXPECT_EQ(plane->redundancy, static_cast<int>(n) - 3);
  }
}

TEST(FitSurface, refuses_heights_that_fit_no_plane_and_boards_that_stand_askew) {
  std::vector<TouchedHeight> touches{{"a", {0, 0}, 0}, {"b", {100, 0}, 0}, {"c", {100, 60}, 0}, {"d", {0, 60}, 0.9}};
  const auto bent = fit_surface(touches, {});
  ASSERT_FALSE(bent);
  EXPECT_EQ(bent.error().fault, Fault::HeightsDisagree);
  EXPECT_NE(bent.error().message.find("d +0.225 mm"), std::string::npos) << bent.error().message;
  touches = {{"a", {0, 0}, 0}, {"b", {100, 0}, 3}, {"c", {100, 60}, 3}};
  EXPECT_NE(fit_surface(touches, {}).error().message.find("tilted"), std::string::npos);
  EXPECT_FALSE(fit_surface({}, {}));
  touches[0].z_mm = std::nan("");
  EXPECT_FALSE(fit_surface(touches, {}));
}

TEST(CameraModel, column_grows_with_x_and_row_against_y_from_the_images_centre) {
  config::CameraConfig config;
  config.width_px = 1280, config.height_px = 1024, config.mm_per_px = 0.01;
  const CameraModel camera(config);
  EXPECT_EQ(camera.to_mm({639.5, 511.5}), (Vec2{0, 0}));
  const Vec2 right = camera.to_mm({739.5, 511.5}), below = camera.to_mm({639.5, 611.5});
  EXPECT_NEAR(right.x, 1, 1e-12);
  EXPECT_NEAR(below.y, -1, 1e-12);
  const Vec2 back = camera.to_px(camera.to_mm({12.25, 987.5}));
  EXPECT_NEAR(back.x, 12.25, 1e-9);
  EXPECT_NEAR(back.y, 987.5, 1e-9);
}

}  // namespace
}  // namespace gantry::vision
