#include "core/rt/fixed_vector.hpp"

#include <gtest/gtest.h>
#include <numeric>

namespace gantry::rt {
namespace {

TEST(FixedVector, takes_up_to_its_size_and_refuses_one_more) {
  FixedVector<int, 3> v;
  EXPECT_TRUE(v.empty());
  EXPECT_TRUE(v.push_back(1) && v.push_back(2) && v.push_back(3));
  EXPECT_FALSE(v.push_back(4));
  EXPECT_EQ(v.size(), 3u);
  EXPECT_EQ(v.back(), 3);
  EXPECT_EQ(std::accumulate(v.begin(), v.end(), 0), 6);
  v.clear();
  EXPECT_TRUE(v.empty());
  EXPECT_TRUE(v.push_back(7));
  EXPECT_EQ(v[0], 7);
}

TEST(FixedVector, may_cross_the_rt_boundary) {
  static_assert(std::is_trivially_copyable_v<FixedVector<double, 4>>);
  static_assert(FixedVector<int, 5>::capacity() == 5);
}

}  // namespace
}  // namespace gantry::rt
