// Tells another master on the line from a frame whose header was changed on the way: a master sends on and on, so that
// it is known by its third frame.
//   senders.heard(address, sequence);   if (senders.other()) ...
// Lives in the RT loop.
#pragma once
#include <array>
#include <cstdint>
#include <optional>

#include "devices/frame_port.hpp"

namespace gantry::devices {

/// Another master on the same line.
struct OtherMaster {
  MacAddress address{};      ///< the last one's, as it came (stations set bit 1 of the first byte)
  std::uint64_t frames = 0;  ///< of all that are known
  bool operator==(const OtherMaster&) const = default;
};

class SenderWatch {
 public:
  static constexpr std::uint32_t kEnough = 3;    ///< frames from one address ...
  static constexpr std::uint32_t kAmong = 1000;  ///< ... while this many of our own go out

  /// A frame came in that is not of this master; `sequence` is that of our own last frame.
  void heard(const MacAddress& sender, std::uint32_t sequence) noexcept;
  [[nodiscard]] const std::optional<OtherMaster>& other() const noexcept { return other_; }

 private:
  struct Row {
    MacAddress sender{};
    std::uint32_t first = 0, last = 0;  ///< our sequence then
    std::uint32_t frames = 0;           ///< since `first`; 0: the row is free
    bool known = false;
  };
  [[nodiscard]] Row& row_of(const MacAddress& sender, std::uint32_t sequence) noexcept;

  std::array<Row, 8> rows_{};
  std::optional<OtherMaster> other_;
};

}  // namespace gantry::devices
