#include "recipes/near_points.hpp"

#include <algorithm>
#include <gtest/gtest.h>
#include <random>

namespace gantry::recipes {
namespace {

TEST(NearPoints, are_those_that_a_look_at_all_of_them_finds) {
  constexpr unsigned kSeed = 4;
  std::mt19937 random(kSeed);
  // On a coarse grid, so that many are equally near and some lie on one another.
  const auto spot = [&] { return Vec3{double(random() % 20), double(random() % 15), double(random() % 2)}; };
  for (int round = 0; round < 100; ++round) {
    std::vector<Vec3> all(1 + random() % 300);
    for (Vec3& p : all) p = spot();
    std::vector<bool> in(all.size(), true);
    NearPoints points(all);
    for (int change = 0; change < 60; ++change) {
      const auto i = static_cast<std::uint32_t>(random() % all.size());
      in[i] = random() % 3 == 0;
      in[i] ? points.put_in(i) : points.take_out(i);
      const Vec3 at = spot();
      const std::size_t count = 1 + random() % 12;
      std::vector<std::pair<double, std::uint32_t>> judged;
      for (std::uint32_t k = 0; k < all.size(); ++k)
        if (in[k]) judged.emplace_back(norm(all[k] - at), k);
      std::sort(judged.begin(), judged.end());
      judged.resize(std::min(judged.size(), count));
      std::vector<std::uint32_t> wanted, found;
      for (const auto& [mm, k] : judged) wanted.push_back(k);
      points.nearest(at, count, found);
      ASSERT_EQ(found, wanted) << "seed " << kSeed << ", round " << round;
    }
  }
}

}  // namespace
}  // namespace gantry::recipes
