// Stops that do not hope: a machine in full motion, and a fault that takes every drive's torque. Positions over time
// are the judge. The virtual drives run out when their torque goes (sim.axes.NAME.coast), and so does a quick stop of
// those whose 605Ah is absent or documented nowhere (iD286, STD402EC).
#include <cmath>
#include <fmt/format.h>
#include <vector>

#include "tests/altered.hpp"
#include "tests/machine/idle.hpp"

namespace gantry::test {
namespace {

constexpr CycleIndex kStruck = kTrouble + 400;

bool has_torque(std::uint16_t statusword) { return (statusword & 0x6F) == 0x27 || (statusword & 0x6F) == 0x07; }

struct Sample {
  CycleIndex cycle = 0;
  AxisVec actual{};
  std::array<std::uint16_t, 6> statusword{};  ///< X, Y1, Y2, Z, C, U
  bool latched = false;
};

struct Struck {
  Fault fault = Fault::None;
  std::vector<Sample> samples;
  cycle::Snapshot last;

  /// The last sample before the fault was latched; `before`: so many cycles before that.
  [[nodiscard]] const Sample& hit(std::size_t before = 0) const {
    std::size_t i = 0;
    while (i < samples.size() && !samples[i].latched) ++i;
    return samples.at(i < before + 1 ? 0 : i - 1 - before);
  }
  /// Where the axis came to a stand, and the first cycle in which it stood.
  [[nodiscard]] CycleIndex stands_from(std::size_t axis) const {
    CycleIndex from = samples.back().cycle;
    for (auto s = samples.rbegin();
         s != samples.rend() && std::abs(s->actual[axis] - samples.back().actual[axis]) < 2e-3; ++s)
      from = s->cycle;
    return from;
  }
  [[nodiscard]] CycleIndex torque_until(std::size_t drive) const {
    CycleIndex until = -1;
    for (const Sample& s : samples)
      if (has_torque(s.statusword[drive])) until = s.cycle;
    return until;
  }
};

/// A jog at speed, and what the script does to it at kStruck.
Struck strike(const std::string& script, const std::function<void(config::Machine&)>& change, job::JogWords words) {
  Rig rig({.placement = "dx=0 mm", .script = script, .change = change});
  Struck out;
  EXPECT_TRUE(rig.owner().bring_up());
  EXPECT_TRUE(rig.owner().home());
  EXPECT_LT(rig.owner().latest().cycle, kTrouble);
  while (rig.owner().latest().cycle < kTrouble) EXPECT_TRUE(rig.owner().idle());
  const auto sample = [&] {
    const auto& now = rig.owner().latest();
    if (!out.samples.empty() && out.samples.back().cycle == now.cycle) return;
    Sample s{now.cycle, now.actual, {}, now.latched != Fault::None};
    std::copy_n(now.statusword.begin(), s.statusword.size(), s.statusword.begin());
    out.samples.push_back(s);
  };
  rig.owner().on_step(sample);
  const auto jogged = rig.owner().jog(words);
  if (!jogged) out.fault = jogged.error().fault;
  for (int i = 0; i < 1500; ++i) EXPECT_TRUE(rig.owner().idle());
  rig.owner().on_step({});
  out.last = rig.owner().latest();
  return out;
}

std::string fault_of(const char* axis, int code) {
  return fmt::format("[{{at: cycle {}, do: drive_fault, axis: {}, code: {}}}]", kStruck, axis, code);
}

constexpr int kUndervoltage = 0x3220;  // STD402EC 11.5, AMD530B 3.8: a quick stop in the catalogue (G213)

/// v^2 / 2a, what the jerk adds (v a / 2j), and what is on its way: lag, cycles, the fault's way to the loop.
double braking_mm(const config::Axis& axis, double v) {
  return v * v / (2 * axis.a_max) + v * axis.a_max / (2 * axis.j_max) + v * 0.008;
}

TEST(Stops, an_axis_whose_quick_stop_nobody_knows_is_braked_by_its_targets_and_loses_its_torque_standing) {
  job::JogWords words;
  words.by["X"] = "400 mm";
  words.speed = "500 mm/s";
  const Struck s = strike(fault_of("C", kUndervoltage), {}, words);
  EXPECT_EQ(s.fault, Fault::Undervoltage);
  const auto machine = config::load_machine("config/machines/dispenser.yaml");
  ASSERT_TRUE(machine);
  const double v = (s.hit().actual[0] - s.hit(10).actual[0]) / 0.010;
  ASSERT_GT(v, 495) << "mm/s";
  const double went = s.samples.back().actual[0] - s.hit().actual[0];
  std::printf("X went %.1f mm from %.0f mm/s\n", went, v);
  EXPECT_LT(went, braking_mm(machine->axes[0], v)) << "running out it goes 83 mm";
  EXPECT_GT(s.torque_until(0), s.stands_from(0)) << "it stood before it lost its torque";
  EXPECT_LT(s.torque_until(0), s.stands_from(0) + 50);
  EXPECT_EQ(s.last.enabled, 0u) << "in the end all torque is gone";
  for (std::size_t d = 0; d < 6; ++d) EXPECT_FALSE(has_torque(s.last.statusword[d])) << d;
  EXPECT_EQ(s.last.state, cycle::State::Stopped);
}

TEST(Stops, a_gantry_whose_quick_stop_is_documented_brakes_by_itself_and_as_short) {
  job::JogWords words;
  words.by["Y"] = "350 mm";
  words.speed = "500 mm/s";
  for (const std::int64_t option : {2, 6, 0}) {  // AMD530B 8.4: by 6085h and off; by 6085h and energised; at once
    const Struck s = strike(
        fault_of("C", kUndervoltage),
        [&](auto& m) {
          for (const char* side : {"y1", "y2"})
            for (auto& row : station(m, side).profile.startup)
              if (row.address == config::ObjectAddress{0x605A, 0}) row.value = option;
        },
        words);
    EXPECT_EQ(s.fault, Fault::Undervoltage) << option;
    const double went = s.samples.back().actual[1] - s.hit().actual[1];
    std::printf("605Ah = %d: Y went %.1f mm\n", static_cast<int>(option), went);
    EXPECT_LT(went, 500.0 * 500 / (2 * 4000) + 500 * 0.008) << option;
    for (std::size_t d = 0; d < 6; ++d) EXPECT_FALSE(has_torque(s.last.statusword[d])) << option << ", drive " << d;
  }
}

// What homes moves by itself; its torque goes when it stands, too.
TEST(Stops, homing_is_ended_before_the_torque_goes) {
  // X, Y, C and U home from here on, X and Y fast.
  CycleIndex begins = 0;
  {
    Rig rig({.placement = "dx=0 mm"});
    ASSERT_TRUE(rig.owner().bring_up());
    rig.owner().on_step([&] {
      const auto& now = rig.owner().latest();
      const bool z_is_home = (now.referenced >> 2 & 1u) != 0;
      if (begins == 0 && z_is_home && now.state == cycle::State::Homing) begins = now.cycle;
    });
    ASSERT_TRUE(rig.owner().home());
    rig.owner().on_step({});
  }
  ASSERT_GT(begins, 0);
  Rig rig({.placement = "dx=0 mm",
           .script = fmt::format("[{{at: cycle {}, do: drive_fault, axis: C, code: 0x3220}}]", begins + 600)});
  ASSERT_TRUE(rig.owner().bring_up());
  double fastest = 0, without_torque = 0, last = 0;
  CycleIndex cycle = 0;
  rig.owner().on_step([&] {
    const auto& now = rig.owner().latest();
    if (now.cycle == cycle) return;
    const double step = std::abs(now.actual[0] - last);
    if (now.cycle == cycle + 1 && now.cycle > begins) {
      fastest = std::max(fastest, step);
      if (!has_torque(now.statusword[0])) without_torque = std::max(without_torque, step);
    }
    cycle = now.cycle, last = now.actual[0];
  });
  const auto homed = rig.owner().home();
  ASSERT_FALSE(homed);
  for (int i = 0; i < 500; ++i) ASSERT_TRUE(rig.owner().idle());
  rig.owner().on_step({});
  EXPECT_EQ(homed.error().fault, Fault::Undervoltage) << to_text(homed.error());
  EXPECT_GT(fastest, 0.05) << "60 mm/s";
  EXPECT_LT(without_torque, 0.002) << "mm a cycle";
  EXPECT_EQ(rig.owner().latest().enabled, 0u);
}

// AMD530B 8.4: after a quick stop with 605Ah = 5, 6 or 7 the controlword must go back before it can be enabled.
TEST(Stops, after_a_quick_stop_that_stays_energised_the_machine_can_be_enabled_again) {
  Rig rig({.placement = "dx=0 mm",
           .script = fmt::format("[{{at: cycle {}, do: drive_fault, axis: C, code: 0x3220}}]", kTrouble),
           .change = [](auto& m) {
             for (const char* side : {"y1", "y2"})
               for (auto& row : station(m, side).profile.startup)
                 if (row.address == config::ObjectAddress{0x605A, 0}) row.value = 6;
           }});
  ASSERT_TRUE(rig.owner().bring_up());
  ASSERT_TRUE(rig.owner().home());
  while (rig.owner().latest().latched == Fault::None && rig.owner().latest().cycle < kTrouble + 100)
    ASSERT_TRUE(rig.owner().idle());
  ASSERT_EQ(rig.owner().latest().latched, Fault::Undervoltage);
  ASSERT_TRUE(rig.owner().order({.kind = run::OrderKind::Reset}));
  EXPECT_TRUE(answer_of_reset(rig.owner()));
  const auto enabled = rig.owner().enable();
  EXPECT_TRUE(enabled) << to_text(enabled.error());
  EXPECT_EQ(rig.owner().latest().enabled, kAllAxes);
}

}  // namespace
}  // namespace gantry::test
