// SDO transfers that need more than one mailbox (ETG.1000.6, 5.6.2.3 to 5.6.2.6), and what the server makes of rubbish.
#include "sim/coe_server.hpp"

#include <gtest/gtest.h>
#include <random>
#include <string>

#include "machines.hpp"
#include "raw_master.hpp"

namespace gantry::sim::test {
namespace {

struct Server : ::testing::Test {
  Server() {
    profile_.title = "a name that does not fit into one mailbox of thirty-two bytes, nor into two of them";
    objects = std::make_unique<ObjectDictionary>(profile_, 7u);
    server = std::make_unique<CoeServer>(*objects, 32);
  }
  /// CoE in, CoE out; empty: no answer.
  Raw ask(const Raw& coe) {
    counter = static_cast<std::uint8_t>(counter % 7 + 1);
    Raw m = bytes(coe.size(), 2) + bytes(0, 2) + Raw{0, static_cast<std::uint8_t>(3 | counter << 4)} + coe;
    m.resize(std::max<std::size_t>(m.size(), 32));
    server->take(std::as_bytes(std::span(m)), true);
    if (!server->waiting()) return {};
    const auto reply = server->next();
    EXPECT_LE(reply.size(), 32u);
    Raw out;
    for (const auto b : reply) out.push_back(std::to_integer<std::uint8_t>(b));
    EXPECT_EQ(value(out, 0, 2), out.size() - 6);
    EXPECT_NE(out[5] >> 4, last_reply_counter);
    last_reply_counter = out[5] >> 4;
    return Raw(out.begin() + 6, out.end());
  }
  config::StationProfile profile_ = profile("drives/id286.yaml");
  std::unique_ptr<ObjectDictionary> objects;
  std::unique_ptr<CoeServer> server;
  std::uint8_t counter = 0;
  int last_reply_counter = -1;
};

TEST_F(Server, uploads_a_long_string_in_segments) {
  Raw reply = ask(bytes(0x2000, 2) + Raw{0x40, 0x08, 0x10, 0} + bytes(0, 4));
  ASSERT_EQ(reply[2], 0x41);
  EXPECT_EQ(value(reply, 6, 4), profile_.title.size());
  std::string text(reply.begin() + 10, reply.end());
  bool toggle = false;
  for (bool last = false; !last;) {
    reply = ask(bytes(0x2000, 2) + Raw{static_cast<std::uint8_t>(0x60 | (toggle ? 0x10 : 0))} + Raw(7));
    ASSERT_GE(reply.size(), 10u);
    EXPECT_EQ(reply[2] & 0xF0, toggle ? 0x10 : 0x00);
    last = (reply[2] & 1) != 0;
    const std::size_t unused = reply.size() == 10 ? reply[2] >> 1 & 7u : 0u;
    text.append(reply.begin() + 3, reply.end() - static_cast<std::ptrdiff_t>(unused));
    toggle = !toggle;
  }
  EXPECT_EQ(text, profile_.title);
}

TEST_F(Server, a_toggle_that_does_not_change_aborts_the_upload) {
  ask(bytes(0x2000, 2) + Raw{0x40, 0x08, 0x10, 0} + bytes(0, 4));
  ask(bytes(0x2000, 2) + Raw{0x60} + Raw(7));
  const Raw reply = ask(bytes(0x2000, 2) + Raw{0x60} + Raw(7));
  EXPECT_EQ(reply[2], 0x80);
  EXPECT_EQ(value(reply, 3, 2), 0x1008u);
  EXPECT_EQ(value(reply, 6, 4), 0x05030000u);
}

TEST_F(Server, downloads_in_segments) {
  EXPECT_EQ(ask(bytes(0x2000, 2) + Raw{0x21, 0x7A, 0x60, 0} + bytes(4, 4))[2], 0x60);  // normal, no data yet
  EXPECT_EQ(ask(bytes(0x2000, 2) + Raw{0x0A, 0x11, 0x22} + Raw(5))[2], 0x20);          // 2 bytes: 7 - 5 unused
  EXPECT_EQ(ask(bytes(0x2000, 2) + Raw{0x1B, 0x33, 0x44} + Raw(5))[2], 0x30);          // the last 2
  EXPECT_EQ(objects->value({0x607A, 0}), 0x44332211);
}

TEST_F(Server, a_download_must_be_as_long_as_it_said) {
  ask(bytes(0x2000, 2) + Raw{0x21, 0x7A, 0x60, 0} + bytes(4, 4));
  EXPECT_EQ(value(ask(bytes(0x2000, 2) + Raw{0x0B, 0x11, 0x22} + Raw(5)), 6, 4), 0x06070013u);
  ask(bytes(0x2000, 2) + Raw{0x21, 0x7A, 0x60, 0} + bytes(4, 4));
  EXPECT_EQ(value(ask(bytes(0x2000, 2) + Raw{0x01} + Raw(7)), 6, 4), 0x06070012u);
  EXPECT_EQ(objects->value({0x607A, 0}), 0);
}

TEST_F(Server, a_normal_download_with_its_data_is_one_mailbox) {
  EXPECT_EQ(ask(bytes(0x2000, 2) + Raw{0x21, 0x7A, 0x60, 0} + bytes(4, 4) + bytes(0xFFFFFFFE, 4))[2], 0x60);
  EXPECT_EQ(objects->value({0x607A, 0}), -2);
}

TEST_F(Server, drops_a_repeated_counter) {
  Raw m = bytes(10, 2) + bytes(0, 2) + Raw{0, 0x33} + bytes(0x2000, 2) + Raw{0x40, 0x00, 0x10, 0} + bytes(0, 4);
  server->take(std::as_bytes(std::span(m)), true);
  server->next();
  server->take(std::as_bytes(std::span(m)), true);
  EXPECT_FALSE(server->waiting());
  m[5] = 0x03;  // a counter of 0 is not counted
  server->take(std::as_bytes(std::span(m)), true);
  server->take(std::as_bytes(std::span(m)), true);
  server->next();
  EXPECT_TRUE(server->waiting());
}

TEST_F(Server, answers_rubbish_with_bounded_replies) {
  std::mt19937 random(99);
  for (int i = 0; i < 200'000; ++i) {
    Raw m(random() % 40);
    for (auto& b : m) b = static_cast<std::uint8_t>(random() % 4 == 0 ? random() : random() % 0x24);
    if (m.size() > 8 && random() % 2 == 0)
      m[0] = static_cast<std::uint8_t>(m.size() - 6), m[1] = 0, m[5] = 3, m[7] = 0x20;
    server->take(std::as_bytes(std::span(m)), random() % 2 == 0);
    while (server->waiting()) EXPECT_LE(server->next().size(), 32u);
  }
  SUCCEED() << "seed 99";
}

}  // namespace
}  // namespace gantry::sim::test
