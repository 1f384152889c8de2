// A frame of another EtherCAT master on the same line.
#pragma once
#include <cstddef>
#include <span>

namespace gantry::sim {

/// As it comes back: a broadcast read of the AL states that six stations have answered, from 02:1B:21:0A:0B:0C.
std::span<const std::byte> foreign_frame() noexcept;

}  // namespace gantry::sim
