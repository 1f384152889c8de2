// AL status codes that the virtual stations give (ETG.1000.6 table 11, ETG.1020; texts in devices/wire/ethercat.hpp).
#pragma once
#include <cstdint>

namespace gantry::sim::al_code {

inline constexpr std::uint16_t kInvalidChange = 0x0011, kUnknownState = 0x0012, kNoBootstrap = 0x0013,
                               kMailboxConfig = 0x0016, kSyncManagerConfig = 0x0017, kSyncError = 0x001A,
                               kSmWatchdog = 0x001B, kOutputConfig = 0x001D, kInputConfig = 0x001E,
                               kInputMapping = 0x0024, kOutputMapping = 0x0025, kFatalSync = 0x002C, kNoSync = 0x002D,
                               kSyncConfig = 0x0030, kSync0Cycle = 0x0036, kSiiError = 0x0051;

}  // namespace gantry::sim::al_code
