// What lies in the memory that the owner of the machine shares with its publisher: plain values, nothing else.
#pragma once
#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <string_view>

#include "app/cycle/channels.hpp"

namespace gantry::monitor {

/// Text of a bounded length, always ended by 0; what does not fit is cut between characters.
template <std::size_t N>
struct Text {
  char chars[N]{};
  Text() = default;
  Text(std::string_view s) { *this = s; }  // NOLINT: text is assigned from text
  Text& operator=(std::string_view s) {
    std::size_t n = std::min(s.size(), N - 1);
    while (n > 0 && n < s.size() && (static_cast<unsigned char>(s[n]) & 0xC0u) == 0x80u) --n;
    std::memset(chars, 0, N);
    if (n > 0) std::memcpy(chars, s.data(), n);  // an empty view may point nowhere
    return *this;
  }
  [[nodiscard]] const char* c_str() const { return chars; }
  [[nodiscard]] std::string_view view() const { return chars; }
};

/// What does not change while the owner lives.
struct MachineInfo {
  struct Axis {
    Text<32> name;
    bool rotary = false;
  };
  Text<32> name;
  std::uint32_t axes = 0;
  std::array<Axis, kMaxAxes> axis{};
};

/// A cycle, and when it was written: by the wall clock (ns since 1970) for people, by CLOCK_MONOTONIC for its age.
struct SharedSnapshot {
  cycle::Snapshot snapshot;
  std::int64_t wall_ns = 0, monotonic_ns = 0;
};

struct SharedEvent {
  cycle::Event event;
  std::int64_t wall_ns = 0;
  Text<256> text;  ///< what the owner knows beyond the catalogue: the drive's own words, a command's name
};

struct SharedJob {
  Text<64> job, recipe;
  Text<32> state;  ///< "idle", "running", "held", "done", "failed", "interrupted"
  std::uint32_t blocks_done = 0, blocks_total = 0, features_done = 0, features_total = 0;
  double elapsed_s = 0, predicted_s = 0;
  Text<256> message;
};

}  // namespace gantry::monitor
