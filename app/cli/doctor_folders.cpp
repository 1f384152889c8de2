#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fmt/format.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include "app/cli/doctor.hpp"
#include "app/desk/state_folder.hpp"

namespace gantry::cli {
namespace {

namespace fs = std::filesystem;
using Level = Finding::Level;

constexpr double kMb = 1e6;
constexpr double kScarce_mb = 1000, kTooLittle_mb = 200;

/// The folder itself, or the nearest above it that is there.
fs::path nearest_that_is(fs::path folder) {
  std::error_code ignored;
  while (!fs::exists(folder, ignored) && folder.has_relative_path()) folder = folder.parent_path();
  return folder;
}

Finding room(const std::string& name, const fs::path& folder, std::string_view more_room) {
  struct statvfs disk {};
  const fs::path at = nearest_that_is(folder);
  if (::statvfs(at.c_str(), &disk) != 0)
    return {name, Level::Error, fmt::format("{}: {}", at.string(), std::strerror(errno)), "name another folder",
            Fault::FileUnwritable};
  const double mb = static_cast<double>(disk.f_bavail) * static_cast<double>(disk.f_frsize) / kMb;
  const std::string text = fmt::format("{:.0f} MB free for {}", mb, folder.string());
  if ((disk.f_flag & ST_RDONLY) != 0)
    return {name, Level::Error, text + ", but it is mounted read-only", "name another folder, or mount it writable",
            Fault::FileUnwritable};
  if (mb >= kScarce_mb) return {name, Level::Ok, text, "", {}};
  return {name, mb < kTooLittle_mb ? Level::Error : Level::Warning, text, std::string(more_room),
          Fault::FileUnwritable};
}

/// Without making or changing it.
Finding rights_of_state(const fs::path& state) {
  constexpr const char* kName = "state folder";
  struct stat found {};
  if (::lstat(state.c_str(), &found) != 0) {
    const fs::path above = nearest_that_is(state);
    if (::access(above.c_str(), W_OK | X_OK) == 0)
      return {kName, Level::Ok, fmt::format("{} will be made", state.string()), "", {}};
    return {kName, Level::Error,
            fmt::format("{} cannot be made in {}: {}", state.string(), above.string(), std::strerror(errno)),
            "name a folder of your own with --state or GANTRY_STATE", Fault::Refused};
  }
  if (auto unfit = desk::unfit_for_state(state.string(), found))
    return {kName, Level::Error, fmt::format("{}: {}", state.string(), unfit->what), std::move(unfit->remedy),
            Fault::Refused};
  return {kName, Level::Ok, state.string(), "", {}};
}

}  // namespace

Findings look_at_folders(const std::string& state, const std::string& out) {
  const fs::path above = nearest_that_is(out);
  Findings findings{
      rights_of_state(state),
      room("disk of the state", state, "make room there, or let --state name a folder on another disk"),
      room("disk of the results", out, "take old jobs away (out/), or let --out name a folder on another disk")};
  if (::access(above.c_str(), W_OK | X_OK) != 0)
    findings.push_back({"results", Level::Warning, fmt::format("{}: {}", above.string(), std::strerror(errno)),
                        "stand in a folder of your own, or let --out name one", Fault::FileUnwritable});
  return findings;
}

}  // namespace gantry::cli
