#include "devices/rt/probe.hpp"

#include <algorithm>

namespace gantry::devices {
namespace {

using namespace wire::cia402;

constexpr int kClearHold = 3;  // acknowledged cycles with 60B8h = 0, so that a lost frame does not swallow the edge
constexpr Time kAnswer = milliseconds(50);  // within which the drive must show what 60B8h asks for
// From the level to its latch, which come in one word: 25 ms of travel are promised (docs/machine.md, probe.speed), and
// the input comes in, and the stop goes out, by the axis's response delay later.
constexpr Time kLatch = milliseconds(15);

}  // namespace

void ProbeArm::start(ProbeEdge edge, Time cycle) noexcept {
  *this = ProbeArm{};
  answer_cycles_ = static_cast<int>(std::max<std::int64_t>(kAnswer / cycle, 2 * kClearHold));
  latch_cycles_ = static_cast<int>(kLatch / cycle);
  edge_ = edge;
  phase_ = Phase::Clearing;
}

void ProbeArm::fail(Fault fault) noexcept {
  phase_ = Phase::Failed;
  fault_ = fault;
}

std::uint16_t ProbeArm::step(const Feedback& f) noexcept {
  const bool rising = edge_ == ProbeEdge::Rising;
  const std::uint16_t on = kProbeEnable | (rising ? kProbeRisingEdge : kProbeFallingEdge);
  const std::uint16_t latch_bit = rising ? kProbeRisingLatched : kProbeFallingLatched;
  const bool latched = (f.probe_status & latch_bit) != 0;
  if (f.fresh) {
    ++cycles_;
    switch (phase_) {
      case Phase::Clearing:
        if (f.probe_level == rising) return fail(Fault::ProbeAlreadyActive), std::uint16_t{0};
        if (cycles_ > kClearHold && !latched && (f.probe_status & kProbeEnabled) == 0)
          phase_ = Phase::Arming, cycles_ = 0;
        else if (cycles_ > answer_cycles_)
          fail(Fault::ProbeStale);
        break;
      case Phase::Arming:  // nothing has moved yet: what is latched here is no touch
        if (latched)
          return fail(f.probe_level == rising ? Fault::ProbeAlreadyActive : Fault::ProbeStale), std::uint16_t{0};
        if ((f.probe_status & kProbeEnabled) != 0)
          phase_ = Phase::Armed, cycles_ = 0;
        else if (cycles_ > answer_cycles_)
          fail(Fault::ProbeStale);
        break;
      case Phase::Armed:
        if (latched) {
          latched_ = rising ? f.probe_rising : f.probe_falling;
          phase_ = Phase::Latched;
          break;
        }
        if (f.probe_level != rising) cycles_ = 0;
        if (cycles_ > latch_cycles_ || (f.probe_status & kProbeEnabled) == 0) fail(Fault::ProbeStale);
        break;
      case Phase::Idle:
      case Phase::Latched:
      case Phase::Failed: break;
    }
  }
  const bool hold = phase_ == Phase::Arming || phase_ == Phase::Armed || phase_ == Phase::Latched;
  return hold ? on : std::uint16_t{0};
}

}  // namespace gantry::devices
