// What a virtual drive shows that is not so, and what it does not do although it says so: for tests of who believes it.
#pragma once
#include <cstdint>
#include <optional>

#include "config/drive.hpp"

namespace gantry::sim {

/// What is wrong with its touch probe.
enum class ProbeLie : std::uint8_t {
  None,
  AlwaysLatched,    ///< 60B9h shows a latched edge whatever 60B8h is
  LatchedAtArming,  ///< an edge is shown as soon as the probe is armed
  ValueOfBefore,    ///< 60BAh holds the edge before the one that is shown
  NeverClears,      ///< a latch that was shown once stays shown
};

struct DriveLies {
  std::optional<std::int8_t> mode_shown{};            ///< 6061h, whatever the mode is
  std::uint32_t input_noise = 0;                      ///< bits of 60FDh that change at random in every cycle
  std::uint16_t status_never = 0;                     ///< bits of 6041h that are never set
  std::uint16_t status_always = 0;                    ///< bits of 6041h that always are
  bool position_dead = false;                         ///< 6064h stays at what it was when the supply came
  bool home_at_once = false;                          ///< homing is called done where it begins
  bool keeps_counter = false;                         ///< homing does not set 6064h at its edge
  bool home_never = false;                            ///< homing is begun and nothing moves
  bool ignores_targets = false;                       ///< of CSP, with the statusword of one that follows
  std::optional<std::int8_t> mode_shown_in_motion{};  ///< 6061h while it moves in CSP
  std::uint32_t inputs_inverted = 0;                  ///< bits of 60FDh
  int position_factor = 1;                            ///< 6064h is so many times what it counts
  std::int32_t position_off = 0;                      ///< 6064h is so many counts off
  std::int64_t after = 0;          ///< cycles since it has its supply, from which on the three of 6064h hold
  std::int32_t counter_begin = 0;  ///< 6064h where the supply comes, as a drive has it that counts on without
  int load = 0;                    ///< counts by which 6064h stands below the command while the drive has torque
  int mode_delay = 0;              ///< cycles from another 6060h until the drive is in that mode, and shows it
  int mode_shown_after = 0;        ///< cycles for which 6061h still shows the mode that was left
  int enable_delay = 0;            ///< cycles from "enable operation" to its state
  bool enables_unasked = false;    ///< it goes to Operation Enabled as soon as it is switched on
  bool coasts = false;             ///< a quick stop takes the torque, whatever 605Ah is
  std::optional<config::ObjectAddress> reverts{};  ///< has its start value again as soon as the drive is enabled
  ProbeLie probe = ProbeLie::None;
};

}  // namespace gantry::sim
