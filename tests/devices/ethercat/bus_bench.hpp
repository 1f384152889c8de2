// The reference machine's bus in virtual time: master, port and virtual segment in one thread, with a loop as
// app/cycle has it.
#pragma once
#include <functional>
#include <gtest/gtest.h>
#include <map>
#include <vector>

#include "config/machine.hpp"
#include "devices/ethercat/master.hpp"
#include "devices/ethercat/survey.hpp"
#include "devices/profiles/map_pdos.hpp"
#include "devices/rt/dc_lock.hpp"
#include "devices/rt/drive.hpp"
#include "devices/rt/probe.hpp"
#include "sim/segment/segment.hpp"
#include "sim/segment/segment_port.hpp"

namespace gantry::devices {

inline const config::Machine& reference_machine() {
  static const config::Machine machine = [] {
    auto m = config::load_machine(GANTRY_SOURCE_DIR "/config/machines/dispenser.yaml");
    EXPECT_TRUE(m) << (m ? "" : to_text(m.error().front()));
    return m ? std::move(*m) : config::Machine{};
  }();
  return machine;
}

/// A segment asked without a machine file.
struct SurveyBench {
  config::Machine machine = reference_machine();
  VirtualClock clock;
  sim::Segment segment{machine, clock};
  sim::SegmentPort port{segment, clock};
  Survey survey{port, clock};
};

/// One drive of one axis with what is asked of it.
struct BenchDrive {
  AxisId axis;
  StationId station;
  Drive drive;
  DriveCommand command;
};

struct BusBench {
  using Change = std::function<void(config::Machine&)>;
  /// `change` is made to what the segment is built from, and to nothing that the controller reads.
  explicit BusBench(const Change& change = {}) : wired(changed(change)) {}
  static config::Machine changed(const Change& change) {
    config::Machine m = reference_machine();
    if (change) change(m);
    return m;
  }

  config::Machine wired;                          ///< as the segment is built
  config::Machine machine = reference_machine();  ///< as the controller believes
  VirtualClock clock;
  sim::Segment segment{wired, clock};
  sim::SegmentPort port{segment, clock};
  FramePort* port_used = &port;  ///< a tap may stand between
  std::unique_ptr<EthercatMaster> master;
  std::vector<BenchDrive> drives;
  DcLock lock;
  Time due{};
  Exchange last;

  Result<void> bring_up(const MasterOptions& options = {}) {
    master = std::make_unique<EthercatMaster>(machine, *port_used, clock, options);
    if (auto ok = master->bring_up(); !ok) return ok;
    drives.clear();
    for (const auto& axis : machine.axes)
      for (const auto& ref : axis.drives) {
        const auto& station = machine.stations[ref.station.value];
        if (station.bus != config::BusKind::EtherCat) continue;
        const auto layout = map_drive(station.profile, ref.slot);
        if (!layout) return tl::unexpected(layout.error());
        drives.push_back({axis.id, station.id, Drive(*layout, AxisScale(axis.counts_per_unit, ref.invert)), {}});
      }
    due = master->first_cycle(clock.now());
    return {};
  }

  void cycle() {
    clock.sleep_until(due);
    for (auto& d : drives) d.drive.write(master->outputs(d.station), d.command);
    last = master->exchange(due + microseconds(400));
    for (auto& d : drives) d.drive.read(master->inputs(d.station), master->fresh(d.station));
    due += machine.bus.cycle + lock.step(last.reference_ns);
  }
  void cycles(int n) {
    for (int i = 0; i < n; ++i) cycle();
  }
  /// Cycles until it is true, at most `limit`; how many.
  template <class Condition>
  int until(Condition condition, int limit) {
    int n = 0;
    while (!condition() && n < limit) cycle(), ++n;
    return n;
  }
  /// Into OP with every drive disabled.
  void operate() {
    const auto up = bring_up();
    ASSERT_TRUE(up) << to_text(up.error());
    cycles(20);
    const auto asked = master->request_operation();
    ASSERT_TRUE(asked) << to_text(asked.error());
    until([&] { return last.ethercat.al_states == 8; }, 2000);
    const auto all = master->check_operation();
    ASSERT_TRUE(all) << to_text(all.error());
  }
  void enable() {
    for (auto& d : drives) d.command = {.goal = DriveGoal::Enabled, .target = d.drive.feedback().position};
    until(
        [&] {
          bool all = true;
          for (auto& d : drives) {
            if (!d.drive.feedback().takes_targets) all = false;
            d.command.target = d.drive.commanded();
          }
          return all;
        },
        2000);
    for (auto& d : drives)
      ASSERT_TRUE(d.drive.feedback().takes_targets)
          << "axis " << int(d.axis.value) << ": " << name(d.drive.feedback().state);
  }
  BenchDrive& of(std::string_view axis, int n = 0) {
    const AxisId id = config::find_axis(machine, axis)->id;
    for (auto& d : drives)
      if (d.axis == id && n-- == 0) return d;
    ADD_FAILURE() << "no drive of " << axis;
    return drives.front();
  }
  /// Z goes down in CSP until its probe latches, and the latched position is where the surface is.
  void touches() {
    auto& z = of("Z");
    const double from = z.drive.commanded();
    auto& motor = segment.motor(z.axis);
    motor.set_contact(motor.position() - 3.3335);
    ProbeArm probe;
    probe.start(ProbeEdge::Rising, milliseconds(1));
    until(
        [&] {
          z.command.probe_function = probe.step(z.drive.feedback());
          return probe.phase() != ProbeArm::Phase::Clearing && probe.phase() != ProbeArm::Phase::Arming;
        },
        200);
    ASSERT_EQ(probe.phase(), ProbeArm::Phase::Armed) << code(probe.fault()).text;
    for (int i = 1; i <= 1000 && probe.phase() == ProbeArm::Phase::Armed; ++i) {
      z.command.target = from - 0.005 * i;
      z.command.probe_function = probe.step(z.drive.feedback());
      cycle();
    }
    ASSERT_EQ(probe.phase(), ProbeArm::Phase::Latched);
    EXPECT_NEAR(z.drive.scale().to_position(probe.latched()), from - 3.3335, 0.002);
  }
};

}  // namespace gantry::devices
