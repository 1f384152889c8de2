// What a virtual drive shows that is not so, and what it does not do although it says so: for tests of who believes it.
#pragma once
#include <cstdint>
#include <optional>

namespace gantry::sim {

struct DriveLies {
  std::optional<std::int8_t> mode_shown{};  ///< 6061h, whatever the mode is
  std::uint32_t input_noise = 0;            ///< bits of 60FDh that change at random in every cycle
  std::uint16_t status_never = 0;           ///< bits of 6041h that are never set
  std::uint16_t status_always = 0;          ///< bits of 6041h that always are
  bool position_dead = false;               ///< 6064h stays at what it was when the supply came
  bool home_at_once = false;                ///< homing is called done where it begins
  bool keeps_counter = false;               ///< homing does not set 6064h at its edge
  bool home_never = false;                  ///< homing is begun and nothing moves
  bool ignores_targets = false;             ///< of CSP, with the statusword of one that follows
};

}  // namespace gantry::sim
