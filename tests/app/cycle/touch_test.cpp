// A plane at a known height is touched from many heights, at many places within a cycle: the probe's latch must tell it
// within a count and what the axis goes in one cycle. The judge is the coordinate at which the virtual motor meets it.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <random>

#include "app/job/limits.hpp"
#include "motion/path/moves.hpp"
#include "tests/app/cycle/loop_bench.hpp"

namespace gantry::test {
namespace {

using cycle::CommandKind;
using cycle::EventKind;
using cycle::State;

/// The bus as it is, but for what the drive of the probe says of its probe.
class OtherLatch final : public devices::FieldBus {
 public:
  OtherLatch(devices::FieldBus& bus, const cycle::DriveSetup& drive) : bus_(bus), drive_(drive) {}
  Counts off{};
  std::uint16_t never_shows = 0;  ///< bits of 60B9h

  Result<void> bring_up() override { return bus_.bring_up(); }
  Result<void> request_operation() override { return bus_.request_operation(); }
  Result<void> check_operation() override { return bus_.check_operation(); }
  [[nodiscard]] Time first_cycle(Time t) const noexcept override { return bus_.first_cycle(t); }
  void shut_down() override { bus_.shut_down(); }
  Result<devices::Bytes> read_object(StationId s, config::ObjectAddress a) override { return bus_.read_object(s, a); }
  Result<void> write_object(StationId s, config::ObjectAddress a, std::span<const std::byte> v) override {
    return bus_.write_object(s, a, v);
  }
  [[nodiscard]] std::span<std::byte> outputs(StationId s) noexcept override { return bus_.outputs(s); }
  [[nodiscard]] std::span<const std::byte> inputs(StationId s) const noexcept override {
    if (s != drive_.station) return bus_.inputs(s);
    const auto true_ones = bus_.inputs(s);
    const std::span told = std::span(told_).first(true_ones.size());
    std::ranges::copy(true_ones, told.begin());
    drive_.layout.probe_rising.set(told,
                                   static_cast<std::int32_t>(drive_.layout.probe_rising.get(true_ones) + off.value));
    const auto status = drive_.layout.probe_status.get(true_ones);
    drive_.layout.probe_status.set(told, static_cast<std::uint16_t>(status & ~never_shows));
    return told;
  }
  [[nodiscard]] bool fresh(StationId s) const noexcept override { return bus_.fresh(s); }
  devices::Exchange exchange(Time deadline) noexcept override { return bus_.exchange(deadline); }
  void arm(Time deadline) noexcept override { bus_.arm(deadline); }
  std::size_t spare_frames(std::span<const devices::ImageChange> changes,
                           std::span<devices::FrameBytes> frames) noexcept override {
    return bus_.spare_frames(changes, frames);
  }

