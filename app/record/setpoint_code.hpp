// How a stream of ticks is kept short: what a tick shares with the one before is left out, and a drive's counts are
// told as what they differ by from going on evenly. All lengths are varints (7 bits a byte, the lowest first, bit 7:
// more); signed ones are zigzag (0, -1, 1, -2 ... as 0, 1, 2, 3 ...).
//   SetpointEncoder encoder;   encoder.add(tick, bytes); ...   encoder.end(bytes);
//   decode(bytes, drives, take);
// A record begins with a byte:
//   0x80              a varint n follows: n ticks as foreseen
//   0x01 | 2 | 4 | 8  a tick; 0x01: it was sent; then, of those whose bit is set, 0x02 block, 0x04 tick, 0x08 outputs;
//                     then a varint with bit i set for each drive that is not as foreseen, and of each by how much
// Foreseen is: the same block, outputs and sent as before, the next tick, counts 2 c(n-1) - c(n-2). Before the first
// tick all is 0.
#pragma once
#include <array>
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>

#include "app/cycle/channels.hpp"

namespace gantry::record {

struct SetpointTick {
  std::uint32_t block = 0, tick = 0, outputs = 0;
  bool sent = false;
  std::array<std::int32_t, cycle::kMaxDrives> counts{};
};

class SetpointEncoder {
 public:
  explicit SetpointEncoder(std::uint32_t drives) : drives_(drives) {}

  /// Appends to `bytes`, or keeps the tick back for a longer run.
  void add(const SetpointTick& tick, std::string& bytes);
  /// What was kept back.
  void end(std::string& bytes);

 private:
  std::uint32_t drives_;
  SetpointTick last_, before_;  ///< of the latter the counts
  std::uint64_t run_ = 0;
};

/// Gives all whole ticks to `take`, until it says no; a last record that is not whole is left out. False: this is no
/// such stream.
bool decode(std::string_view bytes, std::uint32_t drives, const std::function<bool(const SetpointTick&)>& take);

}  // namespace gantry::record
