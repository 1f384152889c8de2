// Loop, recovery and diagnosis on a bus that is no EtherCAT. This program is linked without EtherCAT's master, and
// tests/architecture checks that what it tries includes none of its headers.
#include "tests/app/run/second_bus.hpp"

#include <algorithm>
#include <gtest/gtest.h>

#include "app/run/recovery.hpp"
#include "app/stations/culprits.hpp"
#include "app/stations/fault_words.hpp"
#include "app/stations/station_news.hpp"
#include "motion/path/moves.hpp"
#include "tests/machine/said.hpp"

namespace gantry {
namespace {

constexpr double kCounts = 100;  // a mm
constexpr std::size_t kElbow = 1;

config::Machine two_axes() {
  config::Machine m;
  for (std::uint16_t i = 0; i < 2; ++i) {
    config::Station s;
    s.id = StationId{i}, s.name = i == 0 ? "shoulder" : "elbow", s.bus = config::BusKind::CanOpen, s.position = i + 1;
    s.profile.drive.emplace();
    m.stations.push_back(s);
    config::Axis axis;
    axis.id = AxisId{static_cast<std::uint8_t>(i)}, axis.name = i == 0 ? "A" : "B";
    axis.drives = {{s.id, 0, false}};
    m.axes.push_back(axis);
  }
  return m;
}

cycle::LoopSetup loop_of(const config::Machine& m) {
  cycle::LoopSetup s;
  for (const config::Axis& axis : m.axes) {
    cycle::DriveSetup drive;
    drive.station = axis.drives[0].station, drive.axis = axis.id;
    drive.layout.controlword = {0}, drive.layout.mode = {2}, drive.layout.target = {3};
    drive.layout.statusword = {0}, drive.layout.mode_display = {2}, drive.layout.position = {3};
    drive.layout.digital_inputs = {7}, drive.layout.neg_limit_bit = 0, drive.layout.pos_limit_bit = 1;
    drive.layout.closed_loop = true;
    drive.scale = devices::AxisScale(kCounts, false);
    s.drives.push_back(drive);
    cycle::AxisSetup setup;
    setup.drives.push_back(static_cast<std::uint8_t>(axis.id.value));
    setup.following_base = 1, setup.following_per_speed_s = 0.01;
    setup.homing.limits.rules = devices::homing_rules(17);
    setup.homing.limits.rules.known = devices::kSwitchNeg | devices::kSwitchPos;
    setup.homing.limits.rules.counts_per_cycle = 10;
    s.axes.push_back(setup);
    s.limits.axis[axis.id.value] = {-1, 100, 100, 1000, 10'000};
    s.limits.linear[axis.id.value] = true;
  }
  s.limits.axes = m.axes.size();
  return s;
}

/// A machine of two axes on the party line, with all that a run thread has.
struct PartyMachine {
  PartyMachine() {
    EXPECT_TRUE(bus.bring_up());
    feed.listen([&](const cycle::Snapshot&) {}, [&](const cycle::Event& e) { hear(e); });
    control.serve_by([&] { serve(); });
    EXPECT_TRUE(control.pass(0.02));
    EXPECT_EQ(now().state, cycle::State::Offline);
    EXPECT_TRUE(bus.request_operation());
    EXPECT_TRUE(control.pass(0.02));
  }
  [[nodiscard]] const cycle::Snapshot& now() const { return control.latest(); }
  void hear(const cycle::Event& e) {
    if (e.kind == cycle::EventKind::Fault && stations::Culprits::wanted(e.fault)) return culprits.ask(e);
    if (e.kind == cycle::EventKind::Fault) words.push_back(to_text(stations::in_words(machine, e)));
  }
  void serve() {
    culprits.watch(now());
    while (const auto known = culprits.next()) words.push_back(known->where + known->what);
    for (const auto& item : news.counted(now().time_ns)) words.push_back(to_text(item.words));
    if (news.mail())
      for (const auto& item : news.fetch()) words.push_back(to_text(item.words));
  }
  [[nodiscard]] bool said(std::string_view part) const {
    return std::ranges::any_of(words, [&](const std::string& w) { return w.find(part) != std::string::npos; });
  }
  Result<void> command(cycle::Command c) { return control.command(c, 30); }
  void enable_and_home() {
    const auto enabled = command({.kind = cycle::CommandKind::Enable});
    ASSERT_TRUE(enabled) << to_text(enabled.error());
    const auto homed = command({.kind = cycle::CommandKind::Home, .axes = 0b11});
    ASSERT_TRUE(homed) << to_text(homed.error());
    EXPECT_EQ(now().referenced, 0b11u);
  }
  Result<void> begin(const AxisVec& to) {
    auto line = motion::line_move(setup.limits, now().target, to, 10);
    line.back().ends_block = true;
    for (auto& s : line) {
      s.block = ++block;
      EXPECT_TRUE(channels->segments.push(s));
    }
    return command({.kind = cycle::CommandKind::StartBlock, .block = block});
  }
  void idle(int cycles) {
    for (int i = 0; i < cycles; ++i) {
      control.idle();
      recovery.step(control);
    }
  }

  config::Machine machine = two_axes();
  VirtualClock clock;
  test::SecondBus bus{{{.name = "shoulder"}, {.name = "elbow", .position = 730}}, machine};
  cycle::LoopSetup setup = loop_of(machine);
  std::unique_ptr<cycle::Channels> channels = std::make_unique<cycle::Channels>();
  cycle::Loop loop{setup, bus, nullptr, clock, *channels};
  run::Feed feed{*channels};
  run::VirtualPump pump{loop, clock, bus.first_cycle(clock.now() + milliseconds(5))};
  run::Control control{*channels, feed, pump, milliseconds(1),
                       [this](const cycle::Event& e) { return stations::in_words(machine, e); }};
  run::Recovery recovery{bus};
  stations::Culprits culprits{bus};
  stations::StationNews news{bus, machine};
  std::vector<std::string> words;
  std::uint32_t block = 0;
};

TEST(SecondBus, axes_are_enabled_homed_and_moved_without_a_word_of_ethercat) {
  PartyMachine m;
  EXPECT_EQ(m.now().state, cycle::State::Disabled);
  EXPECT_TRUE(m.now().in_time) << "there is no clock to lock to";
  m.enable_and_home();
  ASSERT_TRUE(m.begin({12.5, 40}));
  ASSERT_TRUE(m.control.wait([&] { return m.now().state == cycle::State::Ready; }, 30, {}));
  EXPECT_EQ(m.bus.node(0).position, 1250);
  EXPECT_EQ(m.bus.node(1).position, 4000);
  EXPECT_EQ(m.now().working_counter, 0);
  EXPECT_EQ(m.now().expected, 0);
  EXPECT_EQ(m.now().al_states, 0);
  EXPECT_TRUE(m.words.empty()) << m.words.front();
}

TEST(SecondBus, a_node_that_goes_away_stops_the_machine_is_named_and_comes_back_without_its_reference) {
  test::Said said;
  PartyMachine m;
  m.enable_and_home();
  ASSERT_TRUE(m.begin({50, 50}));
  ASSERT_TRUE(m.control.pass(1));
  ASSERT_EQ(m.now().state, cycle::State::Running);
  m.bus.node(kElbow).answers = false;
  m.bus.node(kElbow).lose_supply();
  const CycleIndex away = m.now().cycle;
  while (m.now().latched == Fault::None) m.control.idle();
  EXPECT_EQ(m.now().latched, Fault::StationSilent);
  EXPECT_LE(m.now().cycle - away, 4);
  const std::int32_t before = m.bus.node(0).position;
  m.idle(1000);
  EXPECT_EQ(m.now().state, cycle::State::Stopped);
  EXPECT_LT(m.bus.node(0).position - before, 100) << "10 mm/s and 1000 mm/s^2 brake within 1 mm";
  EXPECT_TRUE(m.said("node 'elbow'"));
  EXPECT_FALSE(m.said("node 'shoulder'"));
  EXPECT_EQ(m.now().referenced, 0b01u);
  EXPECT_FALSE(m.now().operational);
  EXPECT_GE(m.bus.attempts, 5);
  EXPECT_EQ(said.count({"node 'elbow'", "does not answer"}), 1) << said.all();

  m.bus.node(kElbow).answers = true;
  const CycleIndex there = m.now().cycle;
  while (!(m.now().complete && m.now().operational) && m.now().cycle < there + 1000) m.idle(1);
  EXPECT_LE(m.now().cycle - there, 150);
  EXPECT_EQ(m.recovery.take_restarted(), std::vector{StationId{kElbow}});
  m.idle(50);
  EXPECT_TRUE(said.has("node 'elbow': takes part again; it was asleep")) << said.all();
  EXPECT_TRUE(said.has("every station takes part again")) << said.all();
  EXPECT_EQ(m.now().enabled & 0b10u, 0u) << "nothing enables it but an order";

  m.control.begin();
  const auto reset = m.command({.kind = cycle::CommandKind::Reset});
  ASSERT_TRUE(reset) << to_text(reset.error());
  ASSERT_TRUE(m.control.pass(0.1));
  const auto enabled = m.command({.kind = cycle::CommandKind::Enable});
  ASSERT_TRUE(enabled) << to_text(enabled.error());
  const auto moved = m.begin({1, 1});
  ASSERT_FALSE(moved);
  EXPECT_EQ(moved.error().fault, Fault::NotReferenced);
}

TEST(SecondBus, a_node_that_falls_asleep_is_named_with_its_state) {
  PartyMachine m;
  m.enable_and_home();
  m.bus.node(kElbow).awake = false;
  while (m.words.empty() && m.now().cycle < 100'000) m.control.idle();
  ASSERT_FALSE(m.words.empty());
  EXPECT_EQ(m.words.front(), "node 'elbow'; node 'elbow' is asleep");
}

TEST(SecondBus, what_nodes_report_by_themselves_is_told_with_their_names) {
  PartyMachine m;
  m.enable_and_home();
  m.idle(10);
  m.bus.node(kElbow).crackles = 3;
  m.bus.node(0).mail.push_back({.code = 0x4210, .error_register = 1});
  m.idle(10);
  EXPECT_TRUE(m.said("plug: 3 crackles"));
  EXPECT_TRUE(m.said("node 'shoulder'"));
  EXPECT_TRUE(m.said("device temperature"));
  EXPECT_EQ(m.words.size(), 2u);
}

}  // namespace
}  // namespace gantry
