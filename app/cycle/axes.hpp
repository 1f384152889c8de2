// All axes with their drives, as one thing the loop reads and writes. A gantry axis is two drives of one coordinate;
// both get the same target (but for what they stood apart when they took torque, lean.hpp), and its position is their
// mean.
//   axes.read(bus, answered, operational, elapsed);   ...   axes.write(bus, targets, elapsed);
// Also here: what the drives are asked to be (goal), their homing, and the probe on one of them. RT.
#pragma once
#include <array>
#include <bitset>
#include <cstdint>

#include "app/cycle/channels.hpp"
#include "app/cycle/lean.hpp"
#include "app/cycle/loop_setup.hpp"
#include "app/cycle/sent_targets.hpp"
#include "app/cycle/squaring.hpp"
#include "devices/bus.hpp"
#include "devices/rt/drive.hpp"
#include "devices/rt/homing.hpp"
#include "devices/rt/probe.hpp"

namespace gantry::cycle {

constexpr bool has_torque(devices::DriveState s) noexcept {
  using S = devices::DriveState;
  return s == S::OperationEnabled || s == S::QuickStopActive || s == S::FaultReaction;
}

class Axes {
 public:
  explicit Axes(const LoopSetup& setup) noexcept;

  /// `answered`: the frames came back, so that a station whose inputs are stale did not take part. `operational`: all
  /// that did take part say that they are. `elapsed`: cycles since the last call.
  void read(const devices::FieldBus& bus, bool answered, bool operational, std::int64_t elapsed) noexcept;
  /// `elapsed` as for read().
  void write(devices::FieldBus& bus, const AxisVec& target, std::int64_t elapsed) noexcept;

  /// A new goal holds for drives that were away or have dropped out, too: enabling them again is the operator's.
  void set_goal(devices::DriveGoal goal) noexcept {
    goal_ = goal;
    let_stop_ = stops_with_side_ = stands_with_side_ = runs_out_with_side_ = 0;
    away_.fill(0);
    dropped_.reset();
  }
  [[nodiscard]] devices::DriveGoal goal() const noexcept { return goal_; }
  /// Bit d: drive d has torque, and what a quick stop does to it is not known. With the goal QuickStop it goes on
  /// taking targets, until another goal takes its torque.
  [[nodiscard]] std::uint32_t braked_by_targets() const noexcept;
  /// With the goal QuickStop: drives that are not in `standing` were told to quick-stop, and nothing enables them
  /// again.
  void stand_only(std::uint32_t standing) noexcept { let_stop_ = ~standing; }
  /// The drive has torque and was not heard to stand.
  [[nodiscard]] bool moves(std::size_t d) const noexcept {
    return cycle::has_torque(drives_[d].feedback().state) && still_[d] < stands_cycles_;
  }
  /// Since it brakes by itself, mm or rad.
  [[nodiscard]] double gone(std::size_t d) const noexcept { return braking_[d].gone(); }
  /// Every drive that has torque was heard, for a while, to stand.
  [[nodiscard]] bool standing() const noexcept;
  /// All drives of the axis have torque.
  [[nodiscard]] bool has_torque(AxisId id) const noexcept;
  /// Every drive of a streamed axis takes targets.
  [[nodiscard]] bool all_enabled() const noexcept;
  /// No drive has torque.
  [[nodiscard]] bool all_disabled() const noexcept;
  /// It was enabled, shows no fault and has left Operation Enabled unasked (its station was out of OP, or its own
  /// input disabled it). It stays without torque until the next goal.
  [[nodiscard]] bool dropped(std::size_t d) const noexcept { return dropped_[d]; }
  /// No drive is in a fault.
  [[nodiscard]] bool no_fault() const noexcept;
  [[nodiscard]] bool enabled(AxisId id) const noexcept;
  [[nodiscard]] std::uint32_t enabled_mask() const noexcept;

