// An order is judged by all orders that there are where features are few, and by the order of the file where they are
// many; what must come before what is judged pair by pair.
#include "recipes/shortest.hpp"

#include <algorithm>
#include <chrono>
#include <gtest/gtest.h>
#include <limits>
#include <numeric>
#include <random>

namespace gantry::recipes {
namespace {

using Indices = std::vector<std::size_t>;

/// Random features: dots, and with `beads` as many beads, over a board of 100 mm.
std::vector<Ends> random_ends(std::mt19937& random, std::size_t count, bool beads) {
  std::uniform_real_distribution<double> mm(0, 100);
  std::vector<Ends> ends(count);
  for (Ends& each : ends) {
    each.from = {mm(random), mm(random), 3};
    each.to = beads && random() % 2 == 0 ? Vec3{mm(random), mm(random), 4} : each.from;
  }
  return ends;
}

/// Rows of one to three features; some wait for others, never in a circle.
Precedence random_rows(std::mt19937& random, std::size_t count, std::size_t waits) {
  std::vector<std::uint32_t> row_of;
  for (std::uint32_t row = 0; row_of.size() < count; ++row)
    row_of.resize(std::min(count, row_of.size() + 1 + random() % 3), row);
  const std::uint32_t rows = row_of.back() + 1;
  std::vector<std::uint32_t> rank(rows);  // in a hidden order, which need not be that of the file
  std::iota(rank.begin(), rank.end(), 0u);
  std::shuffle(rank.begin(), rank.end(), random);
  std::vector<std::vector<std::uint32_t>> after(rows);
  for (std::size_t i = 0; i < waits; ++i) {
    const auto a = static_cast<std::uint32_t>(random() % rows), b = static_cast<std::uint32_t>(random() % rows);
    if (rank[a] < rank[b]) after[b].push_back(a);
  }
  Precedence before = by_rows(after, row_of);
  const Indices order = in_rows(before);
  for (std::size_t i = 0; i < waits; ++i) {  // and features by themselves
    const std::size_t a = random() % count, b = random() % count;
    if (a < b) before.features[order[b]].push_back(static_cast<std::uint32_t>(order[a]));
  }
  return before;
}

bool kept(const Precedence& before, const Indices& order) {
  Indices place(order.size());
  for (std::size_t i = 0; i < order.size(); ++i) place[order[i]] = i;
  for (std::size_t f = 0; f < order.size(); ++f) {
    for (const std::uint32_t earlier : before.features[f])
      if (place[earlier] > place[f]) return false;
    for (std::size_t e = 0; e < order.size(); ++e) {
      const auto& rows = before.rows[before.row[f]];
      if (std::find(rows.begin(), rows.end(), before.row[e]) != rows.end() && place[e] > place[f]) return false;
    }
  }
  return true;
}

bool each_once(const Indices& order, std::size_t count) {
  Indices sorted = order, all(count);
  std::sort(sorted.begin(), sorted.end());
  std::iota(all.begin(), all.end(), std::size_t{0});
  return sorted == all;
}

double least_of_all_orders(const std::vector<Ends>& ends, const Precedence& before) {
  Indices order(ends.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  double least = std::numeric_limits<double>::infinity();
  do
    if (const double mm = travel_mm(ends, order); mm < least && kept(before, order)) least = mm;
  while (std::next_permutation(order.begin(), order.end()));
  return least;
}

Precedence nothing_waits(std::size_t count) {
  std::vector<std::uint32_t> row_of(count);
  std::iota(row_of.begin(), row_of.end(), 0u);
  return by_rows(std::vector<std::vector<std::uint32_t>>(count), row_of);
}

TEST(ShortestOrder, of_a_few_features_is_the_best_of_all_orders_or_nearly) {
  constexpr unsigned kSeed = 1;
  std::mt19937 random(kSeed);
  double worst = 1;
  int best = 0, all = 0;
  for (int round = 0; round < 300; ++round) {
    const std::size_t count = 1 + static_cast<std::size_t>(round) % 8;
    const auto ends = random_ends(random, count, round % 2 == 0);
    const Precedence before = random_rows(random, count, static_cast<std::size_t>(round) / 8 % 4);
    const Indices order = shortest_order(ends, before);
    ASSERT_TRUE(each_once(order, count));
    ASSERT_TRUE(kept(before, order)) << "seed " << kSeed << ", round " << round;
    const double least = least_of_all_orders(ends, before), mm = travel_mm(ends, order);
    EXPECT_LE(mm, 1.03 * least + 1e-9) << "seed " << kSeed << ", round " << round;
    if (least > 0) worst = std::max(worst, mm / least);
    ++all, best += mm <= least + 1e-9;
  }
  RecordProperty("worst", std::to_string(worst));
  RecordProperty("best", best);
  std::printf("%d of %d are the best, the worst is %.4f times it\n", best, all, worst);
}

TEST(ShortestOrder, keeps_what_comes_before_what_and_is_never_longer_than_the_file) {
  constexpr unsigned kSeed = 2;
  std::mt19937 random(kSeed);
  for (int round = 0; round < 200; ++round) {
    const std::size_t count = 2 + random() % 120;
    const auto ends = random_ends(random, count, random() % 2 == 0);
    const Precedence before = random_rows(random, count, random() % (2 * count));
    const Indices in_file = in_rows(before), order = shortest_order(ends, before);
    ASSERT_TRUE(each_once(in_file, count)) << "round " << round;
    ASSERT_TRUE(kept(before, in_file)) << "round " << round;
    ASSERT_TRUE(each_once(order, count)) << "round " << round;
    EXPECT_TRUE(kept(before, order)) << "seed " << kSeed << ", round " << round;
    EXPECT_LE(travel_mm(ends, order), travel_mm(ends, in_file)) << "seed " << kSeed << ", round " << round;
  }
}

TEST(ShortestOrder, of_a_ring_of_dots_goes_round_it) {
  constexpr std::size_t kCount = 90;
  std::vector<Ends> ends(kCount);
  for (std::size_t i = 0; i < kCount; ++i) {  // every 37th is the next in the file
    const double angle = double(i * 37 % kCount) * 2 * 3.14159265358979 / kCount;
    ends[i].from = ends[i].to = {50 * std::cos(angle), 50 * std::sin(angle), 0};
  }
  const double chord = 2 * 50 * std::sin(3.14159265358979 / kCount);
  EXPECT_NEAR(travel_mm(ends, shortest_order(ends, nothing_waits(kCount))), chord * (kCount - 1), 1e-6);
}

TEST(ShortestOrder, is_the_same_again_and_again) {
  std::mt19937 random(5);
  const auto ends = random_ends(random, 400, true);
  const Precedence before = random_rows(random, 400, 60);
  const Indices first = shortest_order(ends, before);
  for (int i = 0; i < 3; ++i) EXPECT_EQ(shortest_order(ends, before), first);
}

TEST(ShortestOrder, of_many_dots_is_about_as_long_as_the_best_is_known_to_be) {
  // Of n random points in a square of area A the shortest round is 0.7124 sqrt(n A) (1 + 0.33 / n) long on the mean
  // (Johnson, McGeoch and Rothberg 1996); a path, which is a round without its last leg, is shorter.
  std::mt19937 random(6);
  constexpr std::size_t kCount = 10000;
  const auto ends = random_ends(random, kCount, false);
  const auto begin = std::chrono::steady_clock::now();
  const double mm = travel_mm(ends, shortest_order(ends, nothing_waits(kCount)));
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin;
  const double best = 0.7124 * std::sqrt(double(kCount) * 100 * 100);
  std::printf("%.1f mm, %.3f of the best on the mean, in %.2f s\n", mm, mm / best, took.count());
  EXPECT_LT(mm, 1.08 * best);
}

}  // namespace
}  // namespace gantry::recipes
