// The axis whose beam stands on two drives (Y: y1 and y2), when one of them loses torque, supply or the other's pace.
#include <algorithm>
#include <cmath>
#include <functional>

#include "tests/machine/idle.hpp"

namespace gantry {
namespace {

using cycle::State;
using run::OrderKind;
using test::Idle;

constexpr std::size_t kY1 = 1, kY2 = 2;  // as the machine file has them
constexpr std::uint32_t kY = 0b10;

bool enabled(const cycle::Snapshot& s, std::size_t drive) { return (s.statusword[drive] & 0x6F) == 0x27; }

/// Reset, as an operator does it: what it came to.
Result<void> reset(run::Owner& owner) {
  if (auto taken = owner.order({.kind = OrderKind::Reset, .value = 1}); !taken) return taken;
  return test::answer_of_reset(owner);
}

/// What a quick stop does to the drives is not known: the other side of a fallen one is braked by its targets.
void quick_stop_unknown(config::Machine& m) {
  for (config::Station& s : m.stations)
    std::erase_if(s.profile.startup, [](const config::StartupRow& row) { return row.address.index == 0x605A; });
}

/// A jog of the beam that ends with a fault of its second side, which stops by a ramp of its own.
struct Racked : Idle {
  Racked() : Idle("[]", quick_stop_unknown) {
    EXPECT_TRUE(owner().world()->add_script("{at: cycle 20600, do: drive_fault, axis: Y, drive: 1, code: 0x0E}"));
    EXPECT_FALSE(owner().jog({.by = {{"Y", "350 mm"}}, .speed = "300 mm/s"}));
    EXPECT_EQ(now().state, State::Stopped);
    EXPECT_TRUE(enabled(now(), kY1)) << "an axis-wise stop leaves the others their torque";
    EXPECT_FALSE(enabled(now(), kY2));
  }
};

/// The largest step that a side with torque is sent in one cycle while `what` is done; counts.
template <class What>
std::int64_t largest_step(Idle& idle, What what) {
  std::int64_t largest = 0;
  cycle::Snapshot last = idle.now();
  idle.owner().on_step([&] {
    const cycle::Snapshot& s = idle.now();
    for (const std::size_t side : {kY1, kY2})
      if (enabled(s, side) && enabled(last, side))
        largest = std::max<std::int64_t>(largest, std::abs(std::int64_t{s.counts[side]} - last.counts[side]));
    last = s;
  });
  what();
  idle.owner().on_step({});
  return largest;
}

void expect_enable_moves_nothing(Idle& idle) {
  const auto step = largest_step(idle, [&] {
    const auto done = idle.owner().enable();
    EXPECT_TRUE(done) << to_text(done.error());
    idle.pass_to(idle.now().cycle + 300);
  });
  EXPECT_LE(step, 1) << "enable moves no axis";
}

TEST(Beam, the_side_that_has_torque_stands_when_the_other_one_has_lost_it) {
  Racked racked;
  const auto sent = racked.now().counts[kY1];
  EXPECT_EQ(largest_step(racked, [&] { racked.pass_to(racked.now().cycle + 1000); }), 0);
  EXPECT_EQ(racked.now().counts[kY1], sent);
  EXPECT_EQ(racked.now().state, State::Stopped);
}

/// Judged by the world's own positions: there the second side is an axis of its own, as it is in truth.
struct InTruth {
  std::size_t y2 = 0;
  test::Rig rig;
  double apart = 0;  ///< the most that the sides were, since `what` happened, mm

