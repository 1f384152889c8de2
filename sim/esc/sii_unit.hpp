// The SII EEPROM of one station and the interface through which the bus reads and writes it: registers 0500h to 050Fh
// (ETG.1000.4, 6.4; ESC data sheet II, 2.9). Commands take time; while busy, registers do not take another one.
//   sii.write(0x502, bytes, now);      // as the bus writes; false: nothing was taken
//   sii.show(registers, now);          // the 16 bytes as they stand now
//   sii.word(4)                        // what the ESC itself loads at power-on
// No allocation after construction.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/clock.hpp"
#include "sim/esc/timing.hpp"

namespace gantry::sim {

class SiiUnit {
 public:
  static constexpr std::size_t kRegisterBytes = 16;

  /// `image`: the content; it is what a station keeps without power.
  explicit SiiUnit(std::vector<std::byte> image);

  void power_on(Time now) noexcept;
  /// The content as it was delivered; what was under way is forgotten.
  void renew() noexcept;
  void set_timing(const StationTiming& timing) noexcept { timing_ = timing; }

  /// `at`: register address, inside 0500h..050Fh together with `in`.
  bool write(std::size_t at, std::span<const std::byte> in, Time now) noexcept;
  void show(std::span<std::byte> registers, Time now) noexcept;

  /// Whether the configuration area has its right checksum: without it an ESC does not hand over to its application.
  [[nodiscard]] bool loaded() const noexcept { return loaded_; }
  [[nodiscard]] bool is_stations() const noexcept { return (std::to_integer<unsigned>(registers_[0]) & 1u) != 0; }
  [[nodiscard]] std::uint16_t word(std::size_t address) const noexcept;

 private:
  void settle(Time now) noexcept;
  void command(Time now) noexcept;
  void load() noexcept;

  std::vector<std::byte> image_, delivered_;
  StationTiming timing_;
  std::array<std::byte, kRegisterBytes> registers_{};
  std::uint16_t running_ = 0;  ///< the command under way
  Time done_at_ = kNever;
  bool loaded_ = false;
};

}  // namespace gantry::sim
