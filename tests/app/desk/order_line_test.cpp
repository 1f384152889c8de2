// Orders as lines of JSON.
#include "app/desk/order_line.hpp"

#include <gtest/gtest.h>

namespace gantry::desk {
namespace {

using run::OrderKind;

TEST(OrderLine, a_jog_is_one_line_of_json_and_back) {
  const run::Order order{.kind = OrderKind::Jog, .jog = {.by = {{"X", "10 mm"}, {"C", "-15 deg"}}, .speed = "20 mm/s"}};
  const std::string line = to_line(order);
  EXPECT_EQ(line, R"({"order":"jog","by":{"C":"-15 deg","X":"10 mm"},"speed":"20 mm/s"})");
  const auto read = parse_order(line);
  ASSERT_TRUE(read) << to_text(read.error());
  EXPECT_EQ(read->kind, OrderKind::Jog);
  EXPECT_EQ(read->jog.by, order.jog.by);
  EXPECT_EQ(read->jog.speed, order.jog.speed);
  for (const char* wrong : {R"({"order":"jog"})", R"({"order":"jog","by":{}})", R"({"order":"jog","by":["X","1 mm"]})",
                            R"({"order":"jog","by":{"X":10}})"}) {
    const auto refused = parse_order(wrong);
    ASSERT_FALSE(refused) << wrong;
    EXPECT_NE(refused.error().message.find(R"({"X": "10 mm"})"), std::string::npos) << wrong;
  }
}

}  // namespace
}  // namespace gantry::desk
