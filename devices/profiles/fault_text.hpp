// A drive's own error as text: code of 603Fh -> what the manual says and what to do.
#pragma once
#include <cstdint>
#include <string>

#include "config/drive.hpp"

namespace gantry::devices {

struct DriveErrorText {
  config::DriveErrorKind kind = config::DriveErrorKind::Fault;
  std::string text{};     ///< "AMD530B: over-voltage (603Fh = 3210h, manual 3.8)"
  std::string remedy{};   ///< empty when the profile has none
  std::string section{};  ///< of the manual
};

/// A code that the profile does not list yields a text that says so, with the number.
DriveErrorText fault_text(const config::StationProfile& profile, std::uint32_t code);

}  // namespace gantry::devices
