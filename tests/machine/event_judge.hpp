// What must hold in every cycle of a machine, whatever is asked of it and done to it, by what stands on the wire: the
// counts and outputs that went out, the statuswords, positions and inputs that came in. Of the loop it takes nothing
// but what it claims to be (a machine that says "held" has to stand); of the rest it knows what was asked and taken,
// and what the world has done to the drives.
//   Judge judge(machine);   judge.look(owner.latest());   in every cycle, and the notices below as things happen
//   if (!judge.broken().empty()) ...
#pragma once
#include <array>
#include <string>

#include "app/cycle/channels.hpp"
#include "config/machine.hpp"

namespace gantry::test {

class Judge {
 public:
  explicit Judge(const config::Machine& machine);

  /// The first thing that did not hold; empty: all did.
  [[nodiscard]] const std::string& broken() const { return broken_; }
  void blame(const cycle::Snapshot& s, const std::string& what);

  /// What may move axes until it has ended. `moves`: false for what never may (enable, disable, part removed).
  void begins(bool moves, CycleIndex now);
  void ended();
  void abort_taken(CycleIndex now);
  void resume_taken() { resetting_ = false; }
  void reset_taken() { resetting_ = true; }
  void reset_answered() { resetting_ = false; }
  /// The world takes torque from the drives of these axes, at some time up to `until`.
  void torque_taken(std::uint32_t axes, CycleIndex until);
  /// The world moves these axes, or lets them go, at some time up to `until`.
  void pushed(std::uint32_t axes, CycleIndex until);
  /// The stations of these axes are off the line, at some time up to `until`: what is sent does not reach them, what
  /// stands for them in a snapshot is of the past, and one that was dark comes back with another counter.
  void away(std::uint32_t axes, CycleIndex until);

  void look(const cycle::Snapshot& s);

 private:
  struct Drive {
    std::uint8_t axis = 0;
    double counts_per_unit = 1, v_max = 0;
    bool inverted = false;
    bool second = false;  ///< the other side of the drive before it
  };
  /// By its statusword: Operation Enabled, or braking by its own quick stop.
  static bool torque(std::uint16_t statusword);
  static bool enabled(std::uint16_t statusword);
  /// Of a target. It counts when the drive still has torque some reports later: its statusword is of before the frame
  /// that moved the target, and that frame may have taken its torque, which takes a drive some cycles.
  struct Suspicion {
    CycleIndex at = -1;
    int reports = 0;
    std::string what;
  };
  void suspect(const cycle::Snapshot& s, std::size_t drive, std::string what);
  void confirm(const cycle::Snapshot& s);
  void look_at_valve(const cycle::Snapshot& s);
  void look_at_motion(const cycle::Snapshot& s);
  void look_at_torque(const cycle::Snapshot& s);
  [[nodiscard]] bool excused(const std::array<CycleIndex, kMaxAxes>& until, std::size_t axis, CycleIndex now) const {
    return now <= until[axis];
  }

  const config::Machine& machine_;
  std::array<Drive, cycle::kMaxDrives> drives_{};
  std::size_t count_ = 0;
  cycle::Snapshot last_{};
  std::array<Suspicion, cycle::kMaxDrives> suspicions_{};
  AxisVec speed_{}, speed_before_{};  ///< by the positions that were reported, mm or rad a cycle
  AxisVec travelled_{};               ///< since what is under way began
  std::array<CycleIndex, kMaxAxes> taken_until_{}, pushed_until_{}, away_until_{};
  CycleIndex began_ = -1, aborted_at_ = -1, rests_since_ = 0, homed_at_ = -1, low_since_ = -1, torque_lost_ = -1;
  bool valve_ = false, holding_ = false;  ///< in the last cycle
  bool moves_ = false, resetting_ = false;
  std::string broken_;
};

}  // namespace gantry::test
