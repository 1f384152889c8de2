// Stations that leave OP or lose their supply while an owner is idle: they come back by themselves, their axes do not.
#include <fmt/format.h>

#include "tests/machine/idle.hpp"
#include "tests/machine/said.hpp"

namespace gantry {
namespace {

using cycle::State;
using test::Idle;
using test::Said;

constexpr std::uint32_t kAll = test::kAllAxes;

/// Stations are back, their axes are not; the operator's orders bring those back, and nothing has moved before.
void expect_back_only_by_the_operator(Idle& idle, std::uint32_t away) {
  idle.pass_to(idle.now().cycle + 2000);
  EXPECT_TRUE(idle.whole()) << idle.now().al_states << ", " << idle.now().working_counter;
  EXPECT_EQ(idle.now().state, State::Stopped);
  EXPECT_EQ(idle.now().enabled & away, 0u) << "nobody has enabled it again";
  const auto refused = idle.owner().enable();
  EXPECT_FALSE(refused && idle.now().enabled == kAll) << "a latch is to be reset first";
  ASSERT_TRUE(idle.owner().order({.kind = run::OrderKind::Reset}));
  idle.pass_to(idle.now().cycle + 1500);
  EXPECT_EQ(idle.now().latched, Fault::None);
  EXPECT_EQ(idle.now().enabled & away, 0u) << "a reset enables nothing";
  for (std::size_t i = 0; i < 5; ++i) {
    if ((away >> i & 1u) == 0) {
      EXPECT_NEAR(idle.now().actual[i], idle.stood_at[i], 0.02) << i;
    }
  }
  const auto enabled = idle.owner().enable();
  ASSERT_TRUE(enabled) << to_text(enabled.error());
  EXPECT_EQ(idle.now().enabled, kAll);
  EXPECT_EQ(idle.now().state, State::Ready) << "enabling moves no axis";
  const auto homed = idle.owner().home();
  ASSERT_TRUE(homed) << to_text(homed.error());
  EXPECT_EQ(idle.now().referenced & kAll, kAll);
}

TEST(Recovery, a_station_behind_a_cut_that_is_healed_fell_to_safe_op_and_comes_back) {
  Idle idle("[{at: cycle 20000, do: cut_link, station: cu}, {at: cycle 21000, do: heal_link, station: cu}]");
  idle.pass_to(20'500);
  EXPECT_LT(idle.now().working_counter, idle.now().expected);
  EXPECT_EQ(idle.now().enabled & 0b00111, 0b00111u) << "the others hold their positions";
  ASSERT_TRUE(idle.until([&] { return idle.now().cycle > 21'000 && idle.whole(); }, 1500));
  EXPECT_LT(idle.now().cycle, 22'000);
  expect_back_only_by_the_operator(idle, 0b11000);
}

// R09.
TEST(Recovery, a_station_that_lost_its_power_comes_back_and_the_others_go_on) {
  for (const char* name : {"x", "y1", "z", "io"}) {
    SCOPED_TRACE(name);
    Idle idle(fmt::format("[{{at: cycle 20000, do: power_cycle, station: {}}}]", name));
    idle.pass_to(20'100);
    ASSERT_TRUE(idle.until([&] { return idle.whole(); }, 3000));
    // It is dark for 200 ms, and back within half a second after it answers.
    EXPECT_LT(idle.now().cycle, 20'000 + 200 + 500);
    EXPECT_LT(idle.longest_idle, 1000);
    idle.pass_to(idle.now().cycle + 100);
    EXPECT_EQ(idle.now().state, State::Stopped);
  }
}

TEST(Recovery, all_stations_that_lost_their_power_come_back) {
  std::string script = "[";
  for (const char* name : {"x", "y1", "y2", "z", "cu", "io"})
    script += fmt::format("{{at: cycle 20000, do: power_cycle, station: {}}}, ", name);
  Idle idle(script + "]");
  idle.pass_to(20'100);
  EXPECT_EQ(idle.now().working_counter, 0);
  ASSERT_TRUE(idle.until([&] { return idle.whole(); }, 5000)) << idle.now().al_states;
  expect_back_only_by_the_operator(idle, kAll);
}

TEST(Recovery, a_reset_that_comes_too_early_names_what_stays_and_counts_nothing) {
  Idle idle("[{at: cycle 20000, do: cut_link, station: cu}]");
  idle.pass_to(20'500);
  ASSERT_TRUE(idle.owner().order({.kind = run::OrderKind::Reset}));
  const auto answer = test::answer_of_reset(idle.owner());
  ASSERT_FALSE(answer);
  EXPECT_NE(answer.error().message.find("G104"), std::string::npos) << answer.error().message;
  EXPECT_EQ(answer.error().message.find("working counter 0"), std::string::npos) << answer.error().message;
}

TEST(Recovery, a_station_that_was_being_asked_who_it_is_when_the_line_broke_comes_back) {
  for (int after = 120; after < 170;
       after += 5) {  // it answers from 20 ms on, and is asked 100 cycles after it has gone
    SCOPED_TRACE(after);
    Idle idle(
        fmt::format("[{{at: cycle 20000, do: power_cycle, station: cu, dark: 20 ms}},"
                    " {{at: cycle {}, do: power_cycle, station: y1, dark: 300 ms}}]",
                    20'000 + after));
    idle.pass_to(20'300);
    ASSERT_TRUE(idle.until([&] { return idle.whole(); }, 5000));
  }
}

TEST(Recovery, the_masters_own_cable_cut_and_healed_brings_all_back_and_enables_none) {
  Idle idle("[{at: cycle 20000, do: cut_link, station: io}, {at: cycle 21000, do: heal_link, station: io}]");
  idle.pass_to(20'900);
  idle.stood_at = idle.now().actual;
  ASSERT_TRUE(idle.until([&] { return idle.now().cycle > 21'000 && idle.whole(); }, 5000)) << idle.now().al_states;
  expect_back_only_by_the_operator(idle, kAll);
}

TEST(Recovery, frames_that_are_lost_until_every_watchdog_bites_bring_all_back_and_enable_none) {
  Idle idle("[{at: cycle 20000, do: lose_frames, count: 150}]");
  ASSERT_TRUE(idle.until([&] { return idle.now().al_states != 0 && idle.now().al_states != 8; }, 1000));
  EXPECT_EQ(idle.now().working_counter, idle.now().expected) << "stations in SAFE_OP count in full";
  ASSERT_TRUE(idle.until([&] { return idle.whole(); }, 2000)) << idle.now().al_states;
  expect_back_only_by_the_operator(idle, kAll);
}

TEST(Recovery, a_bus_that_is_down_for_ever_neither_hangs_the_owner_nor_fills_the_log) {
  Said said;
  Idle idle("[{at: cycle 20000, do: cut_link, station: io}]");
  const std::size_t before = said.lines().size();
  idle.pass_to(50'000);
  EXPECT_LT(idle.longest_idle, 200) << "orders are served all the time";
  EXPECT_LT(said.lines().size() - before, 10u) << said.all();
  ASSERT_TRUE(idle.owner().order({.kind = run::OrderKind::Reset}));
  idle.pass_to(51'000);
  EXPECT_NE(idle.now().latched, Fault::None);
  idle.owner().shut_down();
}

TEST(Recovery, one_station_that_stays_away_is_named_once_and_the_others_stay_in_op) {
  Said said;
  Idle idle("[{at: cycle 20000, do: cut_link, station: cu}]");
  idle.pass_to(40'000);
  EXPECT_LT(idle.longest_idle, 200);
  EXPECT_EQ(said.count({"station 5 'cu'", "does not answer"}), 1) << said.all();
  EXPECT_EQ(said.count({"station 4 'z'", "does not answer"}), 0) << said.all();
  EXPECT_EQ(idle.now().enabled & 0b00111, 0b00111u);
  EXPECT_EQ(idle.now().al_states, 8);
}

}  // namespace
}  // namespace gantry
