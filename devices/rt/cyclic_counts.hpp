// What became of frames, each counted as what it was: those of the cycles, or of a Link that sends by itself.
#pragma once
#include <cstdint>

namespace gantry::devices {

/// What became of frames and cycles since the start, each counted as what it was.
struct CyclicCounts {
  // Frames that were sent.
  std::uint64_t sent = 0;
  std::uint64_t not_sent = 0;  ///< refused by the port (no link, its queue is full)
  std::uint64_t lost = 0;      ///< did not come back in time, or were not sent
  // Frames that came in and were no answer.
  std::uint64_t late = 0;  ///< of an earlier cycle, where it counts as lost; or sent by somebody else for this master
  std::uint64_t duplicate = 0;  ///< a further copy of an answer that was taken already
  std::uint64_t foreign = 0;    ///< not EtherCAT, or of another master
  std::uint64_t malformed = 0;  ///< changed on the way
  std::uint64_t untouched =
      0;  ///< came back as they were sent: no station has seen them (a loop in the cabling, an echo)
  // Cycles whose frames came back.
  std::uint64_t wkc_zero = 0;  ///< nobody exchanged process data
  std::uint64_t wkc_low = 0;   ///< fewer stations than expected took part
  std::uint64_t wkc_high = 0;  ///< more

  /// What has come since `before`.
  [[nodiscard]] CyclicCounts operator-(const CyclicCounts& before) const noexcept {
    CyclicCounts since;
    since.sent = sent - before.sent;
    since.not_sent = not_sent - before.not_sent;
    since.lost = lost - before.lost;
    since.late = late - before.late;
    since.duplicate = duplicate - before.duplicate;
    since.foreign = foreign - before.foreign;
    since.malformed = malformed - before.malformed;
    since.untouched = untouched - before.untouched;
    since.wkc_zero = wkc_zero - before.wkc_zero;
    since.wkc_low = wkc_low - before.wkc_low;
    since.wkc_high = wkc_high - before.wkc_high;
    return since;
  }
  bool operator==(const CyclicCounts&) const = default;
};

}  // namespace gantry::devices
