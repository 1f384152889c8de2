// What makes two runs of one job comparable: a hash over the stream of commanded setpoints, as docs/monitoring.md and
// the design define determinism. It covers block, tick in the block, the counts of all drives and the process outputs
// of every cycle that belongs to a block; idle cycles between blocks (waiting for an image, for the operator) do not
// count, because their number depends on the host.
//   SetpointHash h;   h.add(snapshot);   h.value();   h.ticks();   h.complete();
// FNV-1a, 64 bit, over the bytes of each tick in little-endian order: block u32, tick u32, counts i32 a drive, outputs
// u32.
#pragma once
#include <cstdint>
#include <string>

#include "app/cycle/channels.hpp"
#include "config/machine.hpp"
#include "core/fnv.hpp"

namespace gantry::record {

/// Outputs that make the job: what they are in a tick is decided by planned motion or before the block starts. Stack
/// lights and the healthy pulse talk to people at times of their own and are left out.
inline constexpr std::uint32_t kProcessOutputs =
    config::bit(config::Output::Valve) | config::bit(config::Output::CameraTrigger) |
    config::bit(config::Output::CameraLight) | config::bit(config::Output::Clamp);

class SetpointHash {
 public:
  void add(const cycle::Snapshot& snapshot) noexcept;
  [[nodiscard]] std::uint64_t value() const noexcept { return hash_.value(); }
  /// How many ticks the hash covers.
  [[nodiscard]] std::uint64_t ticks() const noexcept { return ticks_; }
  /// False when ticks are missing (lost snapshots): the hash then says nothing.
  [[nodiscard]] bool complete() const noexcept { return complete_; }

 private:
  void word(std::uint32_t value) noexcept;

  Fnv1a hash_;
  std::uint64_t ticks_ = 0;
  std::uint32_t block_ = 0, tick_ = 0;
  bool complete_ = true;
};

/// "0x0123456789abcdef"
std::string hash_text(std::uint64_t hash);

}  // namespace gantry::record
