// Speeds at the boundaries of a chain, against the textbook's S-curve: a change of speed by dv, without acceleration at
// both ends, takes 2 sqrt(dv / j), or dv / a + a / j where the acceleration limit is reached, and the mean of both
// speeds times that of length.
#include "motion/path/speeds.hpp"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <random>

namespace gantry::motion {
namespace {

double length_to_change(double v1, double v2, double a, double j) {
  const double dv = std::abs(v2 - v1);
  const double seconds = dv * j <= a * a ? 2 * std::sqrt(dv / j) : dv / a + a / j;
  return 0.5 * (v1 + v2) * seconds;
}

Piece piece(double length, double v_wanted, const Bounds& bounds, bool stop_after = false) {
  Piece p{{}, bounds, v_wanted, stop_after};
  p.geometry.length = length;
  return p;
}

constexpr double kInf = std::numeric_limits<double>::infinity();
constexpr Bounds kBounds{300, 4000, 80'000};

TEST(BoundarySpeeds, a_long_chain_runs_at_what_is_wanted_and_rests_at_its_ends) {
  const std::vector<Piece> chain{piece(500, 50, kBounds), piece(500, 20, kBounds), piece(500, 80, kBounds)};
  EXPECT_EQ(boundary_speeds(chain, 0, 0), (std::vector<double>{0, 20, 20, 0}));
  EXPECT_EQ(boundary_speeds(chain, kInf, kInf), (std::vector<double>{50, 20, 20, 80}));
}

TEST(BoundarySpeeds, a_stop_is_a_stop_and_what_lies_before_it_knows) {
  const std::vector<Piece> chain{piece(500, 50, kBounds), piece(0.05, 50, kBounds, true), piece(500, 50, kBounds)};
  const auto v = boundary_speeds(chain, kInf, kInf);
  EXPECT_EQ(v[2], 0);
  EXPECT_LE(length_to_change(v[1], 0, kBounds.a, kBounds.j), 0.05);
  EXPECT_GT(length_to_change(v[1] * 1.001, 0, kBounds.a, kBounds.j), 0.05);
  EXPECT_EQ(v[3], 50);
}

TEST(BoundarySpeeds, no_piece_and_one_piece) {
  EXPECT_EQ(boundary_speeds({}, 7, 3).size(), 1u);
  const std::vector<Piece> one{piece(10, 500, kBounds)};
  EXPECT_EQ(boundary_speeds(one, kInf, kInf), (std::vector<double>{300, 300})) << "the axes allow no more";
}

TEST(BoundarySpeeds, random_chains_can_be_driven_and_not_one_boundary_faster) {
  constexpr unsigned kSeed = 4;
  std::mt19937_64 random(kSeed);
  const auto between = [&](double low, double high) {
    return std::exp(std::uniform_real_distribution<double>(std::log(low), std::log(high))(random));
  };
  for (int n = 0; n < 3000; ++n) {
    std::vector<Piece> chain;
    for (int i = 0; i < 1 + n % 12; ++i)
      chain.push_back(piece(between(1e-3, 100), between(1, 400),
                            {between(5, 500), between(50, 8000), between(500, 2e5)}, i % 5 == 3));
    const double first = n % 3 == 0 ? 0 : between(1, 400), last = n % 2 == 0 ? 0 : between(1, 400);
    const auto v = boundary_speeds(chain, first, last);
    ASSERT_EQ(v.size(), chain.size() + 1);
    const auto limit = [&](std::size_t k) {
      double most = kInf;
      if (k == 0) most = first;
      if (k == chain.size()) most = last;
      if (k > 0) most = std::min({most, chain[k - 1].v_wanted, chain[k - 1].bounds.v});
      if (k > 0 && chain[k - 1].stop_after) most = 0;
      if (k < chain.size()) most = std::min({most, chain[k].v_wanted, chain[k].bounds.v});
      return most;
    };
    const auto fits = [&](std::size_t k, double v1, double v2) {
      const Bounds& b = chain[k].bounds;
      return length_to_change(v1, v2, b.a, b.j) <= chain[k].geometry.length * (1 + 1e-6);  // found by bisection
    };
    for (std::size_t k = 0; k < v.size(); ++k) {
      SCOPED_TRACE(testing::Message() << "seed " << kSeed << ", chain " << n << ", boundary " << k);
      ASSERT_LE(v[k], limit(k));
      if (k < chain.size()) {
        ASSERT_TRUE(fits(k, v[k], v[k + 1]));
        const Profile p = piece_profile(chain[k], v[k], v[k + 1]);
        ASSERT_NEAR(end_state(p).p, chain[k].geometry.length, 1e-6 * chain[k].geometry.length);
        ASSERT_NEAR(end_state(p).v, v[k + 1], 1e-6 * (1 + v[k + 1]));
      }
      const double faster = v[k] * 1.0001 + 1e-9;
      const bool left = k > 0 && !fits(k - 1, v[k - 1], faster), right = k < chain.size() && !fits(k, faster, v[k + 1]);
      ASSERT_TRUE(faster > limit(k) || left || right) << v[k];
    }
  }
}

}  // namespace
}  // namespace gantry::motion
