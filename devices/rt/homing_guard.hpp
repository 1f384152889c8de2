// What the controller watches while a drive homes by itself, from what the drive shows of its own switches and counter:
// a limit that the method does not come to, both limits at once, a limit that opens although the axis goes on towards
// it (it is the other one's bit), a reference switch that does not open although the axis leaves it, more speed than
// was asked for. A drive that calls its homing done without its switch having been seen
// has not found it.
//   HomingGuard guard(rules, feedback);    each fresh cycle of the search: Fault f = guard.look(feedback);
//   at its end: guard.found_switch()
// Directions are those of the drive's own counter, as the methods are (IEC 61800-7-201, 10.4).
#pragma once
#include <cstdint>

#include "core/fault.hpp"
#include "devices/rt/drive.hpp"

namespace gantry::devices {

inline constexpr std::uint8_t kSwitchNeg = 1, kSwitchPos = 2, kSwitchHome = 4;

/// Switches that the drive shows closed.
std::uint8_t closed_switches(const Feedback& feedback) noexcept;

struct HomingRules {
  std::uint8_t known = 0;         ///< switches whose bits in 60FDh are known
  bool unseen_accepted = false;   ///< it homes although the drive shows no 60FDh; its switches are not watched then
  std::uint8_t may_meet = 0;      ///< limits on the method's way
  std::uint8_t reference = 0;     ///< what the method looks for; 0: homes where it stands, or at the index pulse
  int toward = 0;                 ///< where it looks for that from afar, in the drive's own counter: +1, -1; 0: nowhere
  int flickers_cycles = 3;        ///< so long a switch may seem closed that is not
  std::int64_t leave_counts = 0;  ///< within which a switch that is the reference opens again; 0: not watched
  /// Of which switches that holds. The cam of a home switch may be as long as the axis, unless all of it is beyond the
  /// end of the travel.
  std::uint8_t leaves = kSwitchNeg | kSwitchPos;
  std::int64_t leave_cycles = 0;  ///< and in so many cycles: a turned motor presses into its stop and goes nowhere
  double counts_per_cycle = 0;    ///< at the faster of its speeds; 0: not watched
};
/// Of the methods 1 to 37 of 6098h; `known`, `counts_per_cycle` and what is left of a limit are the caller's to set.
HomingRules homing_rules(int method) noexcept;

class HomingGuard {
 public:
  HomingGuard() = default;
  HomingGuard(const HomingRules& rules, const Feedback& feedback) noexcept;

  /// `elapsed`: cycles since the last call. Fault::HomingWrongLimit, HomingTooFast; HomingSwitchStuck: the reference
  /// switch does not open; SwitchesUnseen: 60FDh has fallen silent, or the station has none; None.
  Fault look(const Feedback& feedback, std::int64_t elapsed = 1) noexcept;
  /// The switch that the method looks for was closed at some time, or cannot be seen.
  [[nodiscard]] bool found_switch() const noexcept;

 private:
  [[nodiscard]] bool stuck(std::uint8_t now, Counts counts, std::int64_t elapsed) noexcept;
  [[nodiscard]] bool other_limit_opened(std::uint8_t now) const noexcept;

  HomingRules rules_;
  std::uint8_t stood_on_ = 0;  ///< limits that were closed when it began, until they open
  std::uint8_t leaving_ = 0;   ///< wrong ones of these
  std::uint8_t seen_ = 0;
  int wrong_ = 0;  ///< cycles in a row; an input that flickers is none
  Counts last_;
  std::int64_t gone_ = 0;           ///< counts since it began
  Counts closed_at_;                ///< where the reference switch closed, or was closed when it began
  std::int64_t closed_cycles_ = 0;  ///< since then; 0: it is open
  double travel_ = 0;               ///< counts in this window
  std::int64_t in_window_ = 0;
  bool was_fast_ = false;  ///< in the window before
  int sets_ = 0;
};

}  // namespace gantry::devices
