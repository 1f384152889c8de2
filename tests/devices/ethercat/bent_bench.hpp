// A bus bench of which the simulated stations are not what the profiles say.
//   BentBench b([](config::Machine& wired) { station(wired, "x").profile... });
//   b.habits("x", {.even_pdos = true});
//   b.works("X");              // in OP, enabled, moved in CSP, homed
#pragma once
#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <optional>
#include <string_view>

#include "devices/profiles/homing_objects.hpp"
#include "devices/profiles/object_value.hpp"
#include "devices/rt/homing.hpp"
#include "sim/station/habits.hpp"
#include "tests/altered.hpp"
#include "tests/devices/ethercat/bus_bench.hpp"

namespace gantry::devices {

using test::object, test::remove_object, test::station;

struct BentBench : BusBench {
  explicit BentBench(const Change& change) : BusBench(change) { with_homing_objects(); }
  void habits(std::string_view name, const sim::StationHabits& h) { segment.set_habits(station(wired, name).id, h); }
  /// As compose_startup() does for the real machine: homing's objects are start-up objects.
  void with_homing_objects() {
    for (const auto& axis : machine.axes) {
      if (!axis.homing) continue;
      for (const auto& ref : axis.drives) {
        auto& s = machine.stations[ref.station.value];
        if (s.bus != config::BusKind::EtherCat) continue;
        const auto rows = homing_objects(s.profile, ref.slot, axis);
        ASSERT_TRUE(rows) << to_text(rows.error());
        s.profile.startup.insert(s.profile.startup.end(), rows->begin(), rows->end());
      }
    }
  }
  [[nodiscard]] bool noted(std::string_view where, std::string_view what) const {
    return std::ranges::count_if(master->notes(), [&](const std::string& note) {
             return note.find(where) != std::string::npos && note.find(what) != std::string::npos;
           }) == 1;
  }
  [[nodiscard]] std::string all_notes() const {
    std::string text;
    for (const auto& note : master->notes()) text += note + "\n";
    return text;
  }
  void served_cycle() {
    cycle();
    master->step_by([this] { cycle(); });
    master->serve_objects();
    master->step_by({});
  }
  template <class Condition>
  int served_until(Condition condition, int limit) {
    int n = 0;
    while (!condition() && n < limit) served_cycle(), ++n;
    return n;
  }
  /// Every drive is enabled, the axis follows a motion and homes, and its switch has the configured coordinate.
  void works(std::string_view axis_name) {
    ASSERT_NO_FATAL_FAILURE(operate());
    for (auto& d : drives) d.command = {.goal = DriveGoal::Enabled, .target = d.drive.feedback().position};
    served_until(
        [&] {
          for (auto& d : drives) d.command.target = d.drive.commanded();
          return std::ranges::all_of(drives, [](auto& d) { return d.drive.feedback().takes_targets; });
        },
        2000);
    for (auto& d : drives)
      ASSERT_TRUE(d.drive.feedback().takes_targets)
          << "axis " << int(d.axis.value) << ": " << name(d.drive.feedback().state);
    const auto* axis = config::find_axis(machine, axis_name);
    auto& d = of(axis_name);
    const double from = d.drive.commanded(), at = segment.motor(axis->id).position();
    for (int i = 1; i <= 500; ++i) {
      d.command.target = from + 1.0 * (1 - std::cos(std::numbers::pi * i / 500));
      served_cycle();
      ASSERT_EQ(d.drive.feedback().fault, Fault::None) << code(d.drive.feedback().fault).text;
    }
    cycles(100);
    EXPECT_NEAR(d.drive.feedback().position, from + 2.0, 0.005);
    EXPECT_NEAR(segment.motor(axis->id).position(), at + 2.0, 0.02);
    HomingRun run;
    const double span = axis->p_max - axis->p_min;
    run.start({.timeout_cycles = 60'000, .travel_counts = std::llround(1.5 * span * axis->counts_per_unit)},
              d.drive.feedback());
    served_until([&] { return d.command = run.step(d.drive.feedback()), !run.busy(); }, 70'000);
    ASSERT_EQ(run.phase(), HomingRun::Phase::Done) << code(run.fault()).text;
    d.drive.set_reference(Counts{0}, axis->homing->position);
    d.command = {.goal = DriveGoal::Enabled, .target = d.drive.commanded()};
    cycles(50);
    EXPECT_EQ(d.drive.feedback().fault, Fault::None);
    EXPECT_NEAR(d.drive.feedback().position, segment.motor(axis->id).position(), 0.02);
    EXPECT_NEAR(d.drive.feedback().position, axis->homing->position, 0.5);
  }
};

}  // namespace gantry::devices
