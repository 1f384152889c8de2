#include "core/error.hpp"

#include <gtest/gtest.h>

namespace gantry {
namespace {

Result<int> half(int n) {
  if (n % 2 != 0) return fail(Fault::BadValue, "odd", "board.yaml:14:7");
  return n / 2;
}

TEST(Error, text_has_place_message_and_code) {
  EXPECT_EQ(to_text({Fault::UnknownKey, "unknown key 'sped'; did you mean 'speed'?", "board.yaml:14:7"}),
            "board.yaml:14:7: unknown key 'sped'; did you mean 'speed'? [G402]");
}

TEST(Error, text_without_a_place_starts_with_the_message) {
  EXPECT_EQ(to_text({Fault::Internal, "oops", ""}), "oops [G900]");
}

TEST(Error, result_carries_value_or_error) {
  EXPECT_EQ(half(4).value(), 2);
  ASSERT_FALSE(half(3));
  EXPECT_EQ(half(3).error().fault, Fault::BadValue);
  EXPECT_EQ(half(3).error().where, "board.yaml:14:7");
}

}  // namespace
}  // namespace gantry
