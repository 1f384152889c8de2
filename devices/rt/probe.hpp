// Arms a drive's probe input 1 ("touch probe 1" in CiA 402) and makes sure that what it latched is new. 60B8h works by
// edges (bit 0 starts; AMD530B wants 0 before a new value, manual 7.2; the others a new edge of bit 0), so every
// probing begins with 0, seen over acknowledged cycles, and the old latch must be seen to vanish before a new one
// counts (R49, R51).
//   probe.start(ProbeEdge::Rising, cycle);
//   command.probe_function = probe.step(drive.feedback());      // every cycle
//   if (probe.phase() == ProbeArm::Phase::Latched) ... probe.latched()
// Pure state; lives in the RT loop.
#pragma once
#include <cstdint>

#include "core/clock.hpp"
#include "core/fault.hpp"
#include "core/id.hpp"
#include "devices/rt/drive.hpp"

namespace gantry::devices {

enum class ProbeEdge : std::uint8_t { Rising, Falling };

class ProbeArm {
 public:
  enum class Phase : std::uint8_t {
    Idle,
    Clearing,  ///< 60B8h = 0 until the drive shows no latch
    Arming,    ///< waits for the drive to show "enabled"
    Armed,     ///< motion may begin, and goes on: a closed probe that does not latch, or an arming that is gone, fails
    Latched,
    Failed,  ///< fault(): ProbeAlreadyActive, ProbeStale
  };

  /// `cycle`: of the machine, for the time within which the drive has to answer.
  void start(ProbeEdge edge, Time cycle) noexcept;
  void stop() noexcept { *this = ProbeArm{}; }
  /// One cycle; the value for 60B8h.
  std::uint16_t step(const Feedback& feedback) noexcept;

  [[nodiscard]] Phase phase() const noexcept { return phase_; }
  [[nodiscard]] Fault fault() const noexcept { return fault_; }
  /// Counts at the edge, once Latched; AxisScale makes a coordinate of them.
  [[nodiscard]] Counts latched() const noexcept { return latched_; }

 private:
  void fail(Fault fault) noexcept;

  Phase phase_ = Phase::Idle;
  ProbeEdge edge_ = ProbeEdge::Rising;
  Fault fault_ = Fault::None;
  int cycles_ = 0;         ///< acknowledged cycles in this phase; once Armed, in a row in which the level was active
  int answer_cycles_ = 0;  ///< of them, within which the drive must show what 60B8h asks for
  int latch_cycles_ = 0;   ///< of them, within which an active level must have latched
  Counts latched_;
};

}  // namespace gantry::devices
