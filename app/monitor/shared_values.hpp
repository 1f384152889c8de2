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
  /// By their bits in the loop's words; "": nothing of the machine.
  std::array<Text<32>, 32> output{}, input{};
};

/// A cycle, and when it was written: by the wall clock (ns since 1970) for people, by CLOCK_MONOTONIC for its age.
struct SharedSnapshot {
  cycle::Snapshot snapshot;
  std::int64_t wall_ns = 0, monotonic_ns = 0;
};

/// Whose an event is.
enum class Told : std::uint8_t {
  Machine,  ///< as `event` says
  Action,   ///< somebody has given an order, or pressed a button
  Part,     ///< the job on a part begins, or has come to its result
};

struct SharedEvent {
  cycle::Event event;
  std::int64_t wall_ns = 0;
  Told told = Told::Machine;
  std::uint32_t count = 1;  ///< so often it came since it was last told
  Text<256> text;           ///< what the owner knows beyond the catalogue: the drive's own words, a command's name
};

struct SharedAlarm {
  Fault fault = Fault::None;
  std::int64_t since_ns = 0;  ///< by the wall clock
  Text<96> where;
  Text<256> text;
};

/// What is wrong with the machine now, the latched fault first.
struct SharedAlarms {
  static constexpr std::size_t kMost = 16;  ///< more are not told
  std::uint64_t version = 0;                ///< another number: something has changed
  std::uint32_t count = 0;
  std::array<SharedAlarm, kMost> alarms{};
};

struct SharedJob {
  Text<64> job, recipe;
  Text<32> state;  ///< as in the topic (idl/gantry_topics.idl)
  std::uint32_t blocks_done = 0, blocks_total = 0, features_done = 0, features_total = 0;
  double elapsed_s = 0, predicted_s = 0;
  double remaining_s = -1;  ///< below 0: not known
  Text<256> message;
};

}  // namespace gantry::monitor
