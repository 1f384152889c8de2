#include "app/record/room.hpp"

#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <filesystem>
#include <fmt/format.h>
#include <sys/statvfs.h>
#include <unistd.h>
#include <utility>
#include <variant>

#include "app/record/write_file.hpp"
#include "core/absolute_path.hpp"
#include "core/new_file.hpp"

namespace gantry::record {
namespace fs = std::filesystem;
namespace {

// As jobs have left them, and half as much again: `gantry dry-run` of recipes/demo-board.yaml (35 features, 39 s) and
// tests/machine/many-dots.yaml (4000 dots, 1300 s).
constexpr double kPage = 3e6;         // the report with its scene, whatever the job
constexpr double kFeature = 1.5e3;    // in summary and report
constexpr double kBeadSecond = 30e3;  // the path of the needle in summary and report, and once more in deposits.csv
constexpr double kShot = 200;         // a dot in deposits.csv
constexpr double kImage = 300e3;      // of a mark
constexpr double kTick = 12;          // in setpoints.bin
constexpr double kMotion = 350;       // in motions.csv
constexpr double kMb = 1e6;
constexpr const char* kMakeRoom = "take old results away, or let `--out` name a folder on another disk";

tl::unexpected<Error> too_little(const std::string& folder, double free, double needed) {
  return fail(Fault::FileUnwritable,
              fmt::format("the disk has {:.1f} MB free, and the results of this job need up to {:.1f} MB; {}",
                          free / kMb, needed / kMb, kMakeRoom),
              folder);
}

}  // namespace

Room room_for(const job::Forecast& forecast, const recipes::Recipe& recipe, double cycle_s,
              std::size_t listed_motions) {
  double beads_s = 0;
  for (std::size_t i = 0; i < forecast.features.size() && i < recipe.features.size(); ++i)
    if (std::holds_alternative<recipes::Bead>(recipe.features[i])) beads_s += forecast.features[i].on_it_s;
  const auto features = static_cast<double>(recipe.features.size()), marks = static_cast<double>(recipe.marks.size());
  return {.result_bytes = static_cast<std::uint64_t>(kPage + kFeature * features + kBeadSecond * beads_s),
          .large_bytes =
              static_cast<std::uint64_t>(kTick * forecast.s / cycle_s + kBeadSecond * beads_s + kShot * features +
                                         kImage * marks + kMotion * static_cast<double>(listed_motions))};
}

Result<void> enough_room(const std::string& folder, const Room& room) {
  const auto whole = absolute_path(folder);
  if (!whole) return tl::unexpected(whole.error());
  fs::path at = *whole;
  std::error_code ignored;
  while (!fs::exists(at, ignored) && at.has_relative_path()) at = at.parent_path();
  struct statvfs disk {};
  // Whoever makes the folder says what is wrong with it; what has no blocks (/proc) is no disk.
  if (::statvfs(at.c_str(), &disk) != 0 || disk.f_blocks == 0) return {};
  const double free = static_cast<double>(disk.f_bavail) * static_cast<double>(disk.f_frsize);
  const double needed = static_cast<double>(room.result_bytes) + static_cast<double>(room.large_bytes);
  if (free < needed) return too_little(folder, free, needed);
  return {};
}

Result<KeptRoom> KeptRoom::keep(const std::string& folder, std::uint64_t bytes) {
  const int fd = ::open(folder.c_str(), O_TMPFILE | O_WRONLY | O_CLOEXEC, 0666);
  if (fd < 0) return KeptRoom();
  KeptRoom kept(fd, bytes);
  // fallocate(2), and not posix_fallocate(3): a promise alone, nothing is written where there is none.
  if (::fallocate(fd, 0, 0, static_cast<off_t>(bytes)) == 0) return kept;
  if (const int wrong = errno; wrong == ENOSPC || wrong == EDQUOT)
    return fail(Fault::FileUnwritable,
                fmt::format("the disk does not give the {:.1f} MB that the results of this job need at least: {}; {}",
                            static_cast<double>(bytes) / kMb, std::strerror(wrong), kMakeRoom),
                folder);
  return KeptRoom();
}

KeptRoom::KeptRoom(KeptRoom&& other) noexcept : fd_(std::exchange(other.fd_, -1)), bytes_(other.bytes_) {}

Result<void> KeptRoom::become(const std::string& path, std::string_view bytes) {
  const bool done = fd_ >= 0 && bytes.size() <= bytes_ && name_new_file(fd_, path, bytes);
  give();
  return done ? Result<void>{} : write_file(path, bytes);
}

void KeptRoom::give() {
  if (fd_ >= 0) ::close(std::exchange(fd_, -1));
}

}  // namespace gantry::record
