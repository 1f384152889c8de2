// A whole machine whose stations are not what its file says: nothing moves, and the reason is named.
#include <algorithm>
#include <cstdlib>
#include <random>
#include <regex>

#include "tests/altered.hpp"
#include "tests/machine/idle.hpp"
#include "tests/machine/said.hpp"

namespace gantry {
namespace {

using test::holds;
using test::object;
using test::Rig;
using test::station;

struct Altered {
  const char* what;
  std::function<void(config::Machine&)> wired;
  Fault fault;
  const char* names;
};

/// Everything that is asked of a machine, in turn; nothing may move.
TEST(Trust, a_machine_with_one_altered_station_is_refused_by_name_and_does_not_move) {
  const Altered all[] = {
      {"both sides of Y are foreign",
       [](auto& m) { station(m, "y1").profile.identity.vendor = station(m, "y2").profile.identity.vendor = 0x5A5A; },
       Fault::IdentityMismatch, "'y1'"},
      {"X and Z are swapped", [](auto& m) { std::swap(station(m, "x").alias, station(m, "z").alias); },
       Fault::IdentityMismatch, "'z'"},
      {"open loop",
       [](auto& m) {
         holds(m, "x", {0x20D9, 0}, 0);
       },
       Fault::ParameterDiffers, "20D9h"},
      {"another resolution",
       [](auto& m) {
         holds(m, "cu", {0x20F2, 0}, 4000);
       },
       Fault::ParameterDiffers, "20F2h"},
      {"limit functions cannot be written",
       [](auto& m) {
         object(m, "z", {0x2190, 2}).writable = false;
       },
       Fault::ParameterDiffers, "2190h:2"},
      {"the other polarity of its inputs",
       [](auto& m) {
         holds(m, "y1", {0x2154, 0}, 0);
         object(m, "y1", {0x2154, 0}).writable = false;
       },
       Fault::ParameterDiffers, "2154h"},
      {"a filter of 100 ms on its limit",
       [](auto& m) {
         holds(m, "y2", {0x2161, 0}, 100);
         object(m, "y2", {0x2161, 0}).writable = false;
       },
       Fault::ParameterDiffers, "2161h"},
      {"soft limits that nobody asked for",
       [](auto& m) {
         holds(m, "cu", {0x2144, 0}, 3);
         object(m, "cu", {0x2144, 0}).writable = false;
       },
       Fault::ParameterDiffers, "2144h"},
      {"another motor current",
       [](auto& m) {
         holds(m, "y1", {0x2000, 0}, 8000);
       },
       Fault::ParameterDiffers, "run_current"},
  };
  for (const Altered& a : all) {
    Rig rig({.wired = a.wired});
    AxisVec first{};
    bool any = false, moved = false, torque = false;
    rig.owner().on_step([&] {
      const auto& now = rig.owner().latest();
      if (!any) first = now.target, any = true;
      for (std::size_t i = 0; i < 5; ++i) moved = moved || now.target[i] != first[i];
      torque = torque || now.enabled != 0;
    });
    const auto up = rig.owner().bring_up();
    Error why;
    if (!up) {
      why = up.error();
    } else {
      const auto enabled = rig.owner().enable();
      ASSERT_FALSE(enabled) << a.what;
      why = enabled.error();
      EXPECT_FALSE(rig.owner().home()) << a.what;
      job::JogWords words;
      words.by["X"] = "1 mm";
      EXPECT_FALSE(rig.owner().jog(words)) << a.what;
      EXPECT_NE(rig.run("recipes/demo-board.yaml").exit_code, ExitCode::Done) << a.what;
    }
    EXPECT_EQ(why.fault, a.fault) << a.what << ": " << to_text(why);
    EXPECT_NE(to_text(why).find(a.names), std::string::npos) << a.what << ": " << to_text(why);
    EXPECT_FALSE(moved) << a.what;
    EXPECT_FALSE(torque) << a.what;
    rig.owner().on_step({});
  }
}

/// Homing with what is altered: its error, and how far the axis went after the switch had closed, mm.
TEST(Trust, limits_that_are_swapped_end_homing_at_once_and_are_named) {
  for (const char* name : {"x", "z", "y2"}) {
    Rig rig({.wired = [&](auto& m) {
      auto& drive = *station(m, name).profile.drive;
      std::swap(drive.input_neg_limit, drive.input_pos_limit);
    }});
    ASSERT_TRUE(rig.owner().bring_up());
    const auto homed = rig.owner().home();
    ASSERT_FALSE(homed) << name;
    EXPECT_EQ(homed.error().fault, Fault::HomingWrongLimit) << to_text(homed.error());
    EXPECT_EQ(rig.owner().latest().state, cycle::State::Stopped);
  }
}

TEST(Trust, a_swap_shows_where_an_axis_begins_on_its_limit_and_homes_at_a_switch_of_its_own) {
  for (const bool swapped : {false, true}) {
    Rig rig({.wired = [&](auto& m) {
      m.sim.axes[4].start = m.sim.axes[4].neg_limit - 0.5;  // U
      if (!swapped) return;
      auto& drive = *station(m, "cu").profile.drive;
      std::swap(drive.input_neg_limit, drive.input_pos_limit);
    }});
    ASSERT_TRUE(rig.owner().bring_up());
    const auto homed = rig.owner().home();
    EXPECT_EQ(homed.has_value(), !swapped) << (homed ? "" : to_text(homed.error()));
    if (homed) continue;
    EXPECT_EQ(homed.error().fault, Fault::HomingWrongLimit) << to_text(homed.error());
    EXPECT_EQ(homed.error().where.rfind("axis U", 0), 0u) << to_text(homed.error());
  }
}

// Both of Y home as long as from 160 mm; X meets its wrong limit after 2 mm.
TEST(Trust, an_axis_that_gives_up_is_told_at_once_and_ends_the_homing_of_the_others) {
  Rig rig({.wired = [](auto& m) {
    m.sim.axes[0].start = 0;
    auto& drive = *station(m, "x").profile.drive;
    std::swap(drive.input_neg_limit, drive.input_pos_limit);
  }});
  ASSERT_TRUE(rig.owner().bring_up());
  const double y_before = rig.owner().latest().actual[1];
  double y_at_fault = 0, told_ms = 0, over_ms = 0;
  rig.owner().on_step([&] {
    const cycle::Snapshot& s = rig.owner().latest();
    const double now_ms = static_cast<double>(s.time_ns) / 1e6;
    if (s.latched != Fault::None && told_ms == 0) told_ms = now_ms, y_at_fault = s.actual[1];
    if (s.state == cycle::State::Homing) over_ms = now_ms;
  });
  const auto homed = rig.owner().home();
  ASSERT_FALSE(homed);
  EXPECT_EQ(homed.error().fault, Fault::HomingWrongLimit) << to_text(homed.error());
  EXPECT_EQ(homed.error().where.rfind("axis X", 0), 0u) << to_text(homed.error());
  EXPECT_GT(y_at_fault - y_before, -20) << "of 162 mm to its own switch";
  EXPECT_LT(over_ms - told_ms, 500) << "the others have braked";
  EXPECT_LT(std::abs(rig.owner().latest().actual[1] - y_at_fault), 6) << "60 mm/s at 1000 mm/s^2, and the drive's halt";
}

TEST(Trust, a_limit_that_is_shown_at_another_bit_is_missed) {
  Rig rig({.wired = [](auto& m) { station(m, "x").profile.drive->input_neg_limit = 5; }});
  ASSERT_TRUE(rig.owner().bring_up());
  const auto homed = rig.owner().home();
  ASSERT_FALSE(homed);
  EXPECT_EQ(homed.error().fault, Fault::HomingFailed) << to_text(homed.error());
}

/// The lift has no encoder: a limit that its drive keeps by itself (one of its inputs, its own soft limits) stops it
/// at 20 mm, and 6064h alone tells.
TEST(Trust, a_lift_that_stops_short_is_named_in_a_jog_and_in_a_job) {
  const auto jog_up = [](Rig& rig) {
    EXPECT_TRUE(rig.owner().bring_up());
    EXPECT_TRUE(rig.owner().home());
    job::JogWords up;
    up.by["U"] = "38 mm", up.speed = "30 mm/s";
    return rig.owner().jog(up);
  };
  const auto stops_at_20 = [](config::Machine& m, std::int8_t limit, std::int8_t follows) {
    config::DriveFacts& lift = *station(m, "cu").profile.drive;
    lift.input_pos_limit = 20;  // the input is another one
    lift.status_limit = limit, lift.status_follows = follows;
    m.sim.axes[4].pos_limit = 20;
  };
  const struct {
    std::int8_t limit, follows;
    Fault fault;
  } kRows[] = {{11, 12, Fault::LimitSwitch}, {-1, 12, Fault::NotFollowing}, {-1, -1, Fault::NotFollowing}};
  for (const auto& row : kRows) {
    Rig rig({.placement = "dx=0 mm", .wired = [&](auto& m) { stops_at_20(m, row.limit, row.follows); }});
    const auto up = jog_up(rig);
    ASSERT_FALSE(up);
    EXPECT_EQ(up.error().fault, row.fault) << to_text(up.error());
    EXPECT_NE(up.error().where.find("axis U"), std::string::npos) << to_text(up.error());
    // 20 cycles at 30 mm/s (R45), and 1.5 mm of braking within its limits.
    EXPECT_LT(rig.owner().latest().target[4], 20 + 0.6 + 1.5 + 0.3);
    if (row.fault != Fault::NotFollowing) continue;
    EXPECT_NE(up.error().message.find("6064h is at 2"), std::string::npos) << to_text(up.error());
  }
  Rig rig({.placement = "dx=0 mm", .wired = [&](auto& m) { stops_at_20(m, -1, -1); }});
  ASSERT_TRUE(rig.owner().bring_up());
  const auto done = rig.run("recipes/demo-board.yaml");
  ASSERT_FALSE(done.errors.empty());
  EXPECT_EQ(done.errors.front().fault, Fault::NotFollowing) << to_text(done.errors.front());
}

TEST(Trust, a_limit_that_is_stuck_is_not_driven_away_from_over_the_whole_axis) {
  Rig rig({.wired = [](auto& m) { m.sim.axes[0].neg_limit = 700; }});  // closed wherever X is
  ASSERT_TRUE(rig.owner().bring_up());
  const double start = rig.owner().latest().actual[0];
  const auto homed = rig.owner().home();
  ASSERT_FALSE(homed);
  EXPECT_EQ(homed.error().fault, Fault::HomingSwitchStuck) << to_text(homed.error());
  EXPECT_LT(std::abs(rig.owner().latest().actual[0] - start), 22);
}

TEST(Trust, a_drive_whose_speeds_have_another_unit_is_stopped) {
  Rig rig({.wired = [](auto& m) { station(m, "x").profile.drive->velocity_counts_s = 4; }});
  ASSERT_TRUE(rig.owner().bring_up());
  const auto homed = rig.owner().home();
  ASSERT_FALSE(homed);
  EXPECT_EQ(homed.error().fault, Fault::HomingTooFast) << to_text(homed.error());
}

/// The simulated machine's beam begins racked: y2 is an axis of its own there, which starts elsewhere.
void racked(config::Machine& m, double by) {
  const std::size_t y = 1;
  config::Axis side = m.axes[y];
  side.id = AxisId{static_cast<std::uint8_t>(m.axes.size())};
  side.name = "Y2";
  side.drives = {m.axes[y].drives[1]};
  m.axes[y].drives.pop_back();
  config::SimAxis truth = m.sim.axes[y];
  truth.start += by;
  m.axes.push_back(side);
  m.sim.axes.push_back(truth);
}

/// What homing has taken out of a beam is told, within what a side may be ahead by in some cycles at 60 mm/s.
void expect_told_apart(const std::string& said, double by_mm) {
  const std::regex words(
      fmt::format("axis Y: .* \\(by ([0-9]+) um\\) .{}", std::string_view(code(Fault::SidesApartInHoming))));
  std::smatch found;
  const bool told = std::regex_search(said, found, words);
  if (by_mm > 0.5) {
    ASSERT_TRUE(told) << by_mm << "\n" << said;
    EXPECT_NEAR(std::stod(found[1]) / 1000, by_mm, 0.3) << said;
  } else if (by_mm < 0.05) {
    EXPECT_FALSE(told) << said;
  }
}

// Both sides home at switches that stand square: afterwards they have one coordinate, and in truth, too.
TEST(Trust, a_racked_beam_is_squared_within_two_counts_or_refused) {
  std::mt19937_64 random(5);
  const char* more = std::getenv("GANTRY_ROUNDS");
  const int rounds = more != nullptr ? std::atoi(more) : 30;
  for (int i = 0; i < rounds; ++i) {
    const double by = std::uniform_real_distribution(-80.0, 80.0)(random);
    Rig rig({.change = [](auto& m) { m.axes[1].homing->rack_max = 53.75; }, .wired = [&](auto& m) { racked(m, by); }});
    ASSERT_TRUE(rig.owner().bring_up());
    const test::Said said;
    const auto homed = rig.owner().home();
    if (std::abs(by) < 53.75) {
      ASSERT_TRUE(homed) << by << " " << to_text(homed.error());
    }
    // rack_max, the 60^2 / (2 x 1000) mm in which homing brakes, and 60 mm/s for two cycles and for the one that sees
    // it.
    if (std::abs(by) > 55.75) {
      ASSERT_FALSE(homed) << by;
      EXPECT_EQ(homed.error().fault, Fault::GantrySkew) << to_text(homed.error());
    }
    if (!homed) continue;
    expect_told_apart(said.all(), std::abs(by));
    for (int k = 0; k < 200; ++k) ASSERT_TRUE(rig.owner().idle());
    const auto& s = rig.owner().latest();
    EXPECT_EQ(s.state, cycle::State::Ready);
    EXPECT_LE(std::abs(s.counts[1] - s.counts[2]), 2) << by;
    const auto truth = rig.owner().world()->axes();
    ASSERT_TRUE(truth);
    const std::size_t second = rig.machine().axes.size();
    EXPECT_LE(std::abs((*truth)[1] - (*truth)[second]) * rig.machine().axes[1].counts_per_unit, 2) << by;
  }
}

// The beam is stopped before it is racked by what it does not bear: 12 mm of the machine file, and twice the braking
// distance of homing.
TEST(Trust, a_side_that_homes_at_half_the_speed_racks_the_beam_no_farther_than_it_bears) {
  Rig rig({.wired = [](auto& m) { station(m, "y2").profile.drive->velocity_counts_s /= 2; }});
  ASSERT_TRUE(rig.owner().bring_up());
  std::int64_t most = 0;
  rig.owner().on_step([&] {
    const auto& s = rig.owner().latest();
    if (s.state == cycle::State::Homing || s.state == cycle::State::Stopping)
      most = std::max<std::int64_t>(most, std::abs(std::int64_t{s.counts[1]} - s.counts[2]));
  });
  const auto homed = rig.owner().home();
  rig.owner().on_step({});
  ASSERT_FALSE(homed);
  EXPECT_EQ(homed.error().fault, Fault::GantrySkew) << to_text(homed.error());
  EXPECT_LT(most, 16'000) << "counts of 1 um";
}

// AMD530B 7.2: a probe works on DI4 alone, the emergency stop's input. Refused before anything is sent.
TEST(Trust, a_wire_is_not_opened_for_a_probe_in_place_of_an_emergency_stop_or_a_current_that_nobody_states) {
  const auto opened = [](const std::function<void(config::Machine&)>& change) {
    auto m = *config::load_machine("config/machines/dispenser.yaml");
    change(m);
    run::OwnerOptions options;
    options.bus = "ethercat:none0";
    return run::Owner::open(m, options).error();
  };
  EXPECT_EQ(opened([](auto&) {}).fault, Fault::InterfaceUnusable) << "there is no such interface";
  const auto on_di4 = [](auto& m) { station(m, "z").profile.drive->probe_takes_emergency_stop = true; };
  const Error lost = opened(on_di4);
  EXPECT_EQ(lost.fault, Fault::MissingKey);
  EXPECT_NE(lost.message.find("'z'"), std::string::npos) << lost.message;
  EXPECT_NE(lost.message.find("emergency_stop_elsewhere"), std::string::npos) << lost.message;
  const auto elsewhere = [&](auto& m) { on_di4(m), station(m, "z").emergency_stop_elsewhere = true; };
  EXPECT_EQ(opened(elsewhere).fault, Fault::InterfaceUnusable);
  const Error current = opened([](auto& m) { station(m, "cu").profile.not_stated = {"run_current"}; });
  EXPECT_EQ(current.fault, Fault::MissingKey);
  EXPECT_NE(current.message.find("'cu'"), std::string::npos) << current.message;
}

}  // namespace
}  // namespace gantry