  /// Where the drives were last sent: what bumpless motion starts from. Of an axis with two, those that take targets
  /// count: one without torque must not draw the other one along.
  [[nodiscard]] AxisVec commanded() const noexcept;
  [[nodiscard]] const AxisVec& actual() const noexcept { return actual_; }
  [[nodiscard]] double speed(AxisId id) const noexcept { return speed_[id.value]; }  ///< of the target, per s
  /// Target minus actual, of the drive that is farther off. Only where measures_following().
  [[nodiscard]] double following(AxisId id, double target) const noexcept;
  [[nodiscard]] bool measures_following(AxisId id) const noexcept;
  /// The same of what was last sent, but 0 wherever the drive may be because it catches up after a stall of the host,
  /// for as long as the axis may take by its window.
  [[nodiscard]] double behind(AxisId id) const noexcept;
  /// Of open-loop drives, whose position is the command as they carry it out: how far one is from every target that it
  /// may still be on its way to. Tells of one that stops short, and nothing of lost steps.
  [[nodiscard]] double stops_short(AxisId id) const noexcept;
  [[nodiscard]] double skew(AxisId id) const noexcept;
  /// An axis whose drives brake by themselves and do not: one has gone farther than it may take (NotBraking), or the
  /// sides have come apart (GantrySkew). Told in one cycle; from then on those that brake by themselves are to give up
  /// their torque, and the brake closes, where the axis has one.
  struct Unbraked {
    Fault fault = Fault::None;
    double by = 0;                   ///< mm or rad: how far it has gone, or its sides are farther apart than before
    StationId station = kNoStation;  ///< of the drive
  };
  [[nodiscard]] const Unbraked& unbraked(AxisId id) const noexcept { return unbraked_[id.value]; }
  [[nodiscard]] bool on_limit(AxisId id) const noexcept;
  /// kNoAxis: none stands on a limit switch.
  [[nodiscard]] AxisId first_on_limit() const noexcept;
  /// All inputs of the axis's drives are of the last cycle.
  [[nodiscard]] bool fresh(AxisId id) const noexcept;
  [[nodiscard]] const devices::Feedback& drive(std::size_t d) const noexcept { return drives_[d].feedback(); }
  [[nodiscard]] std::int32_t sent_counts(std::size_t d) const noexcept {
    return devices::wrap(drives_[d].commanded_counts());
  }

  /// What would have been sent for `target` in a cycle that a stall skipped.
  [[nodiscard]] std::int32_t counts_of(std::size_t d, const AxisVec& target) const noexcept {
    return drive(d).takes_targets
               ? devices::wrap(drives_[d].scale().to_counts(target[setup_.drives[d].axis.value] + lean(d)))
               : sent_counts(d);
  }

  /// Homing of the axes in `mask`, together, and squaring of those with two sides. Then homing() until it is over.
  void start_homing(std::uint32_t mask, const devices::FieldBus& bus) noexcept;
  void cancel_homing(Fault why) noexcept;
  /// Every cycle while homing(): axes whose sides have both arrived begin to be squared.
  void follow_homing() noexcept;
  [[nodiscard]] bool homing() const noexcept;
  struct Homed {
    Fault fault = Fault::None;  ///< the first failure, and its axis
    AxisId axis = kNoAxis;
    std::int32_t detail = 0;         ///< in the unit of the fault: how far sides are apart, or what the drive shows
    StationId station = kNoStation;  ///< of the drive that shows it, or of the side of a beam that gave up first
  };
  /// Of an axis that has given up, while the others may still be homing.
  [[nodiscard]] Homed homing_failure() const noexcept;
  /// After homing() turned false: sets the references of the axes that have arrived.
  Homed finish_homing() noexcept;
  /// Of the last homing: how much farther one side of the axis went to its switch than the other, mm.
  [[nodiscard]] double apart_in_homing(AxisId axis) const noexcept { return farther_[axis.value]; }
  [[nodiscard]] std::uint32_t referenced() const noexcept { return referenced_; }
  /// Every streamed axis has been homed.
  [[nodiscard]] bool all_referenced() const noexcept;
  void forget_reference(AxisId id) noexcept { referenced_ &= ~(1u << id.value); }

  [[nodiscard]] devices::ProbeArm& probe() noexcept { return probe_; }
  [[nodiscard]] const devices::ProbeArm& probe() const noexcept { return probe_; }
  /// Coordinate at which the probe latched.
  [[nodiscard]] double probe_position() const noexcept;

