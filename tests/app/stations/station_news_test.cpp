// What stations report by themselves, in words.
#include "app/stations/station_news.hpp"

#include <gtest/gtest.h>

#include "tests/app/stations/told_bus.hpp"

namespace gantry::stations {
namespace {

constexpr std::int64_t kSecond_ns = 1'000'000'000;

devices::ErrorCounts counts(unsigned checksum, unsigned lost, unsigned far = 0) {
  devices::ErrorCounts c;
  c.push_back({"port 0", "frames with a wrong checksum", checksum});
  c.push_back({"port 0", "lost links", lost});
  c.push_back({"port 1", "lost links", far});
  return c;
}

struct News : testing::Test {
  test::ToldBus bus{{"x", "z"}};
  config::Machine machine;
  StationNews news{bus, machine};

  /// What is told once station `i` was looked at again, and counts so much by then.
  std::vector<StationNews::Item> after(std::size_t i, const devices::ErrorCounts& now, std::int64_t now_ns) {
    bus.row(i).counts = now;
    ++bus.row(i).look.looks;
    return news.counted(now_ns);
  }
};

TEST_F(News, what_is_counted_at_the_beginning_is_no_news) {
  EXPECT_TRUE(after(0, counts(17, 2), 0).empty());
  EXPECT_TRUE(after(0, counts(17, 2), kSecond_ns).empty());
}

TEST_F(News, growth_is_told_by_port_and_kind) {
  (void)after(1, counts(17, 2, 255), 0);
  const auto items = after(1, counts(20, 3, 255), kSecond_ns);
  ASSERT_EQ(items.size(), 1u);
  EXPECT_EQ(items[0].station, (StationId{1}));
  EXPECT_EQ(items[0].words.fault, Fault::LinkErrors);
  EXPECT_EQ(items[0].words.where, "station 1 'z'");
  EXPECT_NE(items[0].words.message.find("port 0: 3 frames with a wrong checksum, 1 lost links"), std::string::npos)
      << items[0].words.message;
  EXPECT_EQ(items[0].words.message.find("port 1"), std::string::npos) << "nothing has grown there";
}

TEST_F(News, a_second_port_is_named_for_itself) {
  (void)after(0, counts(0, 0, 0), 0);
  const auto items = after(0, counts(0, 1, 2), kSecond_ns);
  ASSERT_EQ(items.size(), 1u);
  EXPECT_NE(items[0].words.message.find("port 0: 1 lost links; port 1: 2 lost links"), std::string::npos)
      << items[0].words.message;
}

TEST_F(News, a_counter_that_is_lower_has_begun_anew) {
  (void)after(0, counts(200, 0), 0);
  const auto items = after(0, counts(4, 0), kSecond_ns);
  ASSERT_EQ(items.size(), 1u);
  EXPECT_NE(items[0].words.message.find("port 0: 4 frames with a wrong checksum"), std::string::npos)
      << items[0].words.message;
}

TEST_F(News, a_plug_that_crackles_speaks_every_ten_seconds_and_nothing_is_lost) {
  (void)after(0, counts(0, 0), 0);
  unsigned told = 0, times = 0;
  constexpr int kSeconds = 65;
  for (unsigned s = 1; s <= kSeconds; ++s)
    for (const auto& item : after(0, counts(s, 0), s * kSecond_ns)) {
      const auto at = item.words.message.find("port 0: ");
      ASSERT_NE(at, std::string::npos);
      told += static_cast<unsigned>(std::stoul(item.words.message.substr(at + 8)));
      ++times;
    }
  for (const auto& item : after(0, counts(kSeconds, 0), 100 * kSecond_ns)) {
    told += static_cast<unsigned>(std::stoul(item.words.message.substr(item.words.message.find("port 0: ") + 8)));
    ++times;
  }
  EXPECT_EQ(told, kSeconds);
  EXPECT_LE(times, 8u);
  EXPECT_GE(times, 6u);
}

TEST_F(News, one_look_is_judged_once) {
  (void)after(0, counts(0, 0), 0);
  EXPECT_EQ(after(0, counts(1, 0), kSecond_ns).size(), 1u);
  bus.row(0).counts = counts(9, 0);
  EXPECT_TRUE(news.counted(60 * kSecond_ns).empty()) << "nobody has looked since";
}

TEST_F(News, a_mailbox_is_fetched_once_a_look) {
  EXPECT_FALSE(news.mail());
  bus.row(1).look = {.looks = 5, .message_waiting = true};
  EXPECT_TRUE(news.mail());
  EXPECT_FALSE(news.mail()) << "that it was fetched shows with the next look only";
  bus.row(1).look.looks = 6;
  EXPECT_TRUE(news.mail());
}

TEST_F(News, an_emergency_is_told_by_the_words_of_its_profile_else_by_its_class) {
  auto& station = machine.stations.emplace_back();
  station.id = StationId{1};
  station.profile.drive.emplace();
  station.profile.drive->errors = {{0x3210, config::DriveErrorKind::Fault, "over-voltage of the bus", "", ""}};
  bus.mail = {{StationId{1}, {.code = 0x3210, .error_register = 0x05, .data = {1, 2, 3, 4, 0xFF}}},
              {StationId{1}, {.code = 0x4210, .error_register = 0x09}}};
  const auto items = news.fetch();
  ASSERT_EQ(items.size(), 2u);
  EXPECT_EQ(items[0].words.fault, Fault::EmergencyMessage);
  EXPECT_EQ(items[0].words.where, "station 1 'z'");
  EXPECT_EQ(items[0].detail, 0x3210);
  EXPECT_NE(items[0].words.message.find("over-voltage of the bus"), std::string::npos) << items[0].words.message;
  EXPECT_NE(items[0].words.message.find("error register 05h, data 01 02 03 04 FF"), std::string::npos)
      << items[0].words.message;
  EXPECT_NE(items[1].words.message.find("device temperature (code 4210h)"), std::string::npos)
      << items[1].words.message;
}

// CiA 301, 7.2.7.1, table 21: a class by its upper byte, where the next nibble says nothing the generic one.
TEST(EmergencyClass, is_the_standards) {
  for (const auto& [code, text] : {std::pair<int, std::string_view>{0x0000, "error reset, or no error"},
                                   {0x1000, "generic"},
                                   {0x2000, "current"},
                                   {0x2310, "current, output side"},
                                   {0x3120, "mains voltage"},
                                   {0x3210, "voltage inside"},
                                   {0x33FF, "output voltage"},
                                   {0x4000, "temperature"},
                                   {0x4110, "ambient temperature"},
                                   {0x5441, "device hardware"},
                                   {0x6010, "device software"},
                                   {0x6320, "data set"},
                                   {0x7305, "additional modules"},
                                   {0x8130, "communication"},
                                   {0x8250, "protocol"},
                                   {0x8611, "monitoring"},
                                   {0x9000, "external"},
                                   {0xA000, "refused PRE_OP to SAFE_OP"},
                                   {0xA001, "refused SAFE_OP to OP"},
                                   {0xF001, "additional functions"},
                                   {0xFF10, "device specific"}})
    EXPECT_EQ(emergency_class(static_cast<std::uint16_t>(code)), text) << std::hex << code;
  for (int code = 0; code <= 0xFFFF; ++code) EXPECT_FALSE(emergency_class(static_cast<std::uint16_t>(code)).empty());
}

}  // namespace
}  // namespace gantry::stations
