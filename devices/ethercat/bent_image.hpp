// The process image of a station whose mapping is not its profile's (pdo_agreement.hpp), or whose profile has other
// sizes than the loop. The loop sees the profile's image with its own sizes (loop_rows()): here it is copied object by
// object to where the station has it, with the station's sizes, and back. What no PDO carries goes by SDO, value by
// value, through SlowValue.
//   BentImage image(station);
//   image.to_wire(wire_outputs); ... image.from_wire(wire_inputs, fresh);   // each cycle: no allocation, no lock
//   serve_slow_objects(link, station, image);                               // run thread (slow_objects.hpp)
#pragma once
#include <atomic>
#include <cstdint>
#include <deque>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "devices/ethercat/station.hpp"
#include "devices/input_source.hpp"
#include "devices/profiles/map_pdos.hpp"

namespace gantry::devices {

/// Between the loop, which has it in its image, and the run thread, which has the mailbox.
struct SlowValue {
  SlowObject object;
  std::uint32_t bit = 0;                ///< in the loop's image
  std::atomic<std::uint32_t> value{0};  ///< an output as the loop wants it, an input as the station has shown it
  std::atomic<std::uint32_t> looks{0};  ///< that gave an input; 0: not yet, or not since the station was away
  // the loop's
  std::uint32_t looks_seen = 0;
  std::int64_t old_cycles = 0;  ///< since the last look that gave it
  // the run thread's
  std::optional<Time> unanswered_since;  ///< the first of the looks in a row that gave nothing
  bool silent = false, answers = true;
  std::uint32_t sent = 0;  ///< the output that the station has
  bool sent_once = false;
  Time not_before{};
  std::string refusal, refusal_told;  ///< why an output was not taken; empty: it was
};

/// After so long without an answer an input that is polled is not known any more.
inline constexpr Time kSilentAfter = milliseconds(500);

class BentImage {
 public:
  BentImage(const StationRecord& station, Time cycle);

  [[nodiscard]] std::span<std::byte> outputs() noexcept { return outputs_; }
  [[nodiscard]] std::span<const std::byte> inputs() const noexcept { return inputs_; }
  [[nodiscard]] std::deque<SlowValue>& slow() noexcept { return slow_; }

  /// Outputs that the loop does not know, into a wire image of zeros: what the station has there.
  void begin_wire(std::span<std::byte> wire) const noexcept;
  void to_wire(std::span<std::byte> wire) noexcept;
  void from_wire(std::span<const std::byte> wire, bool fresh) noexcept;
  [[nodiscard]] InputSource source(config::ObjectAddress input) const noexcept;

  // Outputs that are made beside the loop's own: a copy of these, changed and copied to a wire image of their own.
  void begin_spare() noexcept;
  [[nodiscard]] std::span<std::byte> spare() noexcept { return spare_; }
  void spare_to_wire(std::span<std::byte> wire) const noexcept;

 private:
  struct Copy {
    std::uint32_t from = 0, to = 0;  ///< first bits
    std::uint8_t from_bits = 0, to_bits = 0;
    bool has_sign = false;
  };
  static Copy copy_of(const MappedBits& from, const MappedBits& to, bool has_sign);
  static void copy(const std::vector<Copy>& copies, std::span<const std::byte> from, std::span<std::byte> to) noexcept;

  std::vector<std::byte> outputs_, inputs_, spare_;  ///< as the loop has them
  std::vector<Copy> out_, in_;
  std::vector<ForeignOutput> foreign_;
  std::deque<SlowValue> slow_;
  std::vector<config::ObjectAddress> absent_;  ///< inputs of the profile that the station does not show
  std::int64_t silent_cycles_ = 0;
};

}  // namespace gantry::devices
