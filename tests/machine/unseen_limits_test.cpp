// Limit switches that the controller sees late, or not at all, and mailboxes that answer slowly: the machine homes as
// well, or it says which station and object is in its way, in bounded time.
#include <chrono>
#include <fmt/format.h>
#include <fstream>

#include "config/yaml.hpp"
#include "tests/altered.hpp"
#include "tests/machine/deposits.hpp"
#include "tests/machine/rig.hpp"
#include "tests/machine/said.hpp"

namespace gantry {
namespace {

using test::object;
using test::Rig;
using test::station;

constexpr std::initializer_list<const char*> kDrives = {"x", "y1", "y2", "z", "cu"};

std::vector<std::pair<const char*, sim::StationHabits>> all_answer_after(Time delay) {
  std::vector<std::pair<const char*, sim::StationHabits>> habits;
  for (const char* name : kDrives) habits.emplace_back(name, sim::StationHabits{.mailbox_delay = delay});
  return habits;
}

void unmappable(config::Machine& m, std::initializer_list<const char*> names, std::initializer_list<int> indices) {
  for (const char* name : names)
    for (const int index : indices) object(m, name, {static_cast<std::uint16_t>(index), 0}).mappable = false;
}

TEST(UnseenLimits, a_station_without_digital_inputs_homes_only_where_the_machine_file_accepts_that) {
  const auto no_inputs = [](config::Machine& m) { test::remove_object(station(m, "x").profile, 0x60FD); };
  {
    Rig rig({.wired = no_inputs});
    ASSERT_TRUE(rig.owner().bring_up());
    const double start = rig.owner().latest().actual[0];
    const auto homed = rig.owner().home();
    ASSERT_FALSE(homed);
    EXPECT_EQ(homed.error().fault, Fault::SwitchesUnseen) << to_text(homed.error());
    for (const char* word : {"'x'", "60FDh", "limits_unseen"})
      EXPECT_NE(to_text(homed.error()).find(word), std::string::npos) << to_text(homed.error());
    EXPECT_EQ(rig.owner().latest().actual[0], start);
    EXPECT_EQ(rig.owner().latest().enabled, 0u);
  }
  test::Said said;
  Rig rig({.change = [](auto& m) { m.axes[0].homing->limits_unseen = true; }, .wired = no_inputs});
  ASSERT_TRUE(rig.owner().bring_up());
  const auto homed = rig.owner().home();
  ASSERT_TRUE(homed) << to_text(homed.error());
  EXPECT_EQ(said.count({"axis X", "'x'", "without a watch"}), 1) << said.all();
  const auto world = rig.owner().world()->axes();
  ASSERT_TRUE(world);
  EXPECT_NEAR((*world)[0], rig.owner().latest().actual[0], 0.02);
}

// A profile whose PDOs lack 60FDh, of a station that would not map it: its limits are watched all the same.
TEST(UnseenLimits, digital_inputs_that_a_profile_does_not_map_are_read_by_sdo) {
  const std::string path = testing::TempDir() + "gantry_unmapped_inputs.yaml";
  std::string text = *config::read_text_file("config/drives/id286.yaml");
  const std::string mapped = ", 0x60FD]";
  ASSERT_NE(text.find(mapped), std::string::npos);
  text.replace(text.find(mapped), mapped.size(), "]");
  std::ofstream(path) << text;
  const auto profile = config::load_profile(path);
  ASSERT_TRUE(profile) << to_text(profile.error().front());
  test::Said said;
  Rig rig({.change = [&](auto& m) { station(m, "x").profile.tx_pdos = profile->tx_pdos; },
           .wired = [](auto& m) { unmappable(m, {"x"}, {0x60FD}); }});
  ASSERT_TRUE(rig.owner().bring_up());
  EXPECT_EQ(said.count({"'x'", "60FDh", "read by SDO"}), 1) << said.all();
  const auto homed = rig.owner().home();
  ASSERT_TRUE(homed) << to_text(homed.error());
  const auto world = rig.owner().world()->axes();
  ASSERT_TRUE(world);
  EXPECT_NEAR((*world)[0], rig.owner().latest().actual[0], 0.02);
}

TEST(UnseenLimits, limits_that_are_polled_and_fall_silent_stop_homing_in_half_a_second_and_are_named) {
  test::Said said;
  Rig rig({.wired = [](auto& m) {
    unmappable(m, {"x"}, {0x60FD});
    m.sim.axes[0].start = 490;  // 8 s to its switch
  }});
  ASSERT_TRUE(rig.owner().bring_up());
  double at_silence = -1e9;
  bool silent = false;
  rig.owner().on_step([&] {
    const auto& now = rig.owner().latest();
    if (silent || now.state != cycle::State::Homing || now.actual[0] > 400) return;
    silent = true;
    at_silence = now.actual[0];
    static_cast<void>(rig.owner().world()->add_script("- {at: cycle 0, do: slow_mailbox, station: x, by: 3600 s}"));
  });
  const auto homed = rig.owner().home();
  rig.owner().on_step({});
  ASSERT_TRUE(silent);
  ASSERT_FALSE(homed);
  EXPECT_EQ(homed.error().fault, Fault::SwitchesUnseen) << to_text(homed.error());
  EXPECT_NE(to_text(homed.error()).find("axis X"), std::string::npos) << to_text(homed.error());
  // 60 mm/s for half a second, a look that was under way, and the braking distance.
  EXPECT_LT(at_silence - rig.owner().latest().actual[0], 60 * 0.6 + 2 + 1);
  for (int i = 0; i < 3000; ++i) static_cast<void>(rig.owner().idle());
  EXPECT_EQ(said.count({"'x'", "60FDh", "has not answered", "homing ends"}), 1) << said.all();
  // Before it answers again nothing homes; then it does.
  if (const auto reset = rig.owner().order({.kind = run::OrderKind::Reset}); reset)
    static_cast<void>(test::answer_of_reset(rig.owner()));
  const auto again = rig.owner().home();
  ASSERT_FALSE(again);
  EXPECT_EQ(again.error().fault, Fault::SwitchesUnseen) << to_text(again.error());
  EXPECT_NE(to_text(again.error()).find("'x'"), std::string::npos) << to_text(again.error());
  ASSERT_TRUE(rig.owner().world()->add_script("- {at: cycle 0, do: slow_mailbox, station: x, by: 0 s}"));
  for (int i = 0; i < 3000; ++i) static_cast<void>(rig.owner().idle());
  EXPECT_EQ(said.count({"'x'", "60FDh", "answers again"}), 1) << said.all();
  const auto at_last = rig.owner().home();
  EXPECT_TRUE(at_last) << to_text(at_last.error());
}

// What is told of the silence is what comes of it: a job goes on.
TEST(UnseenLimits, limits_that_fall_silent_in_a_job_stop_nothing_and_that_is_told) {
  test::Said said;
  Rig rig({.wired = [](auto& m) { unmappable(m, {"x"}, {0x60FD}); }});
  bool silent = false;
  rig.on_step = [&](run::Owner& owner) {
    if (silent || owner.latest().state != cycle::State::Running) return;
    silent = true;
    static_cast<void>(owner.world()->add_script("- {at: cycle 0, do: slow_mailbox, station: x, by: 3600 s}"));
  };
  const record::JobResult result = rig.run(test::load_recipe("tests/cli/short-board.yaml"));
  EXPECT_TRUE(silent);
  test::expect_done(result);
  EXPECT_EQ(said.count({"'x'", "60FDh", "has not answered", "any other motion goes on"}), 1) << said.all();
  EXPECT_EQ(said.count({"is stopped"}), 0) << said.all();
}

/// A lost frame is no station that was away: what was seen a moment ago is still known.
TEST(UnseenLimits, limits_that_are_polled_stay_known_when_frames_are_lost) {
  std::string script;
  for (int cycle = 500; cycle < 9000; cycle += 37)
    script += fmt::format("- {{at: cycle {}, do: lose_frames, count: 2}}\n", cycle);
  Rig rig({.script = script, .wired = [](auto& m) { unmappable(m, {"x"}, {0x60FD}); }});
  ASSERT_TRUE(rig.owner().bring_up());
  const auto homed = rig.owner().home();
  EXPECT_TRUE(homed) << to_text(homed.error());
}

/// With everything in PDOs a slow mailbox costs nothing but time at bring-up; with modes and switches by SDO the
/// machine homes as well as long as the switches are seen every half second, or is refused by name.
TEST(SlowMailboxes, a_whole_machine_homes_as_well_or_is_refused_by_name_in_bounded_time) {
  const struct {
    int delay_ms;
    bool by_sdo;
  } kRows[] = {{15, false}, {50, false}, {200, false}, {15, true}, {30, true}, {60, true}, {200, true}, {900, false}};
  for (const auto& row : kRows) {
    SCOPED_TRACE(fmt::format("{} ms{}", row.delay_ms, row.by_sdo ? ", by SDO" : ""));
    const test::Said quiet;
    Rig rig({.wired =
                 [&](auto& m) {
                   if (row.by_sdo) unmappable(m, {"x", "y1", "y2", "z", "cu"}, {0x6060, 0x6061, 0x60FD, 0x603F});
                 },
             .habits = all_answer_after(milliseconds(row.delay_ms))});
    const auto begin = std::chrono::steady_clock::now();
    const auto up = rig.owner().bring_up();
    const CycleIndex at_start = rig.owner().latest().cycle;
    Result<void> homed = up;
    if (up) homed = rig.owner().home();
    const double took_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    std::printf("%d ms%s: %s, homing took %.1f s of the machine (%.1f s here)\n", row.delay_ms,
                row.by_sdo ? ", by SDO" : "", homed ? "homed" : to_text(homed.error()).c_str(),
                static_cast<double>(rig.owner().latest().cycle - at_start) * 1e-3, took_s);
    if (!homed) {
      EXPECT_FALSE(homed.error().where.empty()) << to_text(homed.error());
      EXPECT_TRUE(row.by_sdo) << to_text(homed.error());
    } else {
      const auto world = rig.owner().world()->axes();
      ASSERT_TRUE(world);
      for (std::size_t i = 0; i < 5; ++i) EXPECT_NEAR((*world)[i], rig.owner().latest().actual[i], 0.02) << i;
    }
    EXPECT_LT(static_cast<double>(rig.owner().latest().cycle - at_start) * 1e-3, 120);
  }
}

}  // namespace
}  // namespace gantry
