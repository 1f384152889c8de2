#include "app/record/setpoint_hash.hpp"

#include <algorithm>
#include <fmt/format.h>

namespace gantry::record {

void SetpointHash::word(std::uint32_t value) noexcept {
  for (int shift = 0; shift < 32; shift += 8) hash_.add(static_cast<std::uint8_t>(value >> shift));
}

void SetpointHash::add(const cycle::Snapshot& s) noexcept {
  if (s.block == 0) {
    block_ = 0;
    return;
  }
  // A block starts at tick 1 and misses none; what follows a hole is still hashed, so that a reader may look further.
  const std::uint32_t expected = s.block == block_ ? tick_ + 1 : 1;
  if (s.tick != expected) complete_ = false;
  block_ = s.block;
  tick_ = s.tick;

  word(s.block);
  word(s.tick);
  const std::size_t drives = std::min<std::size_t>(s.drives, cycle::kMaxDrives);
  for (std::size_t i = 0; i < drives; ++i) word(static_cast<std::uint32_t>(s.counts[i]));
  word(s.outputs & kProcessOutputs);
  ++ticks_;
}

std::string hash_text(std::uint64_t hash) { return fmt::format("0x{:016x}", hash); }

}  // namespace gantry::record
