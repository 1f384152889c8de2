#include "devices/profiles/fault_text.hpp"

#include <algorithm>
#include <fmt/format.h>

namespace gantry::devices {

DriveErrorText fault_text(const config::StationProfile& profile, std::uint32_t code) {
  if (code == 0)
    return {.text = fmt::format("{}: no error code (603Fh = 0): communication lost, or a fault that the drive does not "
                                "name",
                                profile.title)};
  if (profile.drive) {
    const auto& rows = profile.drive->errors;
    const auto row = std::find_if(rows.begin(), rows.end(), [&](const auto& r) { return r.code == code; });
    if (row != rows.end()) {
      const std::string section = row->section.empty() ? "" : fmt::format(", manual {}", row->section);
      return {row->kind, fmt::format("{}: {} (603Fh = {:04X}h{})", profile.title, row->text, code, section),
              row->remedy, row->section};
    }
  }
  return {.text = fmt::format("{}: error code {:04X}h, which its manual does not list", profile.title, code)};
}

}  // namespace gantry::devices
