// How long a client waits for a sign of life of its owner. An order may take as long as it takes, as long as something
// is heard; an owner that says nothing for 5 s does not answer.
//   Patience patience(clock);   each turn: if (line) patience.heard();   if (patience.over()) ...
#pragma once
#include <algorithm>

#include "core/clock.hpp"

namespace gantry::desk {

class Patience {
 public:
  static constexpr Time kSilence = std::chrono::seconds(5);
  /// Of one turn no more than this counts: where a turn took longer, this program stood still (Ctrl-Z, a busy host),
  /// and could not hear.
  static constexpr Time kTurn = milliseconds(100);

  explicit Patience(const Clock& clock) : clock_(clock), turn_(clock.now()) {}
  void heard() { silence_ = Time(0); }
  /// Once a turn.
  [[nodiscard]] bool over() {
    const Time now = clock_.now();
    silence_ += std::min(now - turn_, kTurn);
    turn_ = now;
    return silence_ >= kSilence;
  }

 private:
  const Clock& clock_;
  Time turn_, silence_{};
};

}  // namespace gantry::desk
