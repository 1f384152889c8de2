// What a virtual station does otherwise than its profile can say: habits of real stations that a master has to bend to.
//   segment.set_habits(id, {.even_pdos = true});      // before it is brought up; outlives its power
#pragma once
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "core/clock.hpp"
#include "devices/wire/ethercat.hpp"
#include "sim/drive/drive_lies.hpp"
#include "sim/objects/clock_mode.hpp"
#include "sim/objects/mailbox_lies.hpp"
#include "sim/objects/object_dictionary.hpp"

namespace gantry::sim {

struct StationHabits {
  Time mailbox_delay{};               ///< between a request and its answer
  std::uint8_t abort_command = 0x80;  ///< SDO abort; only its upper three bits are fixed (ETG.1000.6, 5.6.2.7)
  bool needs_eeprom = false;          ///< leaves INIT only while its processor has the EEPROM (0500h), else 0051h
  bool assignment_fixed = false;      ///< 1C12h and 1C13h cannot be written
  bool mapping_fixed = false;         ///< nor can 16xxh and 1Axxh
  bool even_pdos = false;             ///< 16 and 32 bits on whole words only, and PDOs of an even number of bytes
  bool no_information = false;        ///< no SDO information
  std::optional<ClockMode> clock{};   ///< the one mode in its SII, and it takes no other
  /// A state that it does not enter, and the AL status code with which it says so.
  struct Refusal {
    devices::wire::AlState state{};
    std::uint16_t code = 0;
  };
  std::optional<Refusal> refuses{};
  std::uint16_t al_bits = 0;  ///< that its AL status shows beside state and error, bits 5 to 15
  /// It falls to SAFE_OP with this AL status code after so many cycles in OP.
  struct Fall {
    std::int64_t after = 0;
    std::uint16_t code = 0;
    bool again = false;  ///< whenever it has been in OP for so long
  };
  std::optional<Fall> falls{};
  DriveLies lies{};  ///< of its drives
  MailboxLies mailbox{};
  std::optional<config::ObjectAddress> ignores{};  ///< writes to it are answered and change nothing
  Saving save = Saving::Keeps;
  std::function<void(std::vector<std::byte>&)> eeprom{};  ///< alters what stands in its SII
};

}  // namespace gantry::sim