  explicit InTruth(const sim::DriveLies& of_y2 = {})
      : rig({.wired =
                 [this](config::Machine& m) {
                   config::Axis side = m.axes[1];
                   y2 = m.axes.size();
                   side.id = AxisId{static_cast<std::uint8_t>(y2)};
                   side.name = "Y2";
                   side.drives = {m.axes[1].drives[1]};
                   m.axes[1].drives.pop_back();
                   const config::SimAxis truth = m.sim.axes[1];
                   m.axes.push_back(side);
                   m.sim.axes.push_back(truth);
                 },
             .habits = {{"y2", {.lies = of_y2}}}}) {
    EXPECT_TRUE(rig.owner().bring_up());
    EXPECT_TRUE(rig.owner().home());
  }
  /// In full motion of the beam.
  run::Owner& meet(const std::string& what, const std::string& speed) {
    run::Owner& owner = rig.owner();
    bool fallen = false;
    owner.on_step([&] {
      const AxisVec q = *owner.world()->axes();
      if (fallen) apart = std::max(apart, std::abs(q[1] - q[y2]));
      if (fallen || owner.latest().target[1] < 150) return;
      fallen = true;
      EXPECT_TRUE(owner.world()->add_script(what));
    });
    const auto jogged = owner.jog({.by = {{"Y", "390 mm"}}, .speed = speed});
    EXPECT_FALSE(jogged);
    for (int i = 0; i < 500; ++i) EXPECT_TRUE(owner.idle());
    owner.on_step({});
    EXPECT_TRUE(fallen);
    EXPECT_EQ(owner.latest().state, State::Stopped);
    return owner;
  }
};

TEST(Beam, both_sides_brake_together_when_one_falls_into_a_fault) {
  for (const auto& [axis, speed] :
       {std::pair{"Y", "300 mm/s"}, {"Y2", "300 mm/s"}, {"Y", "500 mm/s"}, {"Y2", "500 mm/s"}}) {
    SCOPED_TRACE(std::string(axis) + " at " + speed);
    InTruth beam;
    run::Owner& owner = beam.meet(std::string("{do: drive_fault, code: 0x0E, axis: ") + axis + "}", speed);
    EXPECT_LT(beam.apart, 3) << "the frame that tells of it and the one that answers, at 500 mm/s";
    const auto& s = owner.latest();
    EXPECT_EQ(s.latched, Fault::DriveFault) << "nothing else has fallen";
    EXPECT_EQ(s.enabled & kY, 0u);
    EXPECT_EQ(s.enabled, test::kAllAxes & ~kY) << "the others keep their torque";
    const auto cleared = reset(owner);
    ASSERT_TRUE(cleared) << to_text(cleared.error());
    const auto homed = owner.home();
    EXPECT_TRUE(homed) << to_text(homed.error());
  }
}

/// A side that hears nothing more stands at the last target that reached it, and one without supply where it is: 3 ms
/// of lag and a cycle behind that. The other one goes on for as long as it takes to be sure: 3 cycles.
TEST(Beam, the_other_side_stands_at_once_when_one_has_left_the_line) {
  for (const char* what : {"{do: cut_link, station: y2}", "{do: power_off, station: y2}"})
    for (const double speed_mm_s : {300.0, 500.0}) {
      SCOPED_TRACE(std::string(what) + " at " + std::to_string(speed_mm_s));
      InTruth beam;
      run::Owner& owner = beam.meet(what, std::to_string(speed_mm_s) + " mm/s");
      EXPECT_LT(beam.apart, speed_mm_s * (0.003 + 0.001 + 0.003 + 0.0005));
      EXPECT_EQ(owner.latest().latched, Fault::StationSilent);
    }
}

/// 605Ah reads 2, and the torque goes all the same: that side runs out with 1500 mm/s^2, the other one would brake with
/// 4000: 52 mm from 500 mm/s, and the beam bears 12. By hand: 20 counts apart after 4 ms, 3.5 ms of lag and cycles
/// until the brake lets go, 19 mm/s slower by then: (489^2 - 470^2) / (2 x 1500) = 6.1 mm.
TEST(Beam, a_side_that_runs_out_is_not_left_alone_by_one_that_brakes) {
  constexpr const char *kEmergencyInput = "{do: drive_fault, axis: X, code: 0x0400}",
                       *kUndervoltage = "{do: drive_fault, axis: X, code: 0x000D}",
                       *kOfThatSide = "{do: drive_fault, axis: Y2, code: 0x3220}",
                       *kChainOpen = "{do: set_input, input: safety_ok, on: false}";
  for (const char* what : {kEmergencyInput, kUndervoltage, kOfThatSide, kChainOpen})
    for (const char* speed : {"300 mm/s", "500 mm/s"}) {
      SCOPED_TRACE(std::string(what) + " at " + speed);
      InTruth beam({.coasts = true});
      run::Owner& owner = beam.meet(what, speed);
      EXPECT_GE(static_cast<int>(info(owner.latest().latched).reaction), static_cast<int>(Reaction::QuickStop));
      EXPECT_LT(beam.apart, 6.1);
      EXPECT_EQ(owner.latest().enabled, 0u);
    }
}

TEST(Beam, sides_that_stand_apart_are_enabled_in_the_next_cycle_after_a_reset_too) {
  Racked racked;
  racked.pass_to(racked.now().cycle + 500);
  const auto cleared = reset(racked.owner());
  ASSERT_TRUE(cleared) << to_text(cleared.error());
  expect_enable_moves_nothing(racked);
  EXPECT_EQ(racked.now().state, State::Ready);
  EXPECT_EQ(racked.now().referenced & kY, 0u);
}

TEST(Beam, sides_that_stand_apart_are_enabled_where_they_stand_and_squared_by_homing) {
  Racked racked;
  racked.pass_to(racked.now().cycle + 500);
  const auto cleared = reset(racked.owner());
  ASSERT_TRUE(cleared) << to_text(cleared.error());
  EXPECT_EQ(racked.now().state, State::Disabled);
  racked.pass_to(racked.now().cycle + 100);
  EXPECT_EQ(racked.now().referenced & kY, 0u) << "sides farther apart than they may be have no common coordinate";
  expect_enable_moves_nothing(racked);
  EXPECT_EQ(racked.now().state, State::Ready);
  const auto homed = racked.owner().home();
  ASSERT_TRUE(homed) << to_text(homed.error());
  EXPECT_EQ(racked.now().state, State::Ready);
  EXPECT_EQ(racked.now().referenced, test::kAllAxes);
}

TEST(Beam, a_side_that_was_dark_comes_back_with_another_counter_and_neither_is_moved_by_it) {
  Idle idle("[]");
  ASSERT_TRUE(idle.owner().jog({.by = {{"Y", "200 mm"}}, .speed = "200 mm/s"}));
  ASSERT_TRUE(idle.owner().world()->add_script("{do: power_cycle, station: y2, dark: 200 ms}"));
  idle.pass_to(idle.now().cycle + 5000);
  ASSERT_TRUE(idle.whole());
  const auto cleared = reset(idle.owner());
  ASSERT_TRUE(cleared) << to_text(cleared.error());
  expect_enable_moves_nothing(idle);
  EXPECT_EQ(idle.now().latched, Fault::None);
  const auto homed = idle.owner().home();
  ASSERT_TRUE(homed) << to_text(homed.error());
  EXPECT_EQ(idle.now().referenced, test::kAllAxes);
}

TEST(Beam, homing_that_ends_between_the_edges_of_its_sides_leaves_both_where_they_stand) {
  Racked racked;
  ASSERT_TRUE(racked.owner().world()->add_script("{do: power_cycle, station: y2, dark: 200 ms}"));
  racked.pass_to(racked.now().cycle + 5000);
  ASSERT_TRUE(reset(racked.owner()));
  ASSERT_TRUE(racked.owner().enable());
  std::vector<cycle::Snapshot> seen{racked.now()};
  bool aborted = false;
  racked.owner().on_step([&] {
    const cycle::Snapshot& s = racked.now();
    const bool set = std::abs(s.actual[1] - seen.back().actual[1]) > 5;  // a side has met its edge: its counter is set
    if (!aborted && s.state == State::Homing && set) aborted = bool(racked.owner().order({.kind = OrderKind::Abort}));
    seen.push_back(s);
  });
  EXPECT_FALSE(racked.owner().home());
  ASSERT_TRUE(aborted);
  racked.pass_to(racked.now().cycle + 300);
  racked.owner().on_step({});
  EXPECT_EQ(racked.now().latched, Fault::None);
  std::size_t end = seen.size() - 1;
  while (seen[end - 1].state != State::Homing) --end;
  for (std::size_t i = end; i < seen.size(); ++i)
    for (const std::size_t side : {kY1, kY2})
      ASSERT_LE(std::abs(std::int64_t{seen[i].counts[side]} - seen[i - 1].counts[side]), 1)
          << "side " << side << ", " << i - end << " cycles after homing";
  EXPECT_TRUE(racked.owner().home());
}

TEST(Beam, one_that_stands_square_keeps_its_reference_without_torque) {
  Idle idle("[]");
  ASSERT_TRUE(idle.owner().disable());
  idle.pass_to(idle.now().cycle + 1000);
  EXPECT_EQ(idle.now().referenced, test::kAllAxes);
}

/// Less than it may be racked: its reference holds, and so does what stands between the sides until the axis moves.
TEST(Beam, a_side_that_was_pushed_a_little_is_not_moved_by_enable_and_comes_square_in_the_next_motion) {
  Idle idle("[]");
  ASSERT_TRUE(idle.owner().jog({.by = {{"Y", "150 mm"}}, .speed = "200 mm/s"}));
  const double y_before = idle.now().target[1];
  ASSERT_TRUE(idle.owner().disable());
  idle.pass_to(idle.now().cycle + 1000);
  ASSERT_TRUE(idle.owner().world()->add_script("{do: slip_brake, axis: Y, drive: 1, speed: 0.5 mm/s}"));
  idle.pass_to(idle.now().cycle + 340);
  ASSERT_TRUE(idle.owner().world()->add_script("{do: slip_brake, axis: Y, drive: 1, speed: 0 mm/s}"));
  idle.pass_to(idle.now().cycle + 100);
  ASSERT_EQ(idle.now().referenced, test::kAllAxes);
  const auto apart = [&] { return std::int64_t{idle.now().counts[kY2]} - idle.now().counts[kY1]; };
  ASSERT_GT(std::abs(apart()), 150) << "of 0.17 mm";
  expect_enable_moves_nothing(idle);
  EXPECT_EQ(idle.now().state, State::Ready);
  EXPECT_GT(std::abs(apart()), 150) << "enable squares nothing";

  // 50 mm/s are 50 counts a cycle; a side that is squared goes up to 1.25 mm/s beside that.
  const auto step = largest_step(idle, [&] {
    const auto moved = idle.owner().jog({.by = {{"Y", "20 mm"}}, .speed = "50 mm/s"});
    EXPECT_TRUE(moved) << to_text(moved.error());
  });
  EXPECT_LE(step, 52);
  EXPECT_LE(std::abs(apart()), 1) << "square again";
  EXPECT_NEAR(idle.now().target[1], y_before + 20 + 0.085, 0.01) << "of the middle, which the push has moved by half";
  ASSERT_TRUE(idle.owner().jog({.by = {{"Y", "-20 mm"}}, .speed = "50 mm/s"}));
  EXPECT_LE(std::abs(apart()), 1);
}

/// A hand has pushed one side by 47 mm, and the beam bears 12: homing takes out what it bears at a time.
TEST(Beam, one_that_is_racked_beyond_what_it_bears_is_led_out_by_reset_and_home_again_and_again) {
  Idle idle("[]");
  ASSERT_TRUE(idle.owner().jog({.by = {{"Y", "150 mm"}}, .speed = "200 mm/s"}));
  ASSERT_TRUE(idle.owner().disable());
  const CycleIndex from = idle.now().cycle + 100;
  ASSERT_TRUE(idle.owner().world()->add_script(
      "[{at: cycle " + std::to_string(from) + ", do: slip_brake, axis: Y, drive: 1, speed: 47 mm/s}, {at: cycle " +
      std::to_string(from + 1000) + ", do: slip_brake, axis: Y, drive: 1, speed: 0 mm/s}]"));
  idle.pass_to(from + 1500);
  EXPECT_EQ(idle.now().referenced & kY, 0u);
  int refused = 0;
  for (;;) {
    const auto cleared = reset(idle.owner());
    ASSERT_TRUE(cleared) << to_text(cleared.error());
    const auto homed = idle.owner().home();
    if (homed) break;
    ++refused;
    ASSERT_EQ(homed.error().fault, Fault::GantrySkew) << to_text(homed.error());
    const std::string says = to_text(homed.error());
    EXPECT_NE(says.find("look at the beam"), std::string::npos) << says;
    EXPECT_NE(says.find("`reset` and `home`"), std::string::npos) << says;
    ASSERT_LE(refused, 3) << "47 mm: 14, 14, 14 and the rest";
  }
  EXPECT_EQ(refused, 3);
  EXPECT_EQ(idle.now().state, State::Ready);
  EXPECT_EQ(idle.now().referenced, test::kAllAxes);
}

}  // namespace
}  // namespace gantry
