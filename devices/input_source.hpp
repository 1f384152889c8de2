// How an input that the loop looks at comes from its station.
#pragma once
#include <cstdint>

namespace gantry::devices {

enum class InputSource : std::uint8_t {
  EveryCycle,  ///< in a PDO
  Polled,      ///< by SDO, and it has answered lately
  Silent,      ///< by SDO, and it has not: what is known of it is old
  Absent,      ///< the station does not show it
};

}  // namespace gantry::devices
