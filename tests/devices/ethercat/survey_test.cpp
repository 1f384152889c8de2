// A segment asked without a machine file: what the tools show, against the reference machine's virtual segment.
#include "devices/ethercat/survey.hpp"

#include <gtest/gtest.h>

#include "devices/profiles/object_value.hpp"
#include "tests/devices/ethercat/bus_bench.hpp"

namespace gantry::devices {
namespace {

TEST(Survey, a_line_is_listed_with_identities_ports_and_states) {
  SurveyBench b;
  const auto found = b.survey.scan();
  ASSERT_TRUE(found) << to_text(found.error());
  ASSERT_EQ(found->size(), 6u);
  for (std::size_t i = 0; i < found->size(); ++i) {
    const FoundStation& s = (*found)[i];
    EXPECT_EQ(s.record.position, static_cast<int>(i));
    EXPECT_EQ(s.record.parent, static_cast<int>(i) - 1);
    EXPECT_EQ(s.al.state, wire::AlState::Init);
    EXPECT_EQ(s.record.sii.damage, "");
    EXPECT_FALSE(s.record.sii.sync_managers.empty());
    for (const auto& c : b.machine.stations)
      if (c.bus == config::BusKind::EtherCat && c.position == static_cast<int>(i)) {
        EXPECT_EQ(s.record.sii.product, c.profile.identity.product);
        EXPECT_EQ(s.name(), c.profile.title);
      }
  }
  EXPECT_TRUE((*found)[0].record.ports[1].open());
  EXPECT_FALSE((*found)[5].record.ports[1].open());
}

TEST(Survey, objects_and_pdos_of_a_station_are_read_without_a_profile) {
  SurveyBench b;
  const auto vendor = b.survey.read_object(1, {0x1018, 1});
  ASSERT_TRUE(vendor) << to_text(vendor.error());
  EXPECT_EQ(to_number(config::ObjectType::U32, *vendor), b.machine.stations[1].profile.identity.vendor);
  const auto map = b.survey.read_pdo_map(1);
  ASSERT_TRUE(map) << to_text(map.error());
  EXPECT_TRUE(map->from_objects);
  ASSERT_GE(map->pdos.size(), 2u);
  EXPECT_TRUE(map->pdos.front().outputs);
  const auto io = b.survey.read_pdo_map(0);  // no mailbox: its EEPROM says it
  ASSERT_TRUE(io) << to_text(io.error());
  EXPECT_FALSE(io->from_objects);
  ASSERT_EQ(io->pdos.size(), 2u);
  EXPECT_EQ(io->pdos[0].bits(), 16u);
  EXPECT_EQ(b.survey.read_object(0, {0x1018, 1}).error().fault, Fault::MailboxProtocol);
  EXPECT_EQ(b.survey.read_object(6, {0x1018, 1}).error().fault, Fault::StationMissing);
}

// Each tool is a program of its own and begins to count anew; the station goes on from the one before.
TEST(Survey, one_tool_after_the_other_reads_the_same_object) {
  SurveyBench b;
  for (int tool = 0; tool < 10; ++tool) {
    Survey survey(b.port, b.clock);
    const Time begin = b.clock.now();
    for (int n = 0; n <= tool; ++n) {
      const auto vendor = survey.read_object(1, {0x1018, 1});
      ASSERT_TRUE(vendor) << tool << ": " << to_text(vendor.error());
    }
    EXPECT_LT(b.clock.now() - begin, milliseconds(500)) << tool;
  }
}

// Whether the station takes complete access, or refuses it and is asked one by one, the bytes are the same.
TEST(Survey, an_object_is_read_whole) {
  SurveyBench b;
  const auto all = b.survey.read_object(1, {0x1018, 0}, SdoAccess::Complete);
  ASSERT_TRUE(all) << to_text(all.error());
  ASSERT_GE(all->size(), 2 + 3 * 4u);
  const auto product = b.survey.read_object(1, {0x1018, 2});
  ASSERT_TRUE(product);
  EXPECT_TRUE(std::equal(product->begin(), product->end(), all->begin() + 6));
}

TEST(Survey, error_counters_and_clocks_are_read_from_all) {
  SurveyBench b;
  const auto errors = b.survey.error_counters();
  ASSERT_TRUE(errors) << to_text(errors.error());
  EXPECT_EQ(errors->size(), 6u);
  const auto clocks = b.survey.dc_status();
  ASSERT_TRUE(clocks) << to_text(clocks.error());
  ASSERT_EQ(clocks->size(), 6u);
  EXPECT_TRUE(clocks->front().present);
  EXPECT_EQ(clocks->front().activation, 0);
}

/// As a service tool writes one word of an EEPROM (ETG.1000.4, 6.4), and forgets the checksum.
void write_sii(SurveyBench& b, std::uint16_t station, std::uint16_t word, std::uint16_t value) {
  Link link(b.port, b.clock);
  std::array<std::byte, 8> order{};
  wire::put_le<std::uint16_t>(order, 0, wire::kSiiWriteEnable | wire::kSiiWrite);
  wire::put_le<std::uint32_t>(order, 2, word);
  wire::put_le<std::uint16_t>(order, 6, value);
  ASSERT_TRUE(link.write(station, wire::reg::kSiiControl, std::span<const std::byte>(order)));
  link.pause(milliseconds(20));
}

TEST(Survey, a_station_with_a_wrong_eeprom_checksum_is_listed_with_the_others) {
  SurveyBench b;
  ASSERT_TRUE(b.survey.scan());
  write_sii(b, 0x1003, wire::sii::kAlias, 0x1234);
  b.segment.power_cycle(b.machine.stations[2].id, milliseconds(10));
  b.clock.sleep_until(b.clock.now() + milliseconds(100));
  const auto found = b.survey.scan();
  ASSERT_TRUE(found) << to_text(found.error());
  ASSERT_EQ(found->size(), 6u);
  for (const auto& s : *found) {
    EXPECT_EQ(s.record.sii.product,
              b.machine.stations[static_cast<std::size_t>(s.record.position)].profile.identity.product);
    EXPECT_EQ(s.record.sii.damage.find("checksum") != std::string::npos, s.record.position == 2) << s.record.sii.damage;
    EXPECT_FALSE(s.name().empty());
  }
  EXPECT_TRUE(b.survey.error_counters());
  EXPECT_TRUE(b.survey.read_object(3, {0x1018, 1}));
  // Its application does not start: it refuses with 0051h, EEPROM error (ETG.1020).
  const auto refused = b.survey.read_object(2, {0x1018, 1});
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("0051h"), std::string::npos) << refused.error().message;
}

TEST(Survey, a_dead_bus_is_told_and_nothing_hangs) {
  SurveyBench b;
  b.segment.cut_link(0);
  const auto found = b.survey.scan();
  ASSERT_FALSE(found);
  EXPECT_EQ(found.error().fault, Fault::BusDown);
  EXPECT_EQ(b.survey.error_counters().error().fault, Fault::BusDown);
}

}  // namespace
}  // namespace gantry::devices
