// Drives that are to brake by themselves and do not: a ramp that is weak, or in another unit, on the station's side
// alone. Judged by the motors of the simulated machine, which without torque are slowed down by friction only.
#include "app/cycle/own_braking.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "app/job/limits.hpp"
#include "config/quick_stop.hpp"
#include "motion/path/moves.hpp"
#include "tests/app/cycle/loop_bench.hpp"

namespace gantry {
namespace {

using cycle::State;
using test::LoopBench;

constexpr AxisId kY{1};
constexpr config::ObjectAddress kQuickRamp{0x6085, 0};
constexpr double kStrong = 4e6, kWeak = 2e4;  // counts/s^2 of 1 um: 4000 and 20 mm/s^2

struct BrakingBench : LoopBench {
  explicit BrakingBench(config::Machine m = test::reference_machine()) : LoopBench(std::move(m)) {
    operate();
    enable();
    home();
  }
  void ramps(double y1, double y2) {
    ASSERT_TRUE(segment.set_object(drive(0).station, kQuickRamp, static_cast<std::int64_t>(y1)));
    ASSERT_TRUE(segment.set_object(drive(1).station, kQuickRamp, static_cast<std::int64_t>(y2)));
  }
  [[nodiscard]] const config::DriveRef& drive(std::size_t side) const { return machine.axes[kY.value].drives[side]; }
  [[nodiscard]] double side(int n) const { return segment.motor(kY, n).position(); }
  /// Y is on its way, and as fast as that.
  void go(double mm_s) {
    AxisVec to = now.target;
    to[1] = 390;
    motion::Limits limits = job::limits_of(machine);
    limits.axis[1].v_max = mm_s;
    play(motion::line_move(limits, now.target, to));
    ASSERT_TRUE(until([&] { return now.target[1] > 60; }, 5000));
    from = side(0);
  }
  void look(int cycles) {
    for (int i = 0; i < cycles; ++i) {
      tick();
      apart = std::max(apart, std::abs(side(0) - side(1)));
      gone = std::max({gone, side(0) - from, side(1) - from});
    }
  }
  /// Z's emergency input: the machine stops quickly.
  void stop() { segment.drive_fault(machine.z, 0, 0x400); }
  void stop_from(double mm_s) {
    go(mm_s);
    stop();
    look(1000);
  }
  double from = 0, apart = 0, gone = 0;
};

TEST(OwnBraking, a_quick_stop_that_brakes_is_believed) {
  for (const double mm_s : {20.0, 170.0, 500.0}) {
    SCOPED_TRACE(mm_s);
    BrakingBench b;
    b.stop_from(mm_s);
    EXPECT_EQ(b.told(Fault::NotBraking) + b.told(Fault::GantrySkew), 0);
    EXPECT_EQ(b.now.state, State::Stopped);
    EXPECT_LT(b.gone, mm_s * mm_s / 8000 + mm_s * 0.02 + 0.1);
  }
}

// By friction (1500 mm/s^2) it goes 9.6 mm from 170 mm/s, by the ramp 722.
TEST(OwnBraking, an_axis_that_its_quick_stop_does_not_brake_loses_its_torque_and_that_is_told) {
  BrakingBench b;
  b.ramps(kWeak, kWeak);
  b.stop_from(170);
  EXPECT_EQ(b.told(Fault::NotBraking), 1);
  EXPECT_EQ(b.now.latched, Fault::DriveEmergencyInput) << "that was first";
  EXPECT_LT(b.gone, 35);
  EXPECT_LT(b.apart, 1);
  EXPECT_EQ(b.now.enabled & 0b10u, 0u);
}

TEST(OwnBraking, sides_that_brake_differently_run_out_beside_each_other) {
  for (const auto& [y1, y2] : {std::pair{kStrong, kWeak}, {kWeak, kStrong}, {kStrong, kStrong / 5}}) {
    SCOPED_TRACE(testing::Message() << y1 << " " << y2);
    BrakingBench b;
    b.ramps(y1, y2);
    b.stop_from(170);
    EXPECT_EQ(b.told(Fault::GantrySkew) + b.told(Fault::NotBraking), 1);
    EXPECT_LT(b.apart, 13) << "what the beam bears";
    EXPECT_EQ(b.now.enabled & 0b10u, 0u);
  }
}

/// What a drive does that runs away: it is as fast as it was and gains nothing by that.
// 605Ah was read back as it should be, and the drive takes its torque all the same; friction alone is left.
TEST(OwnBraking, an_axis_that_runs_out_instead_of_braking_is_told) {
  config::Machine m = test::reference_machine();
  m.sim.axes[kY.value].coast = 300;
  for (config::Station& station : m.stations)
    if (station.profile.drive) station.profile.drive->quick_stop_coasts = 1;  // a 0 takes the torque
  for (const bool both : {true, false}) {
    BrakingBench b(m);
    for (std::size_t side = both ? 0 : 1; side < 2; ++side)
      ASSERT_TRUE(b.segment.set_object(b.drive(side).station, {0x605A, 0}, 0));
    b.stop_from(170);
    EXPECT_EQ(b.told(Fault::NotBraking) + b.told(Fault::GantrySkew), 1) << both;
    EXPECT_EQ(b.now.enabled & 0b10u, 0u);
  }
  BrakingBench sound(m);
  sound.stop_from(170);
  EXPECT_EQ(sound.told(Fault::NotBraking) + sound.told(Fault::GantrySkew), 0);
}

TEST(OwnBraking, the_speed_that_a_drive_gains_when_it_is_told_to_stop_lets_it_go_no_farther) {
  const cycle::BrakingReach reach{.deceleration = 4000, .late_s = 0.072, .slack = 0.5, .gains = 116};
  cycle::OwnBraking sound, away;
  double at = 0, v = 173, sound_at = 0, sound_v = 173;
  int ms = 0;
  for (; ms < 1000 && away.gone() <= reach.of(away.from_speed()); ++ms) {
    away.see(true, at, v, false, 0.001, reach);
    sound.see(true, sound_at, sound_v, false, 0.001, reach);
    v += 20, at += v * 0.001;  // 20 m/s^2
    sound_v = std::max(0.0, sound_v - 4), sound_at += sound_v * 0.001;
    ASSERT_LE(sound.gone(), reach.of(sound.from_speed()));
  }
  EXPECT_LT(away.gone(), 42)
      << "from 349 mm/s at most (233 in its third cycle): 15 mm of braking and 25 until it begins";
  EXPECT_LT(ms, 60);
}

TEST(OwnBraking, frames_that_are_lost_as_it_is_told_make_it_no_faster) {
  BrakingBench b;
  b.ramps(kWeak, kWeak);
  b.go(170);
  b.stop();
  b.look(4);
  b.segment.lose_frames(2);
  b.look(1000);
  EXPECT_EQ(b.told(Fault::NotBraking), 1);
  EXPECT_LT(b.gone, 40);
}

// The reaction of a drive to a fault of its own takes the same ramp there.
TEST(OwnBraking, a_side_whose_fault_brakes_weakly_does_not_run_on_alone) {
  BrakingBench b;
  b.ramps(kStrong, kWeak);
  b.go(170);
  b.segment.drive_fault(kY, 1, 0x0E);
  b.look(1000);
  EXPECT_EQ(b.told(Fault::GantrySkew) + b.told(Fault::NotBraking), 1);
  EXPECT_EQ(b.now.enabled & 0b10u, 0u);
}

// One side says what its quick stop does, the other one does not: y1 alone would stand 19 mm before y2.
TEST(OwnBraking, sides_of_a_beam_stop_in_one_way) {
  config::Machine m = test::reference_machine();
  for (config::Station& s : m.stations)
    if (s.name == "y2")
      std::erase_if(s.profile.startup, [](const config::StartupRow& row) { return row.address.index == 0x605A; });
  ASSERT_EQ(config::quick_stop_of(m, m.axes[kY.value]), config::QuickStop::Unknown);
  BrakingBench b(m);
  b.stop_from(170);
  EXPECT_LT(b.apart, 0.1);
  EXPECT_EQ(b.now.state, State::Stopped);
  EXPECT_EQ(b.now.enabled, 0u);
}

// From 110 mm/s at 30 mm/s^2 it takes 3.7 s; a stop waits for 3.
TEST(OwnBraking, torque_that_goes_while_an_axis_still_moves_is_told) {
  config::Machine m = test::reference_machine();
  m.axes[0].a_max = 30, m.axes[0].j_max = 500;  // of X, which its targets brake
  BrakingBench b(m);
  AxisVec to = b.now.target;
  to[0] = 450;
  b.play(motion::line_move(job::limits_of(b.machine), b.now.target, to));
  ASSERT_TRUE(b.until([&] { return b.now.target[0] > 225; }, 9000));
  b.stop();
  b.ticks(3500);
  EXPECT_EQ(b.told(Fault::NotBraking), 1);
  EXPECT_EQ(b.now.enabled, 0u);
}

// The stop is over and X goes on saying that it has torque: the fault of Z does not explain that.
TEST(OwnBraking, a_drive_that_keeps_its_torque_is_told_though_another_fault_is_latched) {
  BrakingBench b;
  b.segment.stick_statusword(AxisId{0}, 0, true);
  b.stop();
  b.ticks(3000);
  EXPECT_EQ(b.now.state, State::Stopped);
  EXPECT_NE(b.now.latched, Fault::TransitionTimeout);
  EXPECT_EQ(b.told(Fault::TransitionTimeout), 1);
  BrakingBench sound;
  sound.stop();
  sound.ticks(3000);
  EXPECT_EQ(sound.told(Fault::TransitionTimeout), 0);
}

// Homing is ended by clearing its start bit, and a drive then stops by 609Ah: at a fiftieth of it, 90 mm from 60 mm/s.
// R39.
TEST(OwnBraking, a_drive_that_runs_on_when_its_homing_is_ended_loses_its_torque) {
  constexpr config::ObjectAddress kHomingRamp{0x609A, 0};
  constexpr AxisId kX{0};
  for (const bool weak : {false, true}) {
    SCOPED_TRACE(weak);
    BrakingBench b;
    AxisVec to = b.now.target;
    to[0] = 300;
    b.play(motion::line_move(job::limits_of(b.machine), b.now.target, to));
    ASSERT_TRUE(b.until([&] { return b.now.state == State::Ready; }, 5000));
    ASSERT_TRUE(b.channels->commands.push({.kind = cycle::CommandKind::Home, .id = 1000, .axes = 1}));
    ASSERT_TRUE(b.until([&] { return b.segment.motor(kX, 0).velocity() < -59; }, 5000));
    const double from = b.segment.motor(kX, 0).position();
    ASSERT_TRUE(b.segment.set_object(b.machine.axes[0].drives[0].station, kHomingRamp, weak ? 20'000 : 1'000'000));
    ASSERT_TRUE(b.channels->commands.push({.kind = cycle::CommandKind::Abort, .id = 1001}));
    double gone = 0;
    for (int i = 0; i < 3000; ++i) {
      b.tick();
      gone = std::max(gone, std::abs(b.segment.motor(kX, 0).position() - from));
    }
    EXPECT_EQ(b.told(Fault::NotBraking), weak ? 1 : 0);
    EXPECT_LT(gone, weak ? 12 : 4);
    EXPECT_EQ((b.now.enabled & 1u) == 0, weak);
  }
}

// What stops it by one ramp may be told to by another one: each is judged from where it begins.
TEST(OwnBraking, a_homing_that_ends_softly_and_is_stopped_meanwhile_is_no_drive_that_runs_on) {
  config::Machine m = test::reference_machine();
  for (const std::size_t axis : {0u, 1u})
    m.axes[axis].homing->acceleration = 250;  // stands after a quarter of a second
  for (const int n : {20, 60, 100, 150, 200, 300, -100, -150, -200}) {
    const int later = std::abs(n);
    SCOPED_TRACE(n);
    BrakingBench b(m);
    AxisVec to = b.now.target;
    to[0] = 300, to[1] = 300;
    b.play(motion::line_move(job::limits_of(b.machine), b.now.target, to));
    ASSERT_TRUE(b.until([&] { return b.now.state == State::Ready; }, 5000));
    ASSERT_TRUE(b.channels->commands.push({.kind = cycle::CommandKind::Home, .id = 1000, .axes = 3}));
    ASSERT_TRUE(b.until([&] { return b.segment.motor(kY, 0).velocity() < -59; }, 5000));
    ASSERT_TRUE(b.channels->commands.push({.kind = cycle::CommandKind::Abort, .id = 1001}));
    b.ticks(later);
    if (n > 0)
      b.stop();
    else
      b.segment.power_off(b.drive(0).station);  // and is heard no more
    b.ticks(2000);
    EXPECT_EQ(b.told(Fault::NotBraking), 0);
  }
}

// Of a station without 609Ah nobody knows the ramp: it is not judged by the one that the machine file asks for.
TEST(OwnBraking, a_homing_that_ends_by_a_ramp_of_the_drives_own_is_not_judged) {
  constexpr config::ObjectAddress kHomingRamp{0x609A, 0};
  config::Machine m = test::reference_machine();
  config::Axis& y = m.axes[kY.value];
  y.homing->fast = 280, y.homing->acceleration = 4000;  // the virtual drive's own is a quarter of that
  for (const config::DriveRef& ref : y.drives)
    std::erase_if(m.stations[ref.station.value].profile.objects,
                  [&](const auto& row) { return row.address == kHomingRamp; });
  LoopBench b(m);
  b.operate();
  b.enable();
  EXPECT_FALSE(b.master->has_row(y.drives[0].station, kHomingRamp));
  EXPECT_TRUE(b.master->has_row(m.axes[0].drives[0].station, kHomingRamp));
  ASSERT_TRUE(b.channels->commands.push({.kind = cycle::CommandKind::Home, .id = 1000, .axes = 2}));
  ASSERT_TRUE(b.until([&] { return b.segment.motor(kY, 0).velocity() < -270; }, 5000));
  const double from = b.segment.motor(kY, 0).position();
  ASSERT_TRUE(b.channels->commands.push({.kind = cycle::CommandKind::Abort, .id = 1001}));
  b.ticks(2000);
  EXPECT_GT(from - b.segment.motor(kY, 0).position(), 30);
  EXPECT_EQ(b.told(Fault::NotBraking), 0);
}

// The edge at which a drive sets its counter may come while it stops: that is no way that it has gone.
TEST(OwnBraking, a_counter_that_is_set_while_homing_ends_is_no_motion) {
  config::Machine m = test::reference_machine();
  m.bus.cycle = milliseconds(4);
  /// Of Z; cycles until its counter jumps, or until it stands again.
  const auto homes_for = [&](int until, int* notes) {
    LoopBench b(m);
    b.operate();
    b.enable();
    EXPECT_TRUE(b.channels->commands.push({.kind = cycle::CommandKind::Home, .id = 1000, .axes = 1u << m.z.value}));
    int cycles = 0;
    for (double before = b.now.actual[m.z.value]; cycles < until; ++cycles) {
      b.tick();
      if (std::abs(std::exchange(before, b.now.actual[m.z.value]) - b.now.actual[m.z.value]) > 5) break;
    }
    if (notes == nullptr) return cycles;
    EXPECT_TRUE(b.channels->commands.push({.kind = cycle::CommandKind::Abort, .id = 1001}));
    b.ticks(300);
    *notes = b.told(Fault::NotBraking);
    return cycles;
  };
  const int edge = homes_for(5000, nullptr);
  ASSERT_LT(edge, 5000);
  for (int before = 0; before < 8; ++before) {
    SCOPED_TRACE(before);
    int notes = 0;
    homes_for(edge - before, &notes);
    EXPECT_EQ(notes, 0);
  }
}

TEST(OwnBraking, a_ramp_that_is_far_below_the_axis_is_none) {
  config::Machine m = test::reference_machine();
  EXPECT_EQ(config::quick_stop_of(m, m.axes[kY.value]), config::QuickStop::Brakes);
  for (config::Station& s : m.stations)
    if (s.name == "y2")
      for (config::StartupRow& row : s.profile.startup)
        if (row.address == kQuickRamp) row.value = 1'999'000;  // 1999 mm/s^2 of a_max 4000
  EXPECT_EQ(config::quick_stop_of(m, m.axes[kY.value]), config::QuickStop::Weak);
}

}  // namespace
}  // namespace gantry
