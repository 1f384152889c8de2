// CANopen (CiA 301): identifiers and commands that the feeder's bus uses.
#pragma once
#include <cstdint>

namespace gantry::devices::wire::cia301 {

inline constexpr std::uint32_t kNmt = 0x000, kSync = 0x080, kEmergency = 0x080;  ///< emergency: + node
inline constexpr std::uint32_t kTpdo1 = 0x180, kRpdo1 = 0x200, kTpdo2 = 0x280, kRpdo2 = 0x300, kTpdo3 = 0x380,
                               kRpdo3 = 0x400, kTpdo4 = 0x480, kRpdo4 = 0x500;
inline constexpr std::uint32_t kSdoResponse = 0x580, kSdoRequest = 0x600, kHeartbeat = 0x700;
inline constexpr std::uint32_t kNodeMask = 0x07F, kFunctionMask = 0x780;

enum class Nmt : std::uint8_t { Start = 1, Stop = 2, PreOperational = 128, ResetNode = 129, ResetCommunication = 130 };
enum class NodeState : std::uint8_t { BootUp = 0, Stopped = 4, Operational = 5, PreOperational = 127 };

}  // namespace gantry::devices::wire::cia301
