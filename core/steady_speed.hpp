// Whether a bead goes at its speed where it is steady, from how far the needle comes in steps of time: the one measure
// of what is planned and of what a world has seen.
//   SteadySpeed judge({.mm_s = 20, .tolerance = 0.05}, 0.001);
//   for (...) judge.add(mm);
//   judge.end_stretch();   judge.within() < 0.5 || judge.held_mm_s()
// It looks at means over windows of 0.4 mm: there a motor's count of some micrometres is less than a hundredth.
#pragma once
#include <cstdint>
#include <deque>
#include <optional>

namespace gantry {

/// What a bead's material wants.
struct AskedSpeed {
  double mm_s = 0;          ///< 0: none
  double tolerance = 0.05;  ///< part of it
};

class SteadySpeed {
 public:
  static constexpr double kCreeps = 0.25;  ///< of what is asked for: from its speed to rest and back takes half of it

  /// `step_s`: > 0, and so is the speed that is asked for.
  SteadySpeed(AskedSpeed asked, double step_s);

  /// The needle came so far in so many steps.
  void add(double mm, std::uint32_t steps = 1);
  /// The valve has shut: what comes is another piece of the bead. To be called behind the last one, too.
  void end_stretch();

  [[nodiscard]] bool is_good(double mm_s) const;
  /// Share of the length that lies in a window whose mean is within the tolerance, 0..1.
  [[nodiscard]] double within() const { return all_mm_ > 0 ? good_mm_ / all_mm_ : 1; }
  /// Of the speeds that it kept for 50 ms, but for 2 %, or at which it crept, below a quarter of what is asked for in
  /// the mean from where it left its speed to where it had it again, 0.1 s and more, the one farthest from that;
  /// nothing where it kept none. Speeds within the tolerance and others are not one.
  [[nodiscard]] std::optional<double> held_mm_s() const { return held_mm_s_; }

 private:
  struct Run {
    double low = 0, high = 0;
    bool good = false;
    std::uint64_t steps = 0;
  };
  void step(double mm);
  void see(double mean_mm_s);
  void end_slow();
  void held(double mm_s);
  void leave_oldest();

  AskedSpeed asked_;
  double step_s_;
  std::size_t window_steps_;
  std::deque<double> window_;
  double sum_mm_ = 0;
  std::size_t good_left_ = 0;  ///< so many of the window, the oldest first, are in a good one
  Run run_;
  std::uint64_t slow_steps_ = 0;  ///< whose windows are too slow, one behind the other
  double slow_mm_ = 0;            ///< that the needle came in them
  double all_mm_ = 0, good_mm_ = 0;
  bool judged_ = false;  ///< in this stretch
  std::optional<double> held_mm_s_;
};

}  // namespace gantry
