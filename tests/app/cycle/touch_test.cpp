// A plane at a known height is touched from many heights, at many places within a cycle: the probe's latch must tell it
// within a count and what the axis goes in one cycle. The judge is the coordinate at which the virtual motor meets it.
#include <algorithm>
#include <array>
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

/// The bus as it is, but for what the drive of the probe says that it has latched.
class OtherLatch final : public devices::FieldBus {
 public:
  OtherLatch(devices::FieldBus& bus, const cycle::DriveSetup& drive) : bus_(bus), drive_(drive) {}
  Counts off{};

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
  void play_block(std::vector<motion::Segment> segments) {
    ++block;
    for (motion::Segment& s : segments) {
      s.block = block;
      s.ends_block = &s == &segments.back();
      ASSERT_TRUE(channels->segments.push(s));
    }
    events.clear();
    ASSERT_EQ(command({.kind = CommandKind::StartBlock, .block = block}), Fault::None);
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
