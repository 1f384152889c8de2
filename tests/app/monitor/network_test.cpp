#include "app/monitor/network.hpp"

#include <gtest/gtest.h>

namespace gantry::monitor {
namespace {

TEST(Network, this_computer_alone_is_what_nobody_asked_otherwise_for) {
  EXPECT_EQ(NetworkOptions{}.device(), "lo");
  EXPECT_TRUE(check({}));
  EXPECT_TRUE(check({.domain = 230, .interface = "lo", .peers = {"127.0.0.1", "127.1.2.3"}}));
}

struct Wrong {
  NetworkOptions options;
  const char* says;
};

TEST(Network, what_cannot_be_is_refused_before_anything_is_opened) {
  const Wrong cases[] = {
      {{.domain = -1, .interface = "", .peers = {}}, "0 .. 230"},
      {{.domain = 231, .interface = "", .peers = {}}, "0 .. 230"},
      {{.domain = 0, .interface = "eth0\"/><x", .peers = {}}, "no name of a network interface"},
      {{.domain = 0, .interface = "nosuchiface0", .peers = {}}, "there is no network interface"},
      {{.domain = 0, .interface = "averyveryverylongname", .peers = {}}, "no name of a network interface"},
      {{.domain = 0, .interface = "lo", .peers = {"10.0.0.1"}}, "--interface"},
      {{.domain = 0, .interface = "", .peers = {"10.0.0.1"}}, "--interface"},
      {{.domain = 0, .interface = "", .peers = {"robot.example"}}, "no IPv4 address"},
      {{.domain = 0, .interface = "", .peers = {"127.0.0.1\"/><Peer"}}, "no IPv4 address"},
      {{.domain = 0, .interface = "", .peers = {"239.255.0.1"}}, "one computer"},
      {{.domain = 0, .interface = "", .peers = {"0.0.0.0"}}, "one computer"},
      {{.domain = 0, .interface = "", .peers = std::vector<std::string>(33, "127.0.0.1")}, "too many"},
  };
  for (const Wrong& c : cases) {
    const auto checked = check(c.options);
    ASSERT_FALSE(checked) << c.says;
    EXPECT_EQ(checked.error().fault, Fault::Usage);
    EXPECT_NE(checked.error().message.find(c.says), std::string::npos) << checked.error().message;
  }
}

TEST(Network, a_name_fits_into_its_topic_and_steers_no_terminal) {
  EXPECT_TRUE(check_name("line 3, left"));
  EXPECT_TRUE(check_name(std::string(31, 'n')));
  for (const auto& wrong : {std::string(), std::string(32, 'n'), std::string("a\nb"), std::string("\x1b[2J")})
    EXPECT_EQ(check_name(wrong).error().fault, Fault::Usage) << wrong;
}

TEST(Network, goes_to_the_publisher_as_words) {
  EXPECT_EQ(words({}), (std::vector<std::string>{"--domain", "0"}));
  EXPECT_EQ(
      words({.domain = 3, .interface = "eth0", .peers = {"10.0.0.1", "10.0.0.2"}}),
      (std::vector<std::string>{"--domain", "3", "--interface", "eth0", "--peer", "10.0.0.1", "--peer", "10.0.0.2"}));
}

}  // namespace
}  // namespace gantry::monitor
