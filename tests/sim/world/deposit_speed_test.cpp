#include "sim/world/deposit_speed.hpp"

#include <cmath>
#include <functional>
#include <gtest/gtest.h>
#include <vector>

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

DepositSpeed judged(std::initializer_list<Shot> shots, double asked, double tolerance = 0.05) {
  std::vector<const Shot*> all;
  for (const Shot& shot : shots) all.push_back(&shot);
  return speed_of(all, {asked, tolerance}, kSync_s).value();
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

TEST(DepositSpeed, that_it_kept_is_the_one_farthest_from_what_was_asked) {
  const auto kept = [](std::function<double(double)> v) { return judged({seen(2, v)}, 20).held_mm_s.value_or(-1); };
  EXPECT_NEAR(kept([](double) { return 20.0; }), 20, 1e-6);
  EXPECT_NEAR(kept([](double) { return 18.0; }), 18, 1e-6);
  EXPECT_NEAR(kept([](double t) { return t > 1 ? 23.0 : 20.0; }), 23, 1e-3);
  EXPECT_NEAR(kept([](double t) { return t > 1 && t < 1.2 ? 10.0 : 20.0; }), 10, 0.3);
  EXPECT_NEAR(kept([](double t) { return t > 1 && t < 1.2 ? 0.0 : 20.0; }), 0, 0.1) << "it stood";
  const auto v = [](double t) { return std::max(5.0, 20 - 300 * std::max(0.0, 0.05 - std::abs(t - 1))); };
  EXPECT_NEAR(kept(v), 20, 0.4) << "a corner is passed in 100 ms, and keeps no speed";
}

/// Corner by corner it never keeps a speed, and creeps all the same; a single corner takes as long as its axes do.
TEST(DepositSpeed, that_it_crept_at_is_told_however_that_changed) {
  const auto kept = [](std::function<double(double)> v) { return judged({seen(3, v)}, 20).held_mm_s.value_or(-1); };
  for (const double lasts : {0.15, 0.3, 1.0}) {
    const auto creeps = [&](double t) { return t > 1 && t < 1 + lasts ? 2.4 + 2 * std::sin(150 * t) : 20.0; };
    EXPECT_NEAR(kept(creeps), 2.4, 2.0) << lasts;
    const auto corner = [&](double t) { return 20 * std::min(1.0, std::abs(t - 1.5) / lasts); };
    EXPECT_NEAR(kept(corner), 20, 0.4) << lasts;
  }
}

/// What a corner leaves of the speed, where it is within the tolerance again, is the beginning of another run.
TEST(DepositSpeed, a_corner_is_none_that_it_kept_however_small_the_tolerance) {
  for (const double tolerance : {0.01, 0.015, 0.02, 0.05}) {
    const auto v = [](double t) { return std::max(5.0, 20 - 300 * std::max(0.0, 0.05 - std::abs(t - 1))); };
    EXPECT_NEAR(judged({seen(2, v)}, 20, tolerance).held_mm_s.value_or(0), 20, 20 * tolerance) << tolerance;
  }
}

/// Of a slow bead a window is longer than a corner, and each that holds all of the corner has the same mean.
TEST(DepositSpeed, a_slow_bead_that_stops_in_a_corner_keeps_its_speed) {
  for (const double asked : {1.0, 2.0, 3.0, 5.0, 8.0}) {
    const auto v = [&](double t) { return asked * std::min(1.0, std::abs(t - 2) / 0.013); };
    EXPECT_NEAR(judged({seen(4, v)}, asked).held_mm_s.value_or(0), asked, 0.02 * asked);
    const auto slower = [&](double t) { return t > 2 && t < 4 ? 0.8 * asked : asked; };
    EXPECT_NEAR(judged({seen(6, slower)}, asked).held_mm_s.value_or(0), 0.8 * asked, 0.02 * asked);
  }
}

/// The speed of axes that brake at full jerk and acceleration from `v` by `d` and speed up again, t from the lowest,
/// by steps of a microsecond.
std::function<double(double)> corner(double v, double d, double a_max, double j_max, double middle_s) {
  const double peak = std::min(a_max, std::sqrt(d * j_max)), ramp = peak / j_max, flat = d / peak - ramp;
  std::vector<double> rise{0};
  constexpr double kFine = 1e-6;
  double a = 0;
  for (double t = 0; t < 2 * ramp + flat; t += kFine) {
    a = t < ramp ? j_max * t : t < ramp + flat ? peak : std::max(0.0, peak - j_max * (t - ramp - flat));
    rise.push_back(rise.back() + a * kFine);
  }
  return [=](double t) {
    const auto n = static_cast<std::size_t>(std::abs(t - middle_s) / kFine);
    return n >= rise.size() ? v : std::min(v, v - d + rise[n]);
  };
}

TEST(DepositSpeed, a_corner_does_not_sag_however_soft_its_axes_are) {
  for (const auto& [a_max, j_max] : {std::pair{500.0, 5000.0}, {3000.0, 50000.0}, {8000.0, 400000.0}})
    for (const double asked : {2.0, 20.0, 90.0})
      for (const double part : {0.1, 0.3, 0.6, 1.0}) {
        const Shot shot = seen(3, corner(asked, part * asked, a_max, j_max, 1.5));
        const Shot* all[] = {&shot};
        const auto v = speed_of(all, {asked, 0.05, a_max, j_max}, kSync_s);
        EXPECT_FALSE(v->sag) << a_max << " " << asked << " " << part;
        EXPECT_LT(v->least_mm_s, asked * (1.05 - part * 0.3)) << "it is a corner";
      }
}

/// From 20 down to 10 and up again, evenly, in `lasts`: axes of 3000 mm/s^2 and 50,000 mm/s^3 need 2 sqrt(10 / 50000) =
/// 28 ms for each way.
TEST(DepositSpeed, what_is_slow_for_longer_than_a_corner_sags) {
  const auto sag = [](double lasts, int times) {
    const auto v = [&](double t) {
      const double since = t - 1;
      if (since < 0 || since > lasts * times) return 20.0;
      return 20 - 10 * (1 - std::abs(2 * (since / lasts - std::floor(since / lasts)) - 1));
    };
    const Shot shot = seen(2 + lasts * times, v);
    const Shot* all[] = {&shot};
    return speed_of(all, {20, 0.05, 3000, 50000}, kSync_s)->sag;
  };
  EXPECT_FALSE(sag(0.1, 1));
  ASSERT_TRUE(sag(0.2, 1));
  EXPECT_NEAR(sag(0.2, 1)->low_mm_s, 10, 0.6);
  EXPECT_NEAR(sag(0.2, 1)->lasts_s, 0.2 * 0.9, 0.02) << "below 19 mm/s";
  EXPECT_FALSE(sag(0.08, 8)) << "many corners, each with its speed between them";
}

/// A bead that begins from rest after it has stood (`start_dwell`): standing there is asked for.
TEST(DepositSpeed, a_stand_before_a_bead_begins_is_no_speed_that_it_kept) {
  Shot shot = seen(2, [](double t) { return std::min(20.0, 2000 * t); });
  for (std::size_t i = 2; i < shot.since.size(); ++i) shot.since[i] += 300;
  const DepositSpeed v = judged({shot}, 20);
  EXPECT_NEAR(v.held_mm_s.value_or(0), 20, 0.01);
  EXPECT_GT(v.within_tolerance, 0.97);
  EXPECT_NEAR(v.stood_s, 0.3, 0.005);
}

/// 2.5 um a count: at 1 mm/s that is more than twice what a sync goes.
TEST(DepositSpeed, of_a_slow_bead_is_not_that_of_its_motors_counts) {
  for (const double asked : {1.0, 5.0, 20.0, 100.0}) {
    Shot shot = seen(2, [&](double) { return asked; });
    for (Vec3& p : shot.path) p.x = std::round(p.x / 0.0025) * 0.0025;
    const DepositSpeed v = judged({shot}, asked);
    EXPECT_NEAR(v.held_mm_s.value_or(0), asked, 0.02 * asked);
    EXPECT_EQ(v.within_tolerance, 1) << asked;
  }
}

TEST(DepositSpeed, is_good_within_the_tolerance_of_its_material) {
  const Shot shot = seen(2, [](double t) { return t < 1 ? 20.0 : 18.2; });  // 9 % too slow along 18.2 of 38.2 mm
  EXPECT_NEAR(judged({shot}, 20, 0.05).within_tolerance, 20 / 38.2, 0.01);
  EXPECT_EQ(judged({shot}, 20, 0.10).within_tolerance, 1);
}

TEST(DepositSpeed, is_not_known_of_what_was_not_open_does_not_move_or_has_no_speed) {
  Shot shut = seen(0.5, [](double) { return 20.0; });
  shut.closed = shut.opened;
  const Shot stands = seen(0.5, [](double) { return 0.0; }), moves = seen(0.5, [](double) { return 20.0; });
  EXPECT_FALSE(speed_of(std::array{static_cast<const Shot*>(&shut)}, {20}, kSync_s));
  EXPECT_FALSE(speed_of(std::array{static_cast<const Shot*>(&stands)}, {20}, kSync_s));
  EXPECT_FALSE(speed_of(std::array{&moves}, {0}, kSync_s));
  EXPECT_TRUE(speed_of(std::array{&moves}, {20}, kSync_s));
}

}  // namespace
}  // namespace gantry::sim
