// Whether a bead goes at its speed where it is steady, from how far the needle comes in steps of time: the one measure
// of what is planned and of what a world has seen.
//   SteadySpeed judge({.mm_s = 20, .tolerance = 0.05, .a_max = 4000, .j_max = 80000}, 0.001);
//   for (...) judge.add(mm);
//   judge.end_stretch();   judge.within() < SteadySpeed::kEnough || judge.held_mm_s() || judge.sag()
// It looks at means over windows of 0.4 mm at the speed that is asked for: there a motor's count of some micrometres is
// less than a hundredth. (8 steps at least, and 400 at most: a bead slower than 1 mm/s is seen over 0.4 s.)
#pragma once
#include <cstdint>
#include <deque>
#include <optional>

namespace gantry {

/// What a bead's material wants, and how fast the axes may change it.
struct AskedSpeed {
  double mm_s = 0;              ///< 0: none
  double tolerance = 0.05;      ///< part of it
  double a_max = 0, j_max = 0;  ///< of the slowest axis, mm/s^2 and mm/s^3; 0: not known, and nothing is a sag
};

/// Where it was too slow for longer than a corner makes it.
struct Sag {
  double low_mm_s = 0;  ///< that it came down to
  double lasts_s = 0;
};

class SteadySpeed {
 public:
  static constexpr double kEnough = 0.5;   ///< of a bead's length is to be at its speed
  static constexpr double kCreeps = 0.25;  ///< of what is asked for: from its speed to rest and back takes half of it

  /// `step_s`: > 0, and so is the speed that is asked for. `strictly`: 1, or more: what is let pass by a hair is not.
  SteadySpeed(AskedSpeed asked, double step_s, double strictly = 1);

  /// The needle came so far in so many steps.
  void add(double mm, std::uint32_t steps = 1);
  /// The valve has shut: what comes is another piece of the bead. To be called behind the last one, too.
  void end_stretch();

  [[nodiscard]] bool is_good(double mm_s) const;
  /// Share of the length that lies in a window whose mean is within the tolerance, 0..1.
  [[nodiscard]] double within() const { return all_mm_ > 0 ? good_mm_ / all_mm_ : 1; }
  /// The speed farthest from what is asked for of those
  /// - that it kept, but for 2 %, for 50 ms and for two windows (a speed that crosses the tolerance is not kept);
  /// - at which it crept: below a quarter of what is asked for, in the mean from where it left its speed to where it
  /// had
  ///   it again, 0.1 s and more.
  [[nodiscard]] std::optional<double> held_mm_s() const { return held_mm_s_; }
  /// The longest time from where it left its speed to where it had it again, of those that are longer by 50 ms and a
  /// window than one and a half times what the axes need to come down so far, and up again: longer than a corner makes
  /// it. Where it comes three quarters of the way back to its speed in between, it may come down, and up, once more.
  [[nodiscard]] std::optional<Sag> sag() const { return sag_; }

 private:
  struct Run {
    double low = 0, high = 0;
    bool good = false;
    std::uint64_t steps = 0;
  };
  /// From a high speed over the lowest one to the next high one, which is near to what is asked for.
  struct Dip {
    double from = 0, low = 0, up_to = 0;
    std::uint64_t steps = 0;
  };
  /// All of them from where it left its speed to where it had it again.
  struct Dips {
    double needed_s = 0;
    double most_s = 0, low_mm_s = 0;  ///< of the one that lasted longest beyond what it needed
  };
  void step(double mm);
  void see(double mean_mm_s);
  void dip(double mean_mm_s);
  void end_dip();
  void end_slow();
  void held(double mm_s);
  void leave_oldest();
  [[nodiscard]] double window_s() const { return static_cast<double>(window_steps_) * step_s_; }

  AskedSpeed asked_;
  double step_s_, strictly_;
  std::size_t window_steps_;
  std::deque<double> window_;
  double sum_mm_ = 0;
  std::size_t good_left_ = 0;  ///< so many of the window, the oldest first, are in a good one
  Run run_;
  std::uint64_t slow_steps_ = 0;  ///< whose windows are too slow, one behind the other
  double slow_mm_ = 0;            ///< that the needle came in them
  Dip dip_;
  Dips dips_;
  double all_mm_ = 0, good_mm_ = 0;
  bool judged_ = false;  ///< in this stretch
  std::optional<double> held_mm_s_;
  std::optional<Sag> sag_;
};

}  // namespace gantry
