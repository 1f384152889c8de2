#include "devices/rt/homing.hpp"

#include <gtest/gtest.h>

#include "tests/devices/rt/drive_bench.hpp"

namespace gantry::devices {
namespace {

/// A drive in homing mode after AMD530B 6.2: 8737 enabled, 0237 moving, 1637 done, 2637 error. It takes ten cycles to
/// change its mode, moves 50 counts a cycle towards a switch, and sets its counter to 0 there.
struct HomingDrive {
  DriveBench bench{2000};
  HomingRun run;
  std::int32_t counts = 100'000, travelled = 0;
  std::int32_t switch_after = 5000;
  std::int8_t mode = 8;
  int mode_wait = 0;
  bool fails = false, stale_done = false, stale_error = false, faulted = false;
  bool homed = false, started = false;

  HomingDrive() {
    bench.position(counts);
    bench.enable();
  }
  std::uint16_t status() const {
    if (faulted) return 0x0238;
    if (mode != 6) return 0x1237;
    if (stale_done && !started) return 0x1637;
    if (stale_error && !started) return 0x2637;
    if (homed) return 0x1637;
    if (fails && travelled >= switch_after) return 0x2637;
    return started ? 0x0237 : 0x8737;
  }
  /// `answered` false: no frame comes back, and what is known of the drive is of the past.
  void cycle(bool answered = true, bool may_search = true) {
    const std::int8_t wanted = bench.layout.mode.get(bench.outputs);
    if (wanted != mode && ++mode_wait > 10) mode = wanted, mode_wait = 0;
    const bool start = mode == 6 && (bench.controlword() & 0x10) != 0;
    if (start && !started) homed = false;
    started = start;
    if (started && !homed && travelled < switch_after)
      counts = static_cast<std::int32_t>(static_cast<std::uint32_t>(counts) - 50), travelled += 50;
    if (started && !fails && travelled >= switch_after && !homed) homed = true, counts = 0;
    if (!start && homed && mode != 6) homed = false;
    bench.mode(mode);
    bench.status(status());
    bench.position(counts);
    const Feedback f = bench.drive.read(bench.inputs, answered);
    bench.drive.write(bench.outputs, run.busy()
                                         ? run.step(f, 1, may_search)
                                         : DriveCommand{.goal = DriveGoal::Enabled, .target = bench.drive.commanded()});
  }
  int until_done(int at_most = 20'000) {
    int n = 0;
    while (run.busy() && n < at_most) cycle(), ++n;
    return n;
  }
};

TEST(Homing, finds_the_switch_and_comes_back_to_csp_without_a_step) {
  HomingDrive h;
  h.run.start({.timeout_cycles = 10'000, .travel_counts = 20'000}, h.bench.drive.feedback());
  h.until_done();
  ASSERT_EQ(h.run.phase(), HomingRun::Phase::Done) << code(h.run.fault()).text;
  EXPECT_EQ(h.mode, 8);
  EXPECT_TRUE(h.bench.drive.feedback().takes_targets);
  EXPECT_EQ(h.bench.target(), h.counts);
  h.bench.drive.set_reference(Counts{0}, 5.0);
  EXPECT_DOUBLE_EQ(h.bench.drive.commanded(), 5.0);
  h.cycle();
  EXPECT_EQ(h.bench.target(), h.counts);
  EXPECT_DOUBLE_EQ(h.bench.drive.feedback().position, 5.0);
}

/// A drive that counts on without its supply may begin anywhere, and its counter may wrap before it comes to its edge.
TEST(Homing, a_counter_that_wraps_on_the_way_to_the_edge_does_not_matter) {
  for (const std::int32_t begin : {INT32_MIN + 1000, INT32_MIN + 5000, INT32_MIN + 5040, INT32_MAX, 0}) {
    SCOPED_TRACE(begin);
    HomingDrive h;
    h.counts = begin;
    h.bench.position(begin);
    h.bench.drive.lose();
    for (int i = 0; i < 20; ++i) h.cycle();
    h.bench.enable();
    h.run.start({.timeout_cycles = 10'000, .travel_counts = 20'000, .near_counts = 100}, h.bench.drive.feedback());
    h.until_done();
    ASSERT_EQ(h.run.phase(), HomingRun::Phase::Done) << code(h.run.fault()).text;
    h.bench.drive.set_reference(Counts{0}, 5.0);
    EXPECT_DOUBLE_EQ(h.bench.drive.commanded(), 5.0);
  }
}

TEST(Homing, the_result_of_an_earlier_homing_does_not_count) {
  for (const bool error : {false, true}) {
    HomingDrive h;
    (error ? h.stale_error : h.stale_done) = true;
    h.run.start({.timeout_cycles = 10'000, .travel_counts = 20'000}, h.bench.drive.feedback());
    h.until_done();
    EXPECT_EQ(h.run.phase(), HomingRun::Phase::Done) << code(h.run.fault()).text;
    EXPECT_GE(h.travelled, h.switch_after);
  }
}

/// Two drives carry one beam; the second one shows "done" of an earlier homing until it is started.
TEST(Homing, a_side_waits_until_the_other_one_may_search_too) {
  HomingDrive prompt, late;
  late.stale_done = true;
  for (HomingDrive* h : {&prompt, &late})
    h->run.start({.timeout_cycles = 10'000, .travel_counts = 20'000}, h->bench.drive.feedback());
  int apart = 0;
  for (int n = 0; n < 20'000 && (prompt.run.busy() || late.run.busy()); ++n) {
    const bool both = prompt.run.ready() && late.run.ready();
    prompt.cycle(true, both);
    late.cycle(true, both);
    apart = std::max(apart, std::abs(prompt.travelled - late.travelled));
  }
  EXPECT_EQ(prompt.run.phase(), HomingRun::Phase::Done) << code(prompt.run.fault()).text;
  EXPECT_EQ(late.run.phase(), HomingRun::Phase::Done) << code(late.run.fault()).text;
  EXPECT_EQ(apart, 0);
}

TEST(Homing, a_side_whose_other_one_never_gets_ready_does_not_move) {
  HomingDrive h;
  h.run.start({.timeout_cycles = 10'000, .travel_counts = 20'000}, h.bench.drive.feedback());
  for (int n = 0; n < 20'000 && h.run.busy(); ++n) h.cycle(true, false);
  EXPECT_EQ(h.run.fault(), Fault::WrongMode);
  EXPECT_EQ(h.travelled, 0);
}

TEST(Homing, the_drives_error_bit_ends_it) {
  HomingDrive h;
  h.fails = true;
  h.run.start({.timeout_cycles = 10'000, .travel_counts = 20'000}, h.bench.drive.feedback());
  h.until_done();
  EXPECT_EQ(h.run.phase(), HomingRun::Phase::Failed);
  EXPECT_EQ(h.run.fault(), Fault::HomingFailed);
  EXPECT_EQ(h.mode, 8);
}

TEST(Homing, travel_and_time_are_bounded) {
  HomingDrive far;
  far.switch_after = 1'000'000;
  far.run.start({.timeout_cycles = 100'000, .travel_counts = 20'000}, far.bench.drive.feedback());
  far.until_done();
  EXPECT_EQ(far.run.fault(), Fault::HomingTimeout);
  EXPECT_NEAR(far.travelled, 20'000, 200);

  HomingDrive slow;
  slow.switch_after = 1'000'000;
  slow.run.start({.timeout_cycles = 300, .travel_counts = 0}, slow.bench.drive.feedback());
  const int cycles = slow.until_done();
  EXPECT_EQ(slow.run.fault(), Fault::HomingTimeout);
  EXPECT_LT(cycles, 400);
}

TEST(Homing, a_drive_fault_ends_it_with_the_drives_own_fault) {
  HomingDrive h;
  h.run.start({.timeout_cycles = 10'000, .travel_counts = 20'000}, h.bench.drive.feedback());
  for (int i = 0; i < 40; ++i) h.cycle();
  h.faulted = true;
  h.bench.layout.error_code.set(h.bench.inputs, 0x3210);
  h.until_done();
  EXPECT_EQ(h.run.fault(), Fault::DriveFault);
  EXPECT_EQ(h.bench.controlword() & 0x0F, 0);
}

TEST(Homing, can_be_cancelled_and_leaves_the_axis_standing_in_csp) {
  HomingDrive h;
  h.run.start({.timeout_cycles = 10'000, .travel_counts = 20'000}, h.bench.drive.feedback());
  for (int i = 0; i < 40; ++i) h.cycle();
  h.run.cancel(Fault::Aborted);
  h.until_done();
  EXPECT_EQ(h.run.fault(), Fault::Aborted);
  EXPECT_EQ(h.mode, 8);
}

TEST(Homing, a_drive_that_is_not_heard_of_is_not_taken_to_stand) {
  HomingDrive h;
  h.run.start({.timeout_cycles = 10'000, .travel_counts = 20'000}, h.bench.drive.feedback());
  for (int i = 0; i < 40; ++i) h.cycle();
  h.run.cancel(Fault::Aborted);
  for (int i = 0; i < 60; ++i) h.cycle(false);
  EXPECT_EQ(h.run.phase(), HomingRun::Phase::Settle);
  h.until_done();
  EXPECT_EQ(h.run.fault(), Fault::Aborted);
}

TEST(Homing, that_is_cancelled_in_every_cycle_ends_as_soon_as_one_that_is_cancelled_once) {
  for (const bool heard : {true, false}) {
    HomingDrive h;
    h.run.start({.timeout_cycles = 10'000, .travel_counts = 20'000}, h.bench.drive.feedback());
    for (int i = 0; i < 50; ++i) h.cycle();
    ASSERT_EQ(h.run.phase(), HomingRun::Phase::Search);
    int cycles = 0;
    for (; h.run.busy() && cycles < 5000; ++cycles) {
      h.run.cancel(Fault::FramesLost);
      h.cycle(heard);
    }
    EXPECT_EQ(h.run.phase(), HomingRun::Phase::Failed);
    EXPECT_EQ(h.run.fault(), Fault::FramesLost);
    EXPECT_LE(cycles, 120) << (heard ? "a drive that answers" : "a drive that is silent");
  }
}

TEST(Homing, that_goes_on_unheard_is_given_up_when_it_is_cancelled_alone) {
  HomingDrive h;
  h.run.start({.timeout_cycles = 10'000, .travel_counts = 20'000}, h.bench.drive.feedback());
  for (int i = 0; i < 50; ++i) h.cycle();
  for (int i = 0; i < 150; ++i) h.cycle(false);
  EXPECT_TRUE(h.run.busy()) << "nobody has cancelled it: the bus says when frames are missing for too long";
  h.run.cancel(Fault::Aborted);
  h.cycle(false);
  EXPECT_FALSE(h.run.busy());
}

/// Method 17 after IEC 61800-7-201, 10.4, of a drive that takes its targets at once. Its limit is closed at and below
/// `edge`, seen from the position it started at; standing at the edge it is done before a frame has shown the switch.
struct LimitDrive {
  DriveBench bench{2000};
  HomingRun run;
  std::int32_t place, edge, zero = 0;
  bool sees_switch = true, started = false, homed = false, coming_back = false;
  int led = 0;
  std::int32_t off = 0;             ///< that it counts at its edge
  int shows_late = 0;               ///< cycles by which 60FDh is behind
  std::uint32_t levels = 0;         ///< of the last 32 cycles, the newest in bit 0
  int flickers_at = 0, cycles = 0;  ///< a contact that bounces, far from the edge

  LimitDrive(std::int32_t from, std::int32_t at) : place(from), edge(at) {
    bench.position(place);
    bench.enable();
    HomingRules rules = homing_rules(17);
    rules.known = kSwitchNeg | kSwitchPos, rules.counts_per_cycle = 60;
    run.start(
        {.timeout_cycles = 10'000, .travel_counts = 50'000, .rules = rules, .near_counts = 2000, .edge_counts = 370},
        bench.drive.feedback());
  }
  void cycle() {
    const std::int8_t mode = bench.layout.mode.get(bench.outputs);
    const bool start = mode == 6 && (bench.controlword() & 0x10) != 0;
    if (start && !started) homed = false, coming_back = place <= edge + 5;
    started = start;
    if (mode == 8) place = bench.target() + zero;
    if (started && !homed) {
      if (!coming_back) place -= 60, coming_back = place < edge - 600;
      if (coming_back && place <= edge) place += 5;
      if (coming_back && place > edge) homed = true, zero = place - off;
    }
    bench.mode(mode);
    bench.status(mode != 6 ? 0x1237 : homed ? 0x1637 : started ? 0x0237 : 0x8737);
    bench.position(place - zero);
    const bool closed = sees_switch && (place <= edge || (flickers_at > 0 && ++cycles == flickers_at));
    levels = levels << 1 | (closed ? 1u : 0u);
    bench.layout.digital_inputs.set(bench.inputs, levels >> shows_late & 1u);
    const Feedback f = bench.drive.read(bench.inputs, true);
    DriveCommand command{.goal = DriveGoal::Enabled, .target = bench.drive.commanded()};
    if (run.busy()) {
      command = run.step(f);
      led += run.lead_step();
      command.target = bench.drive.commanded() + run.lead_step() / 2000.0;
    }
    bench.drive.write(bench.outputs, command);
  }
  void until_done() {
    for (int n = 0; run.busy() && n < 20'000; ++n) cycle();
  }
};

TEST(Homing, at_the_edge_of_its_switch_it_is_led_off_and_homed_once_more) {
  LimitDrive far(20'000, 0), at_edge(3, 0), blind(3, 0), blind_far(20'000, 0);
  blind.sees_switch = blind_far.sees_switch = false;
  for (LimitDrive* d : {&far, &at_edge, &blind, &blind_far}) d->until_done();
  EXPECT_EQ(far.run.phase(), HomingRun::Phase::Done);
  EXPECT_EQ(far.led, 0);
  EXPECT_EQ(at_edge.run.phase(), HomingRun::Phase::Done) << code(at_edge.run.fault()).text;
  EXPECT_NEAR(at_edge.led, 120, 10) << "away from the negative limit";
  EXPECT_NEAR(at_edge.place, 0, 10) << "and at the edge again";
  EXPECT_EQ(blind.run.fault(), Fault::HomingFailed) << "once, not for ever";
  EXPECT_NEAR(blind.led, 120, 10);
  EXPECT_EQ(blind_far.run.fault(), Fault::HomingFailed) << "20,000 counts away there must have been a switch to see";
  EXPECT_EQ(blind_far.led, 0);
}

/// Within `near` of its edge, and yet not home: its own switch has told where the edge is.
TEST(Homing, a_counter_that_is_set_beside_the_edge_that_was_seen_is_refused) {
  for (const std::int32_t off : {-1900, -400, -350, 0, 350, 400, 1900}) {
    SCOPED_TRACE(off);
    LimitDrive d(20'000, 0);
    d.off = off;
    d.until_done();
    EXPECT_EQ(d.run.fault(), std::abs(off) < 370 ? Fault::None : Fault::HomingFailed);
  }
}

TEST(Homing, an_input_that_is_shown_late_or_bounces_does_not_matter) {
  for (const int late : {1, 20, 31}) {
    SCOPED_TRACE(late);
    LimitDrive d(20'000, 0), off(20'000, 0);
    d.shows_late = off.shows_late = late;
    off.off = 700;
    d.until_done(), off.until_done();
    EXPECT_EQ(d.run.phase(), HomingRun::Phase::Done) << code(d.run.fault()).text;
    if (late <= 20) {  // for so long it has to stand at least
      EXPECT_EQ(off.run.fault(), Fault::HomingFailed);
    }
  }
  LimitDrive bounces(20'000, 0);
  bounces.flickers_at = 100;
  bounces.until_done();
  EXPECT_EQ(bounces.run.phase(), HomingRun::Phase::Done) << code(bounces.run.fault()).text;
}

/// An axis that is homed again has counted its edge as 0 before: what the counter jumps by is less than a cycle's
/// travel.
TEST(Homing, that_sets_the_counter_by_a_little_is_no_travel) {
  for (const std::int32_t from : {19'940, 20'000, 20'110, 20'300}) {
    SCOPED_TRACE(from);
    LimitDrive d(20'000, 0);
    d.zero = 20'000 - from;
    d.until_done();
    EXPECT_EQ(d.run.phase(), HomingRun::Phase::Done) << code(d.run.fault()).text;
  }
}

TEST(Homing, that_is_done_fails_when_it_is_cancelled_before_its_result_was_taken) {
  HomingDrive h;
  h.run.start({}, h.bench.drive.feedback());
  h.until_done();
  ASSERT_EQ(h.run.phase(), HomingRun::Phase::Done);
  h.run.cancel(Fault::EncoderJump);
  EXPECT_EQ(h.run.phase(), HomingRun::Phase::Failed);
  EXPECT_EQ(h.run.fault(), Fault::EncoderJump);
  h.run.cancel(Fault::HomingTimeout);  // the first cause stays
  EXPECT_EQ(h.run.fault(), Fault::EncoderJump);
}

// The bound is a second of the machine, whatever its cycle is.
TEST(Homing, a_drive_that_does_not_take_the_mode_is_given_up_after_a_second_at_every_cycle_time) {
  for (const Time cycle : std::initializer_list<Time>{microseconds(250), milliseconds(1), milliseconds(10)}) {
    SCOPED_TRACE(cycle.count());
    DriveBench bench;
    bench.enable();
    HomingRun run;
    run.start({.cycle = cycle}, bench.drive.feedback());
    std::int64_t n = 0;
    for (; run.phase() == HomingRun::Phase::EnterMode && n < 10'000; ++n) bench.cycle(run.step(bench.drive.feedback()));
    EXPECT_NEAR(seconds(n * cycle), 1.0, 2 * seconds(cycle));
    EXPECT_EQ(run.fault(), Fault::WrongMode);
  }
}

}  // namespace
}  // namespace gantry::devices