 private:
  devices::FieldBus& bus_;
  const cycle::DriveSetup& drive_;
  mutable std::array<std::byte, 64> told_{};
};

struct Touching : LoopBench {
  Touching() {
    loop = std::make_unique<cycle::Loop>(setup, bus, nullptr, clock, *channels, &stop);
    operate();
    enable();
    home();
    limits = job::limits_of(machine);
  }
  void begin_block(std::vector<motion::Segment> segments) {
    ++block;
    for (motion::Segment& s : segments) {
      s.block = block;
      s.ends_block = &s == &segments.back();
      ASSERT_TRUE(channels->segments.push(s));
    }
    events.clear();
    ASSERT_EQ(command({.kind = CommandKind::StartBlock, .block = block}), Fault::None);
  }
  void play_block(std::vector<motion::Segment> segments) {
    begin_block(std::move(segments));
    ASSERT_TRUE(until([&] { return now.state != State::Running && now.state != State::Stopping; }, 60'000));
  }
  /// Only Z moves.
  void go(double z) {
    AxisVec to = now.target;
    to[2] = z;
    play_block(motion::line_move(limits, now.target, to));
  }
  /// Down to `lowest` at most; where the probe told that it touched, or what was wrong.
  std::optional<double> touch(double lowest) {
    if (const Fault armed = command({.kind = CommandKind::ArmProbe}); armed != Fault::None) {
      refused = armed;
      return std::nullopt;
    }
    return approach(lowest);
  }
  /// The same of a probe that was armed before, or was not.
  std::optional<double> approach(double lowest) {
    AxisVec to = now.target;
    to[2] = lowest;
    play_block(motion::probe_move(limits, now.target, to, machine.probe.speed_mm_s));
    for (const cycle::Event& e : events)
      if (e.kind == EventKind::Touched) return e.value;
    return std::nullopt;
  }
  sim::Motor& z() { return segment.motor(machine.z); }

  OtherLatch bus{*master, *std::ranges::find(setup.drives, machine.z, &cycle::DriveSetup::axis)};
  motion::Limits limits;
  std::uint32_t block = 100;
  Fault refused = Fault::None;
};

TEST(Touch, a_plane_is_met_within_a_count_and_a_cycle_of_travel) {
  const char* more = std::getenv("GANTRY_ROUNDS");
  const int rounds = more != nullptr ? std::atoi(more) : 60;
  Touching b;
  if (HasFatalFailure()) return;
  const config::Axis& axis = b.machine.axes[b.machine.z.value];
  const double allowed = 1 / axis.counts_per_unit + b.machine.probe.speed_mm_s * seconds(b.machine.bus.cycle);
  std::mt19937_64 random(11);
  double worst = 0;
  for (int i = 0; i < rounds; ++i) {
    const double plane = std::uniform_real_distribution(-60.0, -20.0)(random);
    const double above = std::uniform_real_distribution(0.2, 3.0)(random);
    b.z().set_contact(-1e9);
    b.go(plane + above);
    b.z().set_contact(plane);
    const auto met = b.touch(plane - 2);
    ASSERT_TRUE(met) << "round " << i << ": " << plane << " from " << above << " above";
    worst = std::max(worst, std::abs(*met - plane));
    EXPECT_LE(std::abs(*met - plane), allowed) << "round " << i << ": " << plane << " from " << above << " above";
    EXPECT_GE(b.now.target[2], plane - 1) << "it ends a little below";
  }
  std::printf("%d touches: %.6f mm at worst, %.6f mm are allowed\n", rounds, worst, allowed);
}

TEST(Touch, a_probe_that_is_active_already_is_refused_and_nothing_moves) {
  Touching b;
  if (HasFatalFailure()) return;
  b.go(-30);
  b.z().set_contact(-20);  // it stands in the plane
  b.ticks(20);
  const double stood = b.now.target[2];
  EXPECT_FALSE(b.touch(-35));
  EXPECT_EQ(b.refused, Fault::ProbeAlreadyActive);
  EXPECT_EQ(b.now.target[2], stood);
}

// Something closes the probe before the motion that waits for it has begun, or in travel.
TEST(Touch, a_latch_that_comes_before_the_touch_is_none) {
  Touching b;
  if (HasFatalFailure()) return;
  b.z().set_contact(-1e9);
  b.go(-30);
  ASSERT_EQ(b.command({.kind = CommandKind::ArmProbe}), Fault::None);
  b.z().set_contact(-20);
  b.ticks(20);
  EXPECT_EQ(b.now.latched, Fault::None) << "a path stop that needs no reset";
  EXPECT_EQ(b.told(Fault::ProbeImplausible), 1);
  for (const cycle::Event& e : b.events) EXPECT_NE(e.kind, EventKind::Touched);
}

/// 60B9h, CiA 402-2: bit 0 "enabled", bit 1 "rising edge stored".
constexpr std::uint16_t kEnabled = 1, kStored = 2;

// Nothing would end it: a hand has closed the probe and let go of it again, an abort has disarmed it, or nobody armed
// it.
TEST(Touch, an_approach_without_an_armed_probe_ends_where_it_begins) {
  enum class Why { Tripped, Aborted, NeverArmed };
  for (const Why why : {Why::Tripped, Why::Aborted, Why::NeverArmed}) {
    SCOPED_TRACE(static_cast<int>(why));
    Touching b;
    if (HasFatalFailure()) return;
    b.z().set_contact(-1e9);
    b.go(-30);
    if (why != Why::NeverArmed) {
      ASSERT_EQ(b.command({.kind = CommandKind::ArmProbe}), Fault::None);
    }
    if (why == Why::Aborted) {
      ASSERT_EQ(b.command({.kind = CommandKind::Abort}), Fault::None);
    }
    b.events.clear();
    b.z().set_contact(-20);
    b.ticks(20);
    EXPECT_EQ(b.told(Fault::ProbeImplausible), why == Why::Tripped ? 1 : 0);
    b.z().set_contact(-1e9);
    b.ticks(20);
    b.z().set_contact(-33);
    EXPECT_FALSE(b.approach(-36));
    EXPECT_EQ(b.told(why == Why::Tripped ? Fault::ProbeImplausible : Fault::ProbeStale), 1);
    EXPECT_GT(b.now.target[2], -30 - b.machine.probe.speed_mm_s * 0.01) << "it has gone for some cycles at most";
    EXPECT_EQ(b.now.state, State::Ready);
    EXPECT_EQ(b.now.latched, Fault::None) << "a path stop that needs no reset";
    for (const cycle::Event& e : b.events) EXPECT_NE(e.kind, EventKind::Touched);
  }
}

TEST(Touch, a_hand_that_closes_the_probe_while_the_approach_is_on_hold_is_no_surface) {
  Touching b;
  if (HasFatalFailure()) return;
  b.z().set_contact(-1e9);
  b.go(-30);
  ASSERT_EQ(b.command({.kind = CommandKind::ArmProbe}), Fault::None);
  AxisVec to = b.now.target;
  to[2] = -36;
  b.begin_block(motion::probe_move(b.limits, b.now.target, to, b.machine.probe.speed_mm_s));
  ASSERT_TRUE(b.until([&] { return b.now.target[2] < -31; }, 2000));
  ASSERT_EQ(b.command({.kind = CommandKind::Hold, .value = 1}), Fault::None);
  ASSERT_TRUE(b.until([&] { return b.now.state == State::Held; }, 500));
  b.ticks(50);
  const double stood = b.now.target[2];
  b.z().set_contact(-20);
  ASSERT_TRUE(b.until([&] { return b.now.state == State::Ready; }, 500)) << "a path stop that needs no reset";
  EXPECT_EQ(b.told(Fault::ProbeImplausible), 1);
  EXPECT_EQ(b.now.target[2], stood);
  for (const cycle::Event& e : b.events) EXPECT_NE(e.kind, EventKind::Touched);
}

// docs/machine.md, `probe.speed`: it presses in by what it travels in 25 ms, and the braking distance. From v at rest
// with the jerk j it is v * sqrt(v / j) (the acceleration's limit is not reached).
TEST(Touch, a_closed_probe_that_does_not_latch_ends_the_approach_within_25_ms) {
  Touching b;
  if (HasFatalFailure()) return;
  const double v = b.machine.probe.speed_mm_s, j = b.limits.axis[b.machine.z.value].j_max;
  ASSERT_LT(std::sqrt(v * j), b.limits.axis[b.machine.z.value].a_max);
  constexpr double kPlane = -40;
  for (const std::uint16_t hides : {kStored, static_cast<std::uint16_t>(kStored | kEnabled)}) {
    SCOPED_TRACE(hides);
    b.bus.never_shows = 0;
    b.z().set_contact(-1e9);
    b.go(kPlane + 1);
    b.z().set_contact(kPlane);
    ASSERT_EQ(b.command({.kind = CommandKind::ArmProbe}), Fault::None);
    b.bus.never_shows = hides;
    EXPECT_FALSE(b.approach(kPlane - 5));
    EXPECT_EQ(b.told(Fault::ProbeStale), 1);
    EXPECT_EQ(b.told(Fault::ProbeNeverTriggered), 0);
    EXPECT_GT(b.now.target[2], kPlane - v * 0.025 - v * std::sqrt(v / j));
    if ((hides & kEnabled) != 0) {
      EXPECT_GT(b.now.target[2], kPlane + 0.9) << "its arming was gone at once";
    }
    EXPECT_EQ(b.now.state, State::Ready);
  }
}

// R50, R51: a drive that latches nonsense, or shows the latch of another touch.
TEST(Touch, a_latch_outside_of_what_was_approached_is_refused_and_ends_the_approach) {
  Touching b;
  if (HasFatalFailure()) return;
  const double counts_per_mm = b.machine.axes[b.machine.z.value].counts_per_unit;
  constexpr double kPlane = -40, kAbove = 2, kLowest = kPlane - 3;
  for (const double off_mm : {0.0, 2.5, 30.0, -0.5, -2.0, -5.0, 400.0, -1e5, 1e5}) {
    SCOPED_TRACE(off_mm);
    b.z().set_contact(-1e9);
    b.bus.off = {};
    b.go(kPlane + kAbove);
    b.z().set_contact(kPlane);
    b.bus.off = {static_cast<std::int64_t>(std::lround(off_mm * counts_per_mm))};
    const auto met = b.touch(kLowest);
    if (off_mm == 0) {
      ASSERT_TRUE(met);
      EXPECT_NEAR(*met, kPlane, 0.01);
      continue;
    }
    EXPECT_FALSE(met) << *met;
    EXPECT_EQ(b.told(Fault::ProbeImplausible), 1);
    EXPECT_GT(b.now.actual[b.machine.z.value], kPlane - 0.5) << "it ends where the probe has closed";
    for (const cycle::Event& e : b.events) EXPECT_NE(e.kind, EventKind::Touched);
  }
}

}  // namespace
}  // namespace gantry::test
