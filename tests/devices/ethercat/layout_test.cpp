// What is about to be written to a station, against what the station can take and says it has.
#include <algorithm>
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "devices/ethercat/layout_check.hpp"
#include "devices/ethercat/survey.hpp"
#include "devices/passing_port.hpp"
#include "tests/devices/ethercat/bus_bench.hpp"

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

/// Whether the machine file's stations are taken on a segment of these.
Result<void> bring_up_on(const config::Machine& wired, const config::Machine& machine) {
  VirtualClock clock;
  sim::Segment segment(wired, clock);
  sim::SegmentPort port(segment, clock);
  EthercatMaster master(machine, port, clock);
  return master.bring_up();
}

// Two drives of one make: only the switches on their housings, read as alias (0012h), tell them apart.
TEST(Layout, two_drives_of_one_make_that_are_swapped_are_told_by_their_aliases) {
  const auto with_aliases = [](std::uint16_t y1, std::uint16_t y2) {
    config::Machine m = reference_machine();
    for (auto& s : m.stations) s.alias = s.name == "y1" ? y1 : s.name == "y2" ? y2 : std::uint16_t{0};
    return m;
  };
  const config::Machine file = with_aliases(7, 8);
  const auto right = bring_up_on(with_aliases(7, 8), file);
  EXPECT_TRUE(right) << to_text(right.error());
  const auto unasked = bring_up_on(with_aliases(7, 8), with_aliases(0, 0));  // the file does not care
  EXPECT_TRUE(unasked) << to_text(unasked.error());
  const auto swapped = bring_up_on(with_aliases(8, 7), file);
  ASSERT_FALSE(swapped);
  EXPECT_EQ(swapped.error().fault, Fault::IdentityMismatch);
  EXPECT_NE(swapped.error().message.find("'y1' with alias 7, but has alias 8, which is that of 'y2'"),
            std::string::npos)
      << swapped.error().message;
  const auto unset = bring_up_on(with_aliases(7, 0), file);
  ASSERT_FALSE(unset);
  EXPECT_NE(unset.error().message.find("'y2' with alias 8, but has alias 0"), std::string::npos)
      << unset.error().message;
}

// Entries and bytes that a PDO may have stand in the profile: the longest that fits, and one less.
TEST(Layout, a_pdo_that_is_over_the_devices_limits_is_refused) {
  const config::Machine wired = reference_machine();
  const auto y1 = [](config::Machine& m) -> config::StationProfile& {
    return std::ranges::find(m.stations, "y1", &config::Station::name)->profile;
  };
  config::Machine exact = wired;
  auto& profile = y1(exact);
  profile.max_pdo_entries = profile.max_pdo_bytes = 0;
  for (const auto* pdos : {&profile.rx_pdos, &profile.tx_pdos})
    for (const auto& pdo : *pdos) {
      profile.max_pdo_entries = std::max(profile.max_pdo_entries, static_cast<int>(pdo.entries.size()));
      profile.max_pdo_bytes = std::max(profile.max_pdo_bytes, static_cast<int>(image_bytes(std::span(&pdo, 1))));
    }
  const auto fits = bring_up_on(wired, exact);
  EXPECT_TRUE(fits) << to_text(fits.error());
  for (const bool entries : {true, false}) {
    config::Machine over = exact;
    entries ? --y1(over).max_pdo_entries : --y1(over).max_pdo_bytes;
    const auto up = bring_up_on(wired, over);
    ASSERT_FALSE(up);
    EXPECT_EQ(up.error().fault, Fault::PdoMappingDiffers);
    EXPECT_NE(up.error().where.find("'y1'"), std::string::npos) << up.error().where;
    EXPECT_NE(up.error().message.find(fmt::format("takes {} and {}", y1(over).max_pdo_entries, y1(over).max_pdo_bytes)),
              std::string::npos)
        << up.error().message;
  }
}

