// How a station's SII says that its clock is activated.
//   sii_image(profile, alias, serial, ClockMode{.activate = 0x0700, .shift1_ns = 250'000})
#pragma once
#include <cstdint>

namespace gantry::sim {

/// An operation mode of the SII's category DC (ETG.2010 table 15).
struct ClockMode {
  std::uint16_t activate = 0x0300;  ///< 0980h and 0981h
  std::uint32_t cycle0_ns = 0, shift0_ns = 0, shift1_ns = 0;
  std::int16_t factor0 = 1, factor1 = 0;
};

}  // namespace gantry::sim
