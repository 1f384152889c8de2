#include "sim/world/deposit_speed.hpp"

#include <cmath>
#include <functional>
#include <gtest/gtest.h>

namespace gantry::sim {
namespace {

constexpr double kSync_s = 0.001;

/// The needle along x at v(t), seen at each sync, the valve open from half a sync before the first to half a sync after
/// the last. Where it stands no point is kept, as in the world.
Shot seen(double duration_s, const std::function<double(double)>& v) {
  Shot shot;
  const auto n = static_cast<std::uint32_t>(std::lround(duration_s / kSync_s));
  const int fine = 100;
  double x = 0;
  const auto go = [&](double from, double to) {
    for (int k = 0; k < fine; ++k) x += v(from + (to - from) * (k + 0.5) / fine) * (to - from) / fine;
  };
  shot.path.push_back({x, 0, 0.3}), shot.since.push_back(0);
  go(-kSync_s / 2, 0);
  for (std::uint32_t k = 0; k <= n; ++k) {
    if (k > 0) go((k - 1) * kSync_s, k * kSync_s);
    if (x == shot.path.back().x) continue;
    shot.path.push_back({x, 0, 0.3}), shot.since.push_back(k + 1);
  }
  go(n * kSync_s, (n + 0.5) * kSync_s);
  shot.path.push_back({x, 0, 0.3}), shot.since.push_back(n + 2);
  shot.opened = Time(std::chrono::nanoseconds(1'000'000'000));
  shot.closed = shot.opened + std::chrono::nanoseconds(std::llround((duration_s + kSync_s) * 1e9));
  return shot;
}

DepositSpeed judged(std::initializer_list<Shot> shots, double asked) {
  std::vector<const Shot*> all;
  for (const Shot& shot : shots) all.push_back(&shot);
  return speed_of(all, asked, kSync_s).value();
}

TEST(DepositSpeed, of_a_steady_bead_is_its_speed) {
  const DepositSpeed v = judged({seen(2, [](double) { return 20.0; })}, 20);
  EXPECT_EQ(v.asked_mm_s, 20);
  EXPECT_NEAR(v.least_mm_s, 20, 1e-6);
  EXPECT_NEAR(v.most_mm_s, 20, 1e-6);
  EXPECT_EQ(v.within_5_percent, 1);
  EXPECT_NEAR(v.volume_per_length, 1, 1e-6);
}

TEST(DepositSpeed, of_one_that_is_steadily_too_slow_has_no_share_and_more_on_each_length) {
  const DepositSpeed v = judged({seen(2, [](double) { return 18.0; })}, 20);
  EXPECT_EQ(v.within_5_percent, 0);
  EXPECT_NEAR(v.volume_per_length, 20.0 / 18, 1e-6);
}

/// 1 s at 20, linearly down to 10 in 0.1 s, back in 0.1 s, 1 s at 20: what is within 5 % is known in closed form.
TEST(DepositSpeed, of_a_corner_is_known_by_its_integral) {
  const auto v_of = [](double t) {
    const double from_middle = std::abs(t - 1.1);
    return from_middle >= 0.1 ? 20.0 : 10.0 + 100.0 * from_middle;
  };
  const DepositSpeed v = judged({seen(2.2, v_of)}, 20);
  const double length = 40 + 0.2 * 15, slow = 2 * (0.09 * (10 + 19) / 2);  // below 19 mm/s
  EXPECT_NEAR(v.least_mm_s, 10, 0.3) << "over five syncs";
  EXPECT_NEAR(v.most_mm_s, 20, 1e-3);
  EXPECT_NEAR(v.within_5_percent, 1 - slow / length, 0.005);
  EXPECT_NEAR(v.volume_per_length, 2.2 * 20 / length, 0.001);
}

TEST(DepositSpeed, a_needle_that_stands_with_its_valve_open_is_seen) {
  const DepositSpeed v = judged({seen(1.2, [](double t) { return t > 0.5 && t < 0.7 ? 0.0 : 20.0; })}, 20);
  EXPECT_LT(v.least_mm_s, 0.5);
  EXPECT_NEAR(v.volume_per_length, 1.2, 0.005);
}

TEST(DepositSpeed, of_a_bead_that_was_joined_is_that_of_all_its_shots) {
  const auto steady = [](double v) { return [v](double) { return v; }; };
  const DepositSpeed v = judged({seen(1, steady(20)), seen(1, steady(30))}, 20);
  EXPECT_NEAR(v.least_mm_s, 20, 1e-6);
  EXPECT_NEAR(v.most_mm_s, 30, 1e-6);
  EXPECT_NEAR(v.within_5_percent, 0.4, 0.002);
  EXPECT_NEAR(v.volume_per_length, 2 * 20 / 50.0, 1e-3);
}

TEST(DepositSpeed, is_not_known_of_what_was_not_open_does_not_move_or_has_no_speed) {
  Shot shut = seen(0.5, [](double) { return 20.0; });
  shut.closed = shut.opened;
  const Shot stands = seen(0.5, [](double) { return 0.0; }), moves = seen(0.5, [](double) { return 20.0; });
  EXPECT_FALSE(speed_of(std::array{static_cast<const Shot*>(&shut)}, 20, kSync_s));
  EXPECT_FALSE(speed_of(std::array{static_cast<const Shot*>(&stands)}, 20, kSync_s));
  EXPECT_FALSE(speed_of(std::array{&moves}, 0, kSync_s));
  EXPECT_TRUE(speed_of(std::array{&moves}, 20, kSync_s));
}

}  // namespace
}  // namespace gantry::sim
