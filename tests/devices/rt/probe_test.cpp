#include "devices/rt/probe.hpp"

#include <gtest/gtest.h>

namespace gantry::devices {
namespace {

/// A drive's probe 1 after the manuals (AMD530B 7.2, iD286 10.2): enabled and latched bits live as long as 60B8h bit 0.
struct DriveProbe {
  std::uint16_t function = 0, status = 0;
  std::int32_t latched = 0;
  bool level = false;
  bool keeps_latch = false;  ///< a drive that does not take the latched bit back

  void take(std::uint16_t word) {
    if ((word & 1) == 0) status = static_cast<std::uint16_t>(keeps_latch ? status & 2 : 0);
    if ((word & 1) != 0 && (function & 1) == 0) status = 1;  // a new edge arms
    function = word;
  }
  void touch(std::int32_t counts) {
    level = true;
    if ((status & 3) == 1 && (function & 0x10) != 0) status |= 2, latched = counts;
  }
  [[nodiscard]] Feedback feedback(bool fresh = true) const {
    Feedback f;
    f.fresh = fresh;
    f.probe_status = status;
    f.probe_level = level;
    f.probe_rising = Counts{latched};
    return f;
  }
};

TEST(Probe, arms_and_gives_the_latched_place_touch_after_touch) {
  DriveProbe d;
  ProbeArm probe;
  for (const std::int32_t place : {100, 200, 300}) {
    d.level = false;
    probe.start(ProbeEdge::Rising, milliseconds(1));
    for (int i = 0; i < 20; ++i) d.take(probe.step(d.feedback()));
    ASSERT_EQ(probe.phase(), ProbeArm::Phase::Armed);
    d.touch(place);
    d.take(probe.step(d.feedback()));
    ASSERT_EQ(probe.phase(), ProbeArm::Phase::Latched);
    EXPECT_EQ(probe.latched().value, place);
  }
}

/// A drive that takes its time does so in milliseconds, whatever the machine's cycle.
TEST(Probe, a_drive_has_50_ms_to_show_that_it_is_armed) {
  for (const Time cycle : {Time{microseconds(250)}, Time{milliseconds(1)}, Time{milliseconds(10)}})
    for (const bool in_time : {true, false}) {
      const Time answers = in_time ? milliseconds(40) : milliseconds(100);
      ProbeArm probe;
      probe.start(ProbeEdge::Rising, cycle);
      DriveProbe silent, armed;
      armed.take(0x11);
      Time asked{0};
      for (Time t{0}; t < milliseconds(300); t += cycle) {
        const bool shows = asked > Time{0} && t - asked >= answers;
        const std::uint16_t word = probe.step(shows ? armed.feedback() : silent.feedback());
        if (word != 0 && asked == Time{0}) asked = t;
        if (probe.phase() == ProbeArm::Phase::Failed) break;
      }
      EXPECT_EQ(probe.phase(), in_time ? ProbeArm::Phase::Armed : ProbeArm::Phase::Failed) << cycle.count() << " ns";
    }
}

TEST(Probe, the_edge_survives_lost_frames) {
  DriveProbe d;
  d.function = 0x11, d.status = 3, d.latched = 55;  // armed and latched by somebody before
  ProbeArm probe;
  probe.start(ProbeEdge::Rising, milliseconds(1));
  for (int i = 0; i < 40; ++i) {
    const bool lost = i % 2 == 0;
    const std::uint16_t word = probe.step(d.feedback(!lost));
    if (!lost) d.take(word);
    EXPECT_NE(probe.phase(), ProbeArm::Phase::Latched);  // the old latch is never taken
  }
  EXPECT_EQ(probe.phase(), ProbeArm::Phase::Armed);
}

TEST(Probe, an_active_probe_is_refused_before_the_move) {
  DriveProbe d;
  d.level = true;
  ProbeArm probe;
  probe.start(ProbeEdge::Rising, milliseconds(1));
  EXPECT_EQ(probe.step(d.feedback()), 0);
  EXPECT_EQ(probe.phase(), ProbeArm::Phase::Failed);
  EXPECT_EQ(probe.fault(), Fault::ProbeAlreadyActive);
}

TEST(Probe, a_latch_that_does_not_vanish_is_stale) {
  DriveProbe d;
  d.keeps_latch = true;
  d.status = 3;
  ProbeArm probe;
  probe.start(ProbeEdge::Rising, milliseconds(1));
  for (int i = 0; i < 100; ++i) d.take(probe.step(d.feedback()));
  EXPECT_EQ(probe.fault(), Fault::ProbeStale);
}

/// Nothing moves before the probe is armed: an edge that is shown with "enabled" is no touch.
TEST(Probe, a_latch_that_comes_with_arming_is_refused) {
  for (const bool closed : {false, true}) {
    ProbeArm probe;
    probe.start(ProbeEdge::Rising, milliseconds(1));
    Feedback f;
    f.fresh = true;
    while (probe.phase() == ProbeArm::Phase::Clearing) probe.step(f);
    f.probe_status = 0x0003;
    f.probe_level = closed;
    EXPECT_EQ(probe.step(f), 0);
    EXPECT_EQ(probe.phase(), ProbeArm::Phase::Failed);
    EXPECT_EQ(probe.fault(), closed ? Fault::ProbeAlreadyActive : Fault::ProbeStale);
  }
}

/// An armed probe, at so many ns a cycle, that has shown nothing yet.
struct Armed {
  explicit Armed(Time cycle) {
    probe.start(ProbeEdge::Rising, cycle);
    for (int i = 0; i < 200 && probe.phase() != ProbeArm::Phase::Armed; ++i) drive.take(probe.step(drive.feedback()));
    EXPECT_EQ(probe.phase(), ProbeArm::Phase::Armed);
  }
  DriveProbe drive;
  ProbeArm probe;
};

/// docs/machine.md, `probe.speed`: the axis stops for a contact after 25 ms. Of these 10 are the way in and out.
TEST(Probe, an_active_level_without_a_latch_is_waited_for_15_ms) {
  for (const Time cycle : {Time{microseconds(250)}, Time{milliseconds(1)}, Time{milliseconds(4)}}) {
    Armed a(cycle);
    a.drive.level = true;
    Time failed{0};
    for (Time t{0}; t < milliseconds(100) && failed == Time{0}; t += cycle) {
      a.drive.take(a.probe.step(a.drive.feedback()));
      if (a.probe.phase() == ProbeArm::Phase::Failed) failed = t;
    }
    EXPECT_EQ(a.probe.fault(), Fault::ProbeStale);
    EXPECT_LE(failed, milliseconds(15)) << cycle.count();
    EXPECT_GT(failed, milliseconds(15) - 2 * cycle) << cycle.count();
  }
}

TEST(Probe, a_latch_that_comes_up_to_14_ms_behind_the_level_counts) {
  for (const int behind : {0, 1, 7, 14}) {
    Armed a(milliseconds(1));
    a.drive.level = true;
    for (int i = 0; i < behind; ++i) a.drive.take(a.probe.step(a.drive.feedback()));
    a.drive.touch(77);
    a.drive.take(a.probe.step(a.drive.feedback()));
    EXPECT_EQ(a.probe.phase(), ProbeArm::Phase::Latched) << behind;
  }
}

TEST(Probe, an_arming_that_the_drive_takes_back_fails_at_once_and_stale_inputs_say_nothing) {
  Armed a(milliseconds(1));
  a.drive.status = 0;
  for (int i = 0; i < 50; ++i) a.probe.step(a.drive.feedback(false));
  EXPECT_EQ(a.probe.phase(), ProbeArm::Phase::Armed);
  EXPECT_EQ(a.probe.step(a.drive.feedback()), 0);
  EXPECT_EQ(a.probe.phase(), ProbeArm::Phase::Failed);
  EXPECT_EQ(a.probe.fault(), Fault::ProbeStale);
}

TEST(Probe, a_drive_that_never_shows_enabled_fails) {
  ProbeArm probe;
  probe.start(ProbeEdge::Rising, milliseconds(1));
  Feedback f;
  f.fresh = true;
  for (int i = 0; i < 200; ++i) probe.step(f);
  EXPECT_EQ(probe.fault(), Fault::ProbeStale);
}

}  // namespace
}  // namespace gantry::devices
