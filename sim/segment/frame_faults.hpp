// What goes wrong with frames on the cable: by count from a script, or at random from a seed. A frame whose bits are
// hit has a wrong FCS: stations behind that place count it and do not act on it, and it does not come back.
//   faults.lose(3);   faults.set_noise({.loss = 0.01, .seed = 7});
//   const FrameFate fate = faults.next(2 * stations);
#pragma once
#include <cstdint>

#include "core/clock.hpp"
#include "sim/random.hpp"

namespace gantry::sim {

/// Probabilities of a frame, independent of each other.
struct LineNoise {
  double loss = 0, corrupt = 0, header = 0, duplicate = 0, delay = 0, reorder = 0;
  Time delay_max = microseconds(2000);
  std::uint64_t seed = 1;
};

struct FrameFate {
  bool lost = false;
  int hit_at = -1;         ///< place on the way there and back where bits are hit; -1: nowhere
  bool header = false;     ///< a byte of the headers is wrong under a right FCS (a bad switch or driver)
  bool duplicate = false;  ///< it comes back twice
  bool held = false;       ///< it comes back behind the next one
  bool foreign = false;    ///< a frame of another master comes in behind it
  Time delay{};            ///< it comes back this much later
};

class FrameFaults {
 public:
  void lose(int frames) noexcept { lose_ += frames; }
  void corrupt(int frames) noexcept { corrupt_ += frames; }
  void corrupt_headers(int frames) noexcept { headers_ += frames; }
  void duplicate(int frames) noexcept { duplicate_ += frames; }
  void reorder(int frames) noexcept { reorder_ += frames; }
  void add_foreign(int frames) noexcept { foreign_ += frames; }
  void delay(int frames, Time by) noexcept { delay_ += frames, delay_by_ = by; }
  void set_noise(const LineNoise& noise) noexcept;

  /// What happens to the next frame; `places`: cables that it passes, there and back.
  FrameFate next(int places) noexcept;
  /// A uniform number below `n`, from the same seed.
  int below(int n) noexcept { return n > 0 ? static_cast<int>(random_.next() % static_cast<std::uint64_t>(n)) : 0; }

 private:
  int lose_ = 0, corrupt_ = 0, headers_ = 0, duplicate_ = 0, reorder_ = 0, delay_ = 0, foreign_ = 0;
  Time delay_by_{};
  LineNoise noise_;
  bool noisy_ = false;
  Random random_{1};
};

}  // namespace gantry::sim