/// The reference machine with a terminal of analogue channels at its end: CoE, and a mapping that cannot be written.
struct AnalogueBench {
  BusBench b;
  config::Station aio;
  AnalogueBench() {
    const auto profile = config::load_profile(GANTRY_SOURCE_DIR "/config/devices/aio4.yaml");
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
    b.port_used = &port;
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

// A terminal of 4 + 4 bit outputs and 8 + 16 bit inputs, two SyncManagers a direction, in the order that its EEPROM has
// them: inputs first.
TEST(Layout, each_sync_manager_of_a_direction_carries_its_own_pdos) {
  StationRecord s;
  s.sii.sync_managers.resize(4);
  for (std::size_t i = 0; i < 4; ++i) {
    s.sii.sync_managers[i].type = i < 2 ? 4 : 3;
    s.sii.sync_managers[i].registers.start = static_cast<std::uint16_t>(0x1000 + 0x100 * i);
  }
  const auto pdo = [](std::uint16_t index, std::uint8_t sm, std::uint8_t bits) {
    return SiiPdo{index, sm, "", {{{0x7000, 1}, "", 0, bits}}};
  };
  s.sii.rx_pdos = {pdo(0x1600, 3, 4), pdo(0x1601, 2, 4), pdo(0x1602, wire::sii::kNoSyncManager, 32)};
  s.sii.tx_pdos = {pdo(0x1A00, 0, 8), pdo(0x1A01, 1, 16)};
  plan_from_sii(s);
  std::vector<StationRecord> line{s, s};
  const auto size = lay_out(line, 0x10000, MapKind::Separate);
  ASSERT_TRUE(size) << to_text(size.error());
  EXPECT_EQ(size->output_bytes, 4u);
  EXPECT_EQ(size->input_bytes, 6u);
  const auto fmmu = [&](int i) { return line[1].fmmus[static_cast<std::size_t>(i)]; };
  ASSERT_EQ(line[1].fmmus.size(), 4u);
  const std::uint32_t at = 0x10005;  // behind the first station's five bytes
  struct Row {
    std::uint32_t logical;
    std::uint16_t length, physical;
    int type;
  };
  const Row rows[] = {{at, 1, 0x1200, 2}, {at + 1, 1, 0x1300, 2}, {at + 2, 1, 0x1000, 1}, {at + 3, 2, 0x1100, 1}};
  for (int i = 0; i < 4; ++i) {
    EXPECT_EQ(fmmu(i).logical_start, rows[i].logical) << i;
    EXPECT_EQ(fmmu(i).length, rows[i].length) << i;
    EXPECT_EQ(fmmu(i).physical_start, rows[i].physical) << i;
    EXPECT_EQ(fmmu(i).type, rows[i].type) << i;
  }
}

// Bit 6 of a SyncManager's control byte is what makes its writes trigger the watchdog (ETG.1000.4, table 59); there are
// EEPROMs without it.
TEST(Layout, outputs_of_a_stranger_are_watched_also_when_its_eeprom_does_not_ask_for_it) {
  BusBench b;
  constexpr std::uint16_t kStation = 0x1002;
  Link link(b.port, b.clock);
  Survey survey(b.port, b.clock);
  ASSERT_TRUE(survey.scan());
  const auto image = read_sii_image(link, kStation);
  ASSERT_TRUE(image) << to_text(image.error());
  std::size_t at = 2 * wire::sii::kFirstCategory;
  const auto word = [&](std::size_t byte) { return wire::get_le<std::uint16_t>(*image, byte); };
  while (word(at) != static_cast<std::uint16_t>(wire::sii::Category::SyncManager)) at += 4 + 2u * word(at + 2);
  const std::size_t control = at + 4 + 2 * wire::sii::kSmBytes + wire::sii::kSmControl;  // of SM2
  ASSERT_EQ(control % 2, 0u);
  ASSERT_EQ(word(control), 0x0064);
  std::array<std::byte, 8> order{};
  wire::put_le<std::uint16_t>(order, 0, wire::kSiiWriteEnable | wire::kSiiWrite);
  wire::put_le<std::uint32_t>(order, 2, static_cast<std::uint32_t>(control / 2));
  wire::put_le<std::uint16_t>(order, 6, 0x0024);
  ASSERT_TRUE(link.write(kStation, wire::reg::kSiiControl, std::span<const std::byte>(order)));
  link.pause(milliseconds(20));

  b.machine = {};
  const auto up = b.bring_up({.strangers = true});
  ASSERT_TRUE(up) << to_text(up.error());
  b.cycles(20);
  ASSERT_TRUE(b.master->request_operation());
  b.cycles(200);
  ASSERT_EQ(b.last.ethercat.al_states, 8);
  b.clock.sleep_until(b.due + milliseconds(500));  // the cycle stops
  const auto al = link.read<std::uint16_t>(kStation, wire::reg::kAlStatus);
  ASSERT_TRUE(al);
  EXPECT_EQ(*al, static_cast<std::uint16_t>(wire::AlState::SafeOp) | wire::kAlError);
}

/// A station that does not take the watchdog bit of its SyncManager 2.
class UnwatchedPort final : public PassingPort {
 public:
  explicit UnwatchedPort(FramePort& port) : PassingPort(port) {}
  bool send(PortIndex port, std::span<const std::byte> frame) noexcept override {
    std::vector<std::byte> changed(frame.begin(), frame.end());
    for (std::size_t at = wire::kFrameHeader;;) {
      const auto h = wire::get_datagram_header(std::span<const std::byte>(changed).subspan(at));
      if (h.command == wire::Command::Fpwr && h.adp() == 0x1003 && h.ado() == 0x0810)
        changed[at + wire::kDatagramHeader + wire::kSmControlOffset] &= ~std::byte{wire::kSmWatchdogTrigger};
      if (!h.more) break;
      at += wire::kDatagramHeader + h.length + wire::kWorkingCounter;
    }
    return port_.send(port, changed);
  }
};

TEST(Layout, a_station_whose_outputs_do_not_trigger_the_watchdog_is_refused) {
  BusBench b;
  UnwatchedPort port(b.port);
  b.port_used = &port;
  const auto up = b.bring_up();
  ASSERT_FALSE(up);
  EXPECT_EQ(up.error().fault, Fault::WatchdogDisabled);
  EXPECT_NE(up.error().where.find("'y1'"), std::string::npos) << up.error().where;
}

}  // namespace
}  // namespace gantry::devices