 private:
  [[nodiscard]] bool stops_by_itself(std::size_t d) const noexcept {
    return setup_.axes[setup_.drives[d].axis.value].quick_stop_brakes;
  }
  [[nodiscard]] devices::DriveGoal goal_of(std::size_t d) const noexcept;
  [[nodiscard]] std::size_t probe_drive() const noexcept;
  void share_coordinate(AxisId id) noexcept;
  void see_lean(AxisId id) noexcept;
  /// Of its drive from the axis's coordinate, mm or rad; 0 but for a beam that stands racked.
  [[nodiscard]] double lean(std::size_t d) const noexcept {
    const AxisId id = setup_.drives[d].axis;
    const auto& drives = setup_.axes[id.value].drives;
    return drives.size() < 2 ? 0 : lean_[id.value].of(drives[1] == d ? 1 : 0);
  }
  void stop_together(AxisId id, bool operational) noexcept;
  void run_out_together(AxisId id) noexcept;
  void watch_braking(AxisId id) noexcept;
  [[nodiscard]] bool stops_homing(std::size_t d) const noexcept;
  /// What the drive went until it was heard last, mm or rad.
  [[nodiscard]] double step(std::size_t d) const noexcept {
    return static_cast<double>(step_counts_[d]) / drives_[d].scale().to_counts_delta(1);
  }
  [[nodiscard]] std::bitset<kMaxDrives> may_search() const noexcept;
  void end_together(std::size_t axis) noexcept;
  void watch_sides(std::size_t axis) noexcept;
  void square_homed(std::size_t axis) noexcept;
  void join(AxisId id, bool second_moves_over) noexcept;

  const LoopSetup& setup_;
  std::array<devices::Drive, kMaxDrives> drives_;
  std::array<devices::HomingRun, kMaxDrives> homing_;
  devices::ProbeArm probe_;
  devices::DriveGoal goal_ = devices::DriveGoal::Disabled;
  AxisVec actual_{}, speed_{}, last_target_{};
  SentTargets sent_;
  std::uint32_t homing_mask_ = 0, referenced_ = 0;
  std::array<Squaring, kMaxAxes> squaring_{};  ///< of the second side, since homing began
  std::array<Lean, kMaxAxes> lean_{};
  AxisVec apart_{};                             ///< of two sides, as homing has seen them, mm
  AxisVec farther_{};                           ///< of the last homing: that one side went than the other, mm
  std::array<StationId, kMaxAxes> ended_by_{};  ///< of a beam's homing: the station of the side that gave up first
  std::array<int, kMaxDrives>
      away_{};  ///< cycles in which its station did not take part, up to counter_low_max: it was lost then
  std::bitset<kMaxDrives> dropped_;
  std::uint32_t let_stop_ = 0;  ///< drives that quick-stop whatever is known of that
  // Drives that do as the other side of their axis:
  std::uint32_t stops_with_side_ = 0;     ///< quick-stop, because it has lost its torque
  std::uint32_t stands_with_side_ = 0;    ///< stand at their last target, because it has left the line
  std::uint32_t runs_out_with_side_ = 0;  ///< have no torque, because it runs out without
  std::uint32_t let_go_ = 0;              ///< give up their torque until they have, because their axis does not brake
  std::array<OwnBraking, kMaxDrives> braking_{};         ///< by itself
  std::bitset<kMaxDrives> own_ramp_;                     ///< of its homing, which nobody knows: it has no 609Ah
  std::bitset<kMaxDrives> stopped_homing_;               ///< in the cycle before
  std::bitset<kMaxAxes> not_braked_;                     ///< told, until it is over
  std::array<Unbraked, kMaxAxes> unbraked_{};            ///< of the last cycle
  std::array<double, kMaxAxes> apart_before_{};          ///< how far two sides were when they began to brake
  std::array<std::int64_t, kMaxDrives> step_counts_{};   ///< of the last cycle
  std::array<std::int64_t, kMaxDrives> unheard_{};       ///< cycles since it was heard last
  std::array<std::int64_t, kMaxDrives> apart_cycles_{};  ///< that step_counts_ is of
  std::array<std::int64_t, kMaxDrives> since_gap_{};     ///< cycles in a row in which it was heard
  std::array<double, kMaxDrives> outran_{};              ///< mm or rad that it went farther than the other side
  int stands_cycles_;                                    ///< after which a drive stands
  std::array<int, kMaxDrives> still_{};                  ///< cycles in a row in which it was heard to stand
};

}  // namespace gantry::cycle
