// A fault of the loop in words: every unit that a fault's figure may have, and which station is meant.
#include "app/stations/fault_words.hpp"

#include <gtest/gtest.h>
#include <numbers>
#include <set>

namespace gantry::stations {
namespace {

constexpr std::uint16_t kX = 0, kY1 = 1, kY2 = 2, kTurn = 3;

config::Machine machine() {
  config::Machine m;
  for (const auto& [name, position] : {std::pair{"x", 0}, {"y1", 2}, {"y2", 3}, {"c", 5}}) {
    auto& s = m.stations.emplace_back();
    s.id = StationId{static_cast<std::uint16_t>(m.stations.size() - 1)};
    s.name = name, s.position = position;
    s.profile.title = "HCFA AMD530B";
    s.profile.drive.emplace();
    s.profile.drive->errors = {{0x3210, config::DriveErrorKind::Fault, "over-voltage", "look at the supply", "3.8"}};
  }
  const auto axis = [&](const char* name, std::initializer_list<std::uint16_t> stations) {
    auto& a = m.axes.emplace_back();
    a.id = AxisId{static_cast<std::uint8_t>(m.axes.size() - 1)}, a.name = name;
    for (const auto s : stations) a.drives.push_back({.station = StationId{s}});
  };
  axis("X", {kX}), axis("Y", {kY1, kY2}), axis("C", {kTurn});
  m.axes[2].rotary = true;
  return m;
}
constexpr AxisId kAxisX{0}, kAxisY{1}, kAxisC{2};

std::string words(const cycle::Event& e) {
  const Error error = in_words(machine(), e);
  EXPECT_EQ(error.fault, e.fault);
  const std::string catalogue(info(e.fault).text);
  EXPECT_EQ(error.message.substr(0, catalogue.size()), catalogue);
  return error.where + "|" + error.message.substr(std::min(catalogue.size(), error.message.size()));
}

cycle::Event event(Fault fault, AxisId axis, std::int32_t detail, double value = 0) {
  return {.kind = cycle::EventKind::Fault, .fault = fault, .axis = axis, .detail = detail, .value = value};
}

// One fault for each unit; where a unit depends on the axis, both.
TEST(FaultWords, the_figure_has_its_unit) {
  const std::vector<std::pair<cycle::Event, std::string>> rows{
      {event(Fault::FollowingError, kAxisX, 1250), "axis X| (by 1250 um)"},
      {event(Fault::FollowingError, kAxisC, 12), "axis C| (by 12 mrad)"},
      {event(Fault::NotFollowing, kAxisX, 1500, 20), "axis X| (6064h is at 18.500 mm, 20.000 was asked for)"},
      {event(Fault::NotFollowing, kAxisC, 0, std::numbers::pi / 2),
       "axis C| (6064h is at 90.000 deg, 90.000 was asked for)"},
      {event(Fault::ControllerStalled, kNoAxis, 31), "| (for 31 cycles)"},
      {event(Fault::LateCycles, kNoAxis, 11), "| (11 in 100 ms)"},
      {event(Fault::FramesLost, kNoAxis, 3), "| (3 in a row)"},
      {event(Fault::DcLost, kNoAxis, -20500), "| (by -20.5 us)"},
      {event(Fault::LateCycle, kNoAxis, 340), "| (by 340 us)"},
      {event(Fault::WatchdogStop, kNoAxis, 12), "| (for 12 ms)"},
      {event(Fault::StationLeftOp, kNoAxis, 0x14), "| (AL states seen: 14h)"},
      {event(Fault::StationSilent, kNoAxis, 9), "| (working counter 9)"},
      {event(Fault::DriveDropped, kAxisX, 0x0250), "axis X| (statusword 0250h)"},
      {event(Fault::TargetStep, kAxisX, 77), "axis X|"},
  };
  std::set<Detail> tried;
  for (const auto& [e, expected] : rows) {
    EXPECT_EQ(words(e), expected);
    tried.insert(info(e.fault).detail);
  }
  std::set<Detail> units;
  for (const FaultInfo& row : catalogue()) units.insert(row.detail);
  units.erase(Detail::DriveCode), units.erase(Detail::EmergencyCode);  // below, and with the stations' news
  EXPECT_EQ(tried, units) << "a unit of the catalogue that no row tries";
}

TEST(FaultWords, a_drives_own_code_is_its_manuals_text_and_remedy) {
  const std::string told = words(event(Fault::DriveFault, kAxisX, 0x3210));
  EXPECT_NE(told.find("axis X, station 0 'x'|"), std::string::npos) << "an axis of one drive has no other: " << told;
  EXPECT_NE(told.find("over-voltage"), std::string::npos) << told;
  EXPECT_NE(told.find("; look at the supply"), std::string::npos) << told;
  const std::string unknown = words(event(Fault::DriveFault, kAxisX, 0x7777));
  EXPECT_NE(unknown.find("7777h"), std::string::npos) << "a code that no manual has is told as it is: " << unknown;
}

TEST(FaultWords, of_two_drives_the_one_that_the_event_names) {
  cycle::Event e = event(Fault::DriveFault, kAxisY, 0x3210);
  EXPECT_EQ(words(e), "axis Y|") << "which of the two is not known, and its code is no other's";
  e.station = StationId{kY2};
  EXPECT_NE(words(e).find("axis Y, station 3 'y2'|"), std::string::npos) << words(e);
}

TEST(FaultWords, a_station_without_an_axis_is_named_alone) {
  cycle::Event e = event(Fault::DcNotLocked, kNoAxis, 1000);
  e.station = StationId{kTurn};
  EXPECT_EQ(words(e), "station 5 'c'| (by 1.0 us)");
}

TEST(FaultWords, an_answer_that_names_a_fault_counts_nothing) {
  cycle::Event e = event(Fault::FollowingError, kAxisX, 1250);
  e.kind = cycle::EventKind::CommandDone;
  EXPECT_EQ(words(e), "axis X|");
}

TEST(FaultWords, an_axis_or_station_that_the_machine_lacks_is_left_out) {
  cycle::Event e = event(Fault::DriveFault, AxisId{40}, 0x3210);
  e.station = StationId{400};
  EXPECT_EQ(words(e), "|");
}

TEST(SenderWords, a_mac_address_as_people_write_it) {
  const auto mac = [](std::initializer_list<int> bytes) {
    devices::MacAddress m{};
    std::size_t i = 0;
    for (const int b : bytes) m[i++] = static_cast<std::byte>(b);
    return m;
  };
  EXPECT_EQ(sender_words(mac({0x00, 0x1B, 0x21, 0x0A, 0x0B, 0x0C})), "from 00:1B:21:0A:0B:0C");
  // ETG.1000.4, 6.1: a station sets the locally administered bit of the source address of what it passes on.
  EXPECT_NE(sender_words(mac({0x02, 0x1B, 0x21, 0x0A, 0x0B, 0x0C})).find("stations set the 02h"), std::string::npos);
}

}  // namespace
}  // namespace gantry::stations
