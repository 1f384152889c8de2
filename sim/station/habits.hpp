// What a virtual station does otherwise than its profile can say: habits of real stations that a master has to bend to.
//   segment.set_habits(id, {.even_pdos = true});      // before it is brought up; outlives its power
#pragma once
#include <cstdint>
#include <optional>

#include "core/clock.hpp"

namespace gantry::sim {

/// An operation mode of the SII's category DC (ETG.2010 table 15).
struct ClockMode {
  std::uint16_t activate = 0x0300;  ///< 0980h and 0981h
  std::uint32_t cycle0_ns = 0, shift0_ns = 0, shift1_ns = 0;
  std::int16_t factor0 = 1, factor1 = 0;
};

struct StationHabits {
  Time mailbox_delay{};               ///< between a request and its answer
  std::uint8_t abort_command = 0x80;  ///< SDO abort; only its upper three bits are fixed (ETG.1000.6, 5.6.2.7)
  bool needs_eeprom = false;          ///< leaves INIT only while its processor has the EEPROM (0500h), else 0051h
  bool assignment_fixed = false;      ///< 1C12h and 1C13h cannot be written
  bool mapping_fixed = false;         ///< nor can 16xxh and 1Axxh
  bool even_pdos = false;             ///< 16 and 32 bits on whole words only, and PDOs of an even number of bytes
  bool no_information = false;        ///< no SDO information
  std::optional<ClockMode> clock{};   ///< the one mode in its SII, and it takes no other
};

}  // namespace gantry::sim
