// What is about to be written to a station, against what the station can take and says it has.
#include <gtest/gtest.h>

#include "devices/ethercat/layout_check.hpp"
#include "tests/devices/bus_bench.hpp"

namespace gantry::devices {
namespace {

TEST(Layout, a_profile_of_another_length_than_a_station_without_mailbox_has_is_refused_with_both) {
  BusBench b;
  for (auto& s : b.machine.stations)
    if (s.name == "io") s.profile.tx_pdos[0].entries.push_back({{0x6001, 1}, 8});
  const auto up = b.bring_up();
  ASSERT_FALSE(up);
  EXPECT_EQ(up.error().fault, Fault::PdoMappingDiffers) << to_text(up.error());
  EXPECT_NE(up.error().where.find("'io'"), std::string::npos) << up.error().where;
  EXPECT_NE(up.error().message.find("inputs are 2 bytes by its EEPROM, and 3 bytes"), std::string::npos)
      << up.error().message;
}

/// The reference machine with a terminal of analogue channels at its end: CoE, and a mapping that cannot be written.
struct AnalogueBench {
  BusBench b;
  config::Station aio;
  AnalogueBench() {
    const auto profile = config::load_profile(std::string(GANTRY_SOURCE_DIR) + "/config/devices/aio4.yaml");
    EXPECT_TRUE(profile);
    aio.id = StationId{static_cast<std::uint16_t>(b.wired.stations.size())};
    aio.name = "aio";
    aio.profile = *profile;
    for (const auto& s : b.wired.stations)
      if (s.bus == config::BusKind::EtherCat) aio.position = std::max(aio.position, s.position + 1);
    b.wired.stations.push_back(aio);
  }
  Result<void> bring_up(const config::Station& as_configured) {
    b.machine.stations.push_back(as_configured);
    sim::Segment segment(b.wired, b.clock);
    sim::SegmentPort port(segment, b.clock);
    b.way = &port;
    auto up = b.bring_up();
    b.master.reset();
    return up;
  }
};

TEST(Layout, a_fixed_mapping_is_compared_with_the_stations_objects) {
  {
    AnalogueBench a;
    const auto up = a.bring_up(a.aio);
    EXPECT_TRUE(up) << to_text(up.error());
  }
  {
    AnalogueBench a;
    auto other = a.aio;
    other.profile.rx_pdos[0].entries.pop_back();
    const auto up = a.bring_up(other);
    ASSERT_FALSE(up);
    EXPECT_EQ(up.error().fault, Fault::PdoMappingDiffers) << to_text(up.error());
    EXPECT_NE(up.error().message.find("outputs are 4 bytes by its objects, and 2 bytes"), std::string::npos)
        << up.error().message;
  }
  {
    AnalogueBench a;
    auto other = a.aio;
    std::swap(other.profile.tx_pdos[0].entries[0], other.profile.tx_pdos[0].entries[1]);
    const auto up = a.bring_up(other);
    ASSERT_FALSE(up);
    EXPECT_EQ(up.error().fault, Fault::PdoMappingDiffers) << to_text(up.error());
    EXPECT_NE(up.error().message.find("6010h:01 with 16 bits begins at bit 16"), std::string::npos)
        << up.error().message;
  }
}

TEST(Layout, sync_managers_that_lie_over_each_other_or_over_the_end_of_the_ram_are_refused) {
  struct Case {
    std::uint16_t inputs_at;
    const char* says;
  };
  // Outputs of aio4: 4 bytes at 1100h, three times; inputs 8 bytes. The virtual ESC has 8 KiB from 1000h on.
  for (const Case& c : {Case{0x110C, ""}, Case{0x110B, "SM2 (1100h, 3 x 4 bytes) and SM3 (110Bh, 3 x 8 bytes)"},
                        Case{0x2FE8, ""}, Case{0x2FE9, "over the end of its RAM at 3000h"},
                        Case{0x10FF, "lie over each other"}, Case{0x1040, "SM0 (1000h, 1 x 128 bytes)"}}) {
    SCOPED_TRACE(c.inputs_at);
    AnalogueBench a;
    for (auto* s : {&a.b.wired.stations.back(), &a.aio}) s->profile.sync_managers[3].start = c.inputs_at;
    const auto up = a.bring_up(a.aio);
    if (*c.says == 0) {
      EXPECT_TRUE(up) << to_text(up.error());
      continue;
    }
    ASSERT_FALSE(up);
    EXPECT_EQ(up.error().fault, Fault::Inconsistent) << to_text(up.error());
    EXPECT_NE(up.error().message.find(c.says), std::string::npos) << up.error().message;
  }
}

}  // namespace
}  // namespace gantry::devices
