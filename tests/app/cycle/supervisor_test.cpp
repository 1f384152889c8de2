// What each cycle shows and what is named of it: when, and for how long. Expected numbers come from docs/threats.md
// (R02, R04, R10, R11, R33, R36, R53), not from the code.
#include "app/cycle/supervisor.hpp"

#include <algorithm>
#include <array>
#include <deque>
#include <gtest/gtest.h>
#include <random>
#include <vector>

#include "devices/wire/bytes.hpp"
#include "tests/app/cycle/still_bus.hpp"

namespace gantry::cycle {
namespace {

constexpr std::uint16_t kNoTorque = 0x0240, kTorque = 0x0237;  // CiA 402-2: switch-on disabled, operation enabled

/// One station whose inputs the test writes: 6041h, 6061h, 6064h, 603Fh, 60FDh.
class HandMadeBus final : public test::StillBus {
 public:
  std::array<std::byte, 13> in{};
  std::array<std::byte, 16> out{};
  bool takes_part = true;

  void show(std::uint16_t status, std::int32_t position, std::uint16_t error = 0, std::uint32_t switches = 0) {
    devices::wire::put_le<std::uint16_t>(in, 0, status);
    in[2] = std::byte{8};
    devices::wire::put_le<std::int32_t>(in, 3, position);
    devices::wire::put_le<std::uint16_t>(in, 7, error);
    devices::wire::put_le<std::uint32_t>(in, 9, switches);
  }
  [[nodiscard]] std::span<std::byte> outputs(StationId) noexcept override { return out; }
  [[nodiscard]] std::span<const std::byte> inputs(StationId) const noexcept override { return in; }
  [[nodiscard]] bool fresh(StationId) const noexcept override { return takes_part; }
};

/// A machine of one axis, 1000 counts a mm, window 0.5 mm + 10 ms of travel; what the supervisor says of each cycle.
struct Watched {
  static LoopSetup one_axis() {
    LoopSetup s;
    DriveSetup drive;
    drive.station = StationId{0}, drive.axis = AxisId{0};
    drive.layout.controlword = {0}, drive.layout.mode = {2}, drive.layout.target = {4};
    drive.layout.statusword = {0}, drive.layout.mode_display = {2}, drive.layout.position = {3};
    drive.layout.error_code = {7}, drive.layout.digital_inputs = {9};
    drive.layout.neg_limit_bit = 0, drive.layout.pos_limit_bit = 1;
    drive.layout.closed_loop = true;
    drive.scale = devices::AxisScale(1000, false);
    drive.brake_give = 0.5;
    s.drives.push_back(drive);
    AxisSetup axis;
    axis.drives.push_back(0);
    axis.following_base = 0.5, axis.following_per_speed_s = 0.01;
    s.axes.push_back(axis);
    s.limits.axes = 1;
    s.limits.axis[0] = {-1000, 1000, 500, 4000, 40'000};
    return s;
  }

  static devices::Exchange good() {
    devices::Exchange x;
    x.inputs_fresh = x.complete = x.operational = true;
    return x;
  }

  LoopSetup setup;
  HandMadeBus bus;
  Axes axes{setup};
  Supervisor supervisor{setup};
  devices::Exchange x = good();
  State state = State::Ready;
  Purpose purpose = Purpose::Job;
  std::uint32_t inputs = 0;
  double target = 0;
  Time compute{}, late{};
  CycleIndex cycle = 0;
  std::vector<Finding> found;

  explicit Watched(LoopSetup made = one_axis()) : setup(std::move(made)) {
    bus.show(kNoTorque, 0);
    look();
    found.clear();
  }
  /// One cycle, or one after so many.
  void look(std::int64_t elapsed = 1) {
    cycle += elapsed;
    const bool answered = x.fault != Fault::FrameLost && x.fault != Fault::BusDown;
    bus.takes_part = answered;
    axes.read(bus, answered, true, elapsed);
    AxisVec to{};
    to[0] = target;
    axes.write(bus, to, elapsed);
    const Beat beat{cycle, elapsed, setup.period * cycle, setup.period * cycle + late};
    found.clear();
    for (const Finding& f : supervisor.look({beat, x, axes, to, inputs, state, compute, purpose})) found.push_back(f);
  }
  [[nodiscard]] bool says(Fault fault) const {
    return std::any_of(found.begin(), found.end(), [&](const Finding& f) { return f.fault == fault; });
  }
  /// What it says of it in this cycle.
  [[nodiscard]] Finding of(Fault fault) const {
    const auto at = std::find_if(found.begin(), found.end(), [&](const Finding& f) { return f.fault == fault; });
    return at != found.end() ? *at : Finding{};
  }
  /// In which of so many cycles it says so, from 1.
  std::vector<int> cycles_that_say(Fault fault, int cycles) {
    std::vector<int> out;
    for (int i = 1; i <= cycles; ++i) {
      look();
      if (says(fault)) out.push_back(i);
    }
    return out;
  }
  /// Torque, standing at the target.
  void have_torque() {
    axes.set_goal(devices::DriveGoal::Enabled);
    bus.show(kTorque, 0);
    for (int i = 0; i < 5; ++i) look();
  }
};

using Cycles = std::vector<int>;

TEST(Supervisor, a_quiet_cycle_says_nothing) {
  Watched w;
  w.have_torque();
  for (int i = 0; i < 1000; ++i) {
    w.look();
    ASSERT_TRUE(w.found.empty()) << info(w.found.front().fault).name << " in cycle " << i;
  }
}

TEST(Supervisor, the_first_lost_frame_is_a_note_and_so_many_in_a_row_stop_until_one_comes) {
  for (const int most : {1, 3, 5}) {
    Watched w;
    w.setup.frames_lost_max = most;
    w.x.fault = Fault::FrameLost, w.x.inputs_fresh = false;
    Cycles stops;
    for (int i = most; i <= 10; ++i) stops.push_back(i);
    EXPECT_EQ(w.cycles_that_say(Fault::FramesLost, 10), stops) << "and for as long as it lasts";
    w.x.fault = Fault::None, w.x.inputs_fresh = true;
    w.look();
    EXPECT_FALSE(w.says(Fault::FramesLost));
    w.x.fault = Fault::FrameLost;
    w.look();
    EXPECT_EQ(w.says(Fault::FramesLost), most == 1) << "it counts anew";
    EXPECT_EQ(w.says(Fault::FrameLost), most > 1);
  }
}

TEST(Supervisor, a_station_that_does_not_take_part_is_told_once_and_stops_at_the_bound) {
  Watched w;
  w.setup.counter_low_max = 3;
  w.x.fault = Fault::TooFewTookPart, w.x.detail = 4;
  w.look();
  EXPECT_TRUE(w.says(Fault::TooFewTookPart));
  EXPECT_FALSE(w.says(Fault::StationSilent));
  EXPECT_EQ(w.cycles_that_say(Fault::StationSilent, 5), (Cycles{2, 3, 4, 5}));
  EXPECT_EQ(w.found.front().detail, 4);
}

// R05: more stations answered than the bus has.
TEST(Supervisor, a_station_too_many_stops_at_once_and_with_the_working_counter) {
  Watched w;
  w.look();
  w.x.fault = Fault::TooManyTookPart, w.x.detail = 13;
  EXPECT_EQ(w.cycles_that_say(Fault::TooManyTookPart, 3), (Cycles{1, 2, 3})) << "for as long as it lasts";
  EXPECT_EQ(w.of(Fault::TooManyTookPart).detail, 13);
  w.x = Watched::good();
  EXPECT_TRUE(w.cycles_that_say(Fault::TooManyTookPart, 3).empty());
}

TEST(Supervisor, nothing_is_said_of_stations_before_all_were_in_op_once) {
  Watched w;
  Supervisor fresh(w.setup);
  AxisVec at{};
  devices::Exchange x;
  x.fault = Fault::TooFewTookPart;
  for (CycleIndex c = 1; c < 50; ++c)
    EXPECT_TRUE(fresh.look({Beat{c, 1, {}, {}}, x, w.axes, at, 0, State::Offline, {}, Purpose::Job}).empty());
}

TEST(Supervisor, a_station_that_leaves_op_is_told_in_that_cycle) {
  Watched w;
  w.x.operational = false;
  w.look();
  EXPECT_TRUE(w.says(Fault::StationLeftOp));
}

/// R11: a note each, and three in 100 ms stop.
TEST(Supervisor, late_cycles_are_notes_and_three_in_a_tenth_of_a_second_stop) {
  Watched w;
  w.late = microseconds(390);
  w.look();
  EXPECT_FALSE(w.says(Fault::LateCycle)) << "two fifths of a cycle are left before SYNC0";
  w.late = microseconds(450);
  EXPECT_EQ(w.cycles_that_say(Fault::LateCycles, 3), (Cycles{3}));
  EXPECT_EQ(w.of(Fault::LateCycle).detail, 450) << "us";
}

/// Whatever the machine's period, and wherever the 100 ms begin. The judge keeps the instants of the late cycles.
TEST(Supervisor, late_cycles_are_counted_over_a_tenth_of_a_second_of_any_period) {
  constexpr unsigned kSeed = 11;
  std::mt19937 random(kSeed);
  for (const Time period : {microseconds(250), microseconds(1000), microseconds(4000), microseconds(10'000)}) {
    LoopSetup setup = Watched::one_axis();
    setup.period = period;
    setup.late_window = cycles_in(seconds(kLateWindow), period);
    Watched w(setup);
    std::bernoulli_distribution is_late(2.0 / static_cast<double>(setup.late_window));
    std::deque<std::int64_t> late;
    int stops = 0;
    for (std::int64_t cycle = 0; cycle < 40 * setup.late_window; ++cycle) {
      w.late = is_late(random) ? period / 2 : Time{};
      if (w.late != Time{}) late.push_back(cycle);
      while (!late.empty() && (cycle - late.front()) * period >= kLateWindow) late.pop_front();
      w.look();
      const bool too_many = late.size() >= 3;
      EXPECT_EQ(w.says(Fault::LateCycles), too_many) << "period " << period.count() << " ns, cycle " << cycle;
      stops += too_many ? 1 : 0;
      for (const Finding& f : w.found) {
        const bool right = f.fault != Fault::LateCycles || f.detail == static_cast<int>(late.size());
        EXPECT_TRUE(right) << f.detail << " of " << late.size();
      }
    }
    EXPECT_GT(stops, 0);
  }
}

TEST(Supervisor, a_stall_longer_than_allowed_stops_at_once_with_its_length) {
  for (const int missed : {1, 3, 4, 50}) {
    Watched w;
    w.setup.stop_after_missed = 3;
    w.look(missed + 1);
    EXPECT_EQ(w.says(Fault::ControllerStalled), missed > 3) << missed;
    EXPECT_TRUE(w.says(Fault::LateCycle));
    if (missed > 3) {
      EXPECT_EQ(w.found.back().detail, missed);
    }
  }
}

TEST(Supervisor, own_work_longer_than_a_cycle_is_an_overrun) {
  Watched w;
  w.compute = microseconds(1000);
  w.look();
  EXPECT_FALSE(w.says(Fault::CycleOverrun));
  w.compute = microseconds(1250);
  w.look();
  EXPECT_EQ(w.of(Fault::CycleOverrun).detail, 250) << "us over the cycle";
}

TEST(Supervisor, a_clock_that_is_off_for_ten_cycles_is_told_once_and_at_the_second_bound_as_long_as_it_lasts) {
  Watched w;
  w.x.clock_seen = true, w.x.clock_station = StationId{2};
  w.x.clock_ns = w.setup.clock_note_ns + 1;
  EXPECT_EQ(w.cycles_that_say(Fault::DcNotLocked, 40), (Cycles{11})) << "beyond it since ten cycles";
  w.x.clock_ns = -w.setup.clock_stop_ns - 1;
  const Cycles stops = w.cycles_that_say(Fault::DcLost, 20);
  EXPECT_EQ(stops.front(), 11);
  EXPECT_EQ(stops.size(), 10u);
  EXPECT_EQ(w.found.front().station, StationId{2});
  w.x.clock_ns = 0;
  EXPECT_TRUE(w.cycles_that_say(Fault::DcLost, 50).empty());
}

TEST(Supervisor, an_axis_outside_its_window_stops_in_the_third_cycle_and_the_window_grows_with_speed) {
  Watched w;
  w.have_torque();
  w.bus.show(kTorque, 501);
  EXPECT_EQ(w.cycles_that_say(Fault::FollowingError, 4), (Cycles{3, 4})) << "0.501 mm at rest, window 0.5";
  EXPECT_EQ(w.of(Fault::FollowingError).detail, -501) << "um; it stands beyond its target";
  for (const double lag : {2.4, 2.6}) {  // 0.5 + 10 ms * 200 mm/s = 2.5 mm
    Watched moving;
    moving.have_torque();
    moving.state = State::Running;
    bool stops = false;
    for (int i = 1; i <= 100; ++i) {
      moving.target = 0.2 * i;
      moving.bus.show(kTorque, static_cast<std::int32_t>(1000 * std::max(0.0, moving.target - lag)));
      moving.look();
      stops = stops || moving.says(Fault::FollowingError);
    }
    EXPECT_EQ(stops, lag > 2.5) << lag;
  }
}

/// An open-loop drive whose response_delay is 2 ms: 6064h is the command that it carries out, later by its filter.
LoopSetup open_loop() {
  LoopSetup s = Watched::one_axis();
  s.drives[0].layout.closed_loop = false;
  s.drives[0].layout.follows_bit = 12;  // STD402EC 11.1
  s.axes[0].response_delay_s = 0.002;
  s.axes[0].following_base = s.axes[0].following_per_speed_s = 0;
  return s;
}
constexpr std::uint16_t kFollows = 0x1237;  // STD402EC 11.1: enabled in CSP

TEST(Supervisor, an_open_loop_axis_that_stops_short_is_named_with_both_values) {
  Watched w(open_loop());
  w.have_torque();
  w.state = State::Running;
  int since = 0;
  for (int i = 1; i <= 400 && !w.says(Fault::NotFollowing); ++i) {
    w.target = 0.1 * i;
    if (w.target > 20) ++since;
    w.bus.show(kFollows, static_cast<std::int32_t>(1000 * std::min(w.target, 20.0)));
    w.look();
  }
  ASSERT_TRUE(w.says(Fault::NotFollowing));
  EXPECT_LE(since, 20) << "R45";
  const Finding f = w.found.front();
  EXPECT_EQ(f.axis, AxisId{0});
  EXPECT_DOUBLE_EQ(f.value, w.target);
  EXPECT_NEAR(f.value - f.detail / 1000.0, 20, 2.1)
      << "what it is off is at least from the nearest that it could be at";
}

TEST(Supervisor, an_open_loop_axis_that_comes_late_or_missed_frames_follows) {
  Watched w(open_loop());
  w.have_torque();
  w.state = State::Running;
  std::vector<double> sent(40, 0.0);
  const auto ago = [&](int cycles) {
    return static_cast<std::int32_t>(1000 * sent[sent.size() - 1 - static_cast<std::size_t>(cycles)]);
  };
  for (int i = 1; i <= 2000; ++i) {
    // To and fro at 200 mm/s; three delays of 2 ms late; now and then a host that sleeps 40 ms, or a frame that is
    // lost.
    const int stall = i % 97 == 0 ? 40 : 1;
    w.target = 20 * std::sin(0.01 * (static_cast<double>(w.cycle) + stall));
    for (int k = 0; k < stall; ++k) sent.push_back(k + 1 < stall ? sent.back() : w.target);
    w.x.fault = i % 31 < 2 ? Fault::FrameLost : Fault::None;
    w.bus.show(kFollows, ago(i % 13 == 0 ? 9 : 6));
    w.look(stall);
    ASSERT_FALSE(w.says(Fault::NotFollowing)) << i;
  }
}

TEST(Supervisor, a_drive_that_says_it_does_not_follow_for_a_tenth_of_a_second_is_named) {
  Watched w(open_loop());
  w.have_torque();
  w.bus.show(kFollows, 0);
  EXPECT_TRUE(w.cycles_that_say(Fault::NotFollowing, 300).empty());
  w.bus.show(kTorque, 0);
  EXPECT_TRUE(w.cycles_that_say(Fault::NotFollowing, 99).empty());
  w.bus.show(kFollows, 0);
  w.look();
  w.bus.show(kTorque, 0);
  const Cycles said = w.cycles_that_say(Fault::NotFollowing, 110);
  ASSERT_FALSE(said.empty());
  EXPECT_EQ(said.front(), 101);
  EXPECT_EQ(w.found.front().station, StationId{0});
  w.state = State::Homing;
  EXPECT_TRUE(w.cycles_that_say(Fault::NotFollowing, 300).empty()) << "in homing the drive moves by itself";

  LoopSetup silent = open_loop();
  silent.drives[0].layout.follows_bit = -1;  // AMD530B: not stated
  Watched other(silent);
  other.have_torque();
  EXPECT_TRUE(other.cycles_that_say(Fault::NotFollowing, 300).empty());
}

TEST(Supervisor, a_limit_that_the_statusword_alone_shows_stops_a_motion) {
  LoopSetup setup = open_loop();
  setup.drives[0].layout.limit_bit = 11;
  for (const State state : {State::Running, State::Holding, State::Held, State::Ready}) {
    Watched w(setup);
    w.have_torque();
    w.state = state;
    w.bus.show(kFollows | 0x0800, 0);
    w.look();
    EXPECT_EQ(w.says(Fault::LimitSwitch), state == State::Running || state == State::Holding) << name(state);
  }
}

/// On its way to a hold an axis moves for as long as a feature lasts. AMD530B and STD402EC have no code of 603Fh for
/// it.
TEST(Supervisor, a_limit_switch_stops_what_is_on_its_way_to_a_hold) {
  Watched w;
  w.have_torque();
  w.state = State::Holding;
  w.look();
  EXPECT_FALSE(w.says(Fault::LimitSwitch));
  w.bus.show(kTorque, 0, 0, 0b10);
  w.look();
  EXPECT_TRUE(w.says(Fault::LimitSwitch));
}

/// R43, of a drive on its switch: in whatever plays it is told, at rest it may be led off.
TEST(Supervisor, a_drive_on_its_switch_that_does_not_follow_is_named_while_a_block_plays) {
  for (const State state : {State::Running, State::Holding, State::Held, State::Ready}) {
    Watched w(open_loop());
    w.have_torque();
    w.state = state;
    w.bus.show(kTorque, 0, 0, 0b10);  // 6041h bit 12 is 0
    const bool plays = state == State::Running || state == State::Holding;
    EXPECT_EQ(w.cycles_that_say(Fault::NotFollowing, 110).empty(), !plays) << name(state);
  }
}

/// IEC 61800-7-201: in Fault Reaction Active the drive may still brake under torque.
TEST(Supervisor, a_drive_in_its_fault_reaction_is_not_without_torque) {
  Watched w;
  EXPECT_TRUE(w.axes.all_disabled());
  w.have_torque();
  EXPECT_FALSE(w.axes.all_disabled());
  for (const auto& [status, disabled] : {std::pair{0x021F, false}, {0x0217, false}, {0x0218, true}, {0x0240, true}}) {
    w.bus.show(static_cast<std::uint16_t>(status), 0);
    w.look();
    EXPECT_EQ(w.axes.all_disabled(), disabled) << std::hex << status;
  }
}

TEST(Supervisor, homing_has_no_window) {
  Watched w;
  w.have_torque();
  w.state = State::Homing;
  w.bus.show(kTorque, 499);
  w.bus.show(kTorque, 900);
  EXPECT_TRUE(w.cycles_that_say(Fault::FollowingError, 20).empty());
}

TEST(Supervisor, a_limit_switch_stops_a_motion_and_is_told_when_torque_comes) {
  Watched w;
  w.bus.show(kNoTorque, 0, 0, 0b01);
  w.look();
  EXPECT_FALSE(w.says(Fault::LimitSwitchStuck));
  w.axes.set_goal(devices::DriveGoal::Enabled);
  w.bus.show(kTorque, 0, 0, 0b01);
  EXPECT_EQ(w.cycles_that_say(Fault::LimitSwitchStuck, 10), (Cycles{1}));
  EXPECT_FALSE(w.says(Fault::LimitSwitch)) << "it may be led off";
  w.state = State::Running;
  w.look();
  EXPECT_TRUE(w.says(Fault::LimitSwitch));
}

TEST(Supervisor, a_brake_that_gives_half_a_millimetre_is_told_and_again_when_it_goes_on) {
  Watched w;
  w.state = State::Disabled;
  for (int i = 0; i < 600; ++i) w.look();  // closed by then
  w.bus.show(kNoTorque, -499);
  EXPECT_TRUE(w.cycles_that_say(Fault::BrakeDrift, 20).empty());
  w.bus.show(kNoTorque, -501);
  EXPECT_EQ(w.cycles_that_say(Fault::BrakeDrift, 1), (Cycles{1}));
  EXPECT_EQ(w.of(Fault::BrakeDrift).detail, -501) << "um, down";
  EXPECT_TRUE(w.cycles_that_say(Fault::BrakeDrift, 20).empty());
  w.bus.show(kNoTorque, -1002);
  EXPECT_EQ(w.cycles_that_say(Fault::BrakeDrift, 20), (Cycles{1}));
}

/// Half a second for the brake and a tenth of a second for a clock, whatever the machine's cycle.
TEST(Supervisor, durations_are_those_of_the_clock_in_a_machine_of_two_milliseconds) {
  LoopSetup slow = Watched::one_axis();
  slow.period = milliseconds(2);
  Watched w(slow);
  w.state = State::Disabled;
  for (int i = 0; i < 230; ++i) w.look();
  w.bus.show(kNoTorque, -501);
  EXPECT_TRUE(w.cycles_that_say(Fault::BrakeDrift, 10).empty()) << "480 ms: it may still sink into its brake";
  for (int i = 0; i < 15; ++i) w.look();
  w.bus.show(kNoTorque, -1002);
  EXPECT_EQ(w.cycles_that_say(Fault::BrakeDrift, 20), (Cycles{1})) << "closed after 510 ms";

  Watched clocks(slow);
  clocks.x.clock_seen = true, clocks.x.clock_station = StationId{0};
  clocks.x.clock_ns = 20'000;
  EXPECT_EQ(clocks.cycles_that_say(Fault::DcNotLocked, 20).size(), 1u);
  clocks.x.clock_ns = 0;
  for (int i = 0; i < 60; ++i) clocks.look();  // 120 ms
  clocks.x.clock_ns = 20'000;
  EXPECT_EQ(clocks.cycles_that_say(Fault::DcNotLocked, 20).size(), 1u) << "it was over, and is news";
}

TEST(Supervisor, a_fault_of_a_drive_lasts_and_a_warning_is_told_once) {
  LoopSetup setup = Watched::one_axis();
  setup.drives[0].layout.codes.push_back({0x000A, Fault::DriveFault, false});
  Watched w(setup);
  w.bus.show(0x0208, 0, 0x000A);  // CiA 402-2: fault
  EXPECT_EQ(w.cycles_that_say(Fault::DriveFault, 5).size(), 5u);
  EXPECT_EQ(w.found.front().detail, 0x000A);
  EXPECT_EQ(w.found.front().axis, AxisId{0});
}

/// 603Fh may keep the code of a fault that is over: what is wrong with the statusword is told by the statusword.
TEST(Supervisor, a_drive_that_goes_wrong_is_told_by_its_statusword_and_one_with_a_fault_by_its_code) {
  Watched w;
  w.have_torque();
  w.bus.show(0x0237, 0, 0x8611);
  w.look();
  w.bus.show(0x0250, 0, 0x8611);
  w.look();
  w.bus.show(0x0237, 0, 0x8611);  // from Switch On Disabled at once
  w.look();
  ASSERT_TRUE(w.says(Fault::ImpossibleStatus));
  EXPECT_EQ(w.found.front().detail, 0x0237);
  LoopSetup setup = Watched::one_axis();
  setup.drives[0].layout.codes.push_back({0x0400, Fault::LimitSwitch, true});
  Watched by_bit(setup);
  by_bit.bus.show(0x0208, 0, 0);
  by_bit.look();
  ASSERT_TRUE(by_bit.says(Fault::DriveFaultNoCode));
  EXPECT_EQ(by_bit.found.front().detail, 0) << "no code is none";
}

/// Which open contact is named where, row by row: state, mode, what plays.
TEST(Supervisor, an_open_contact_is_named_by_the_state_and_by_what_plays) {
  Watched w;
  w.setup.safety_mask = 1, w.setup.stop_mask = 2, w.setup.door_mask = 4, w.setup.air_mask = 8, w.setup.clamp_mask = 16,
  w.setup.mode_mask = 32;
  constexpr std::uint32_t kAll = 63;
  const struct {
    std::uint32_t open;
    State state;
    Purpose purpose;
    std::vector<Fault> says;
  } kRows[] = {
      {0, State::Running, Purpose::Job, {}},
      {1, State::Ready, Purpose::Job, {Fault::SafetyChainOpen}},
      {1, State::Disabled, Purpose::Job, {}},
      {2, State::Ready, Purpose::Job, {Fault::StopPressed}},
      {4, State::Ready, Purpose::Job, {Fault::DoorOpen}},
      {4, State::Disabled, Purpose::Job, {}},
      {4 | 32, State::Running, Purpose::SlowJog, {}},
      {4 | 32, State::Running, Purpose::Jog, {Fault::ModeChanged}},
      {4, State::Running, Purpose::Jog, {Fault::DoorOpen}},
      {4, State::Running, Purpose::SlowJog, {Fault::DoorOpen}},
      {8, State::Homing, Purpose::Job, {Fault::AirMissing}},
      {16, State::Running, Purpose::Job, {Fault::ClampOpen}},
      {16, State::Held, Purpose::Job, {Fault::ClampOpen}},
      {16, State::Running, Purpose::Jog, {}},
      {16, State::Running, Purpose::Park, {}},
      {16, State::Ready, Purpose::Job, {}},
      {32, State::Running, Purpose::Job, {Fault::ModeChanged}},
      {32, State::Running, Purpose::Park, {Fault::ModeChanged}},
      {32, State::Holding, Purpose::Job, {Fault::ModeChanged}},
      {32, State::Homing, Purpose::Job, {Fault::ModeChanged}},
      {32, State::Running, Purpose::Jog, {Fault::ModeChanged}},
      {32, State::Held, Purpose::Jog, {Fault::ModeChanged}},
      {32, State::Held, Purpose::SlowJog, {}},
      {32, State::Running, Purpose::Walk, {}},
      {0, State::Running, Purpose::SlowJog, {}},
      {0, State::Running, Purpose::Walk, {Fault::ModeChanged}},
      {1 | 2 | 4 | 8,
       State::Ready,
       Purpose::Job,
       {Fault::SafetyChainOpen, Fault::StopPressed, Fault::DoorOpen, Fault::AirMissing}},
  };
  for (const auto& row : kRows) {
    w.inputs = kAll & ~row.open, w.state = row.state, w.purpose = row.purpose;
    w.look();
    std::vector<Fault> said;
    for (const Finding& f : w.found) said.push_back(f.fault);
    EXPECT_EQ(said, row.says) << "open " << row.open << " in " << name(row.state);
  }
}

}  // namespace
}  // namespace gantry::cycle
