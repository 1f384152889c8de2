#include "app/record/job_folder.hpp"

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <chrono>
#include <fcntl.h>
#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <sstream>
#include <sys/file.h>
#include <system_error>
#include <thread>
#include <unistd.h>
#include <vector>

#include "app/record/outcome.hpp"
#include "app/record/report.hpp"
#include "app/record/summary.hpp"
#include "app/record/write_file.hpp"
#include "config/yaml.hpp"
#include "core/absolute_path.hpp"
#include "core/log.hpp"
#include "core/new_file.hpp"
#include "core/sha256.hpp"

namespace gantry::record {
namespace fs = std::filesystem;
namespace {

/// What a job leaves in its folder.
constexpr const char* kLeft[] = {"report.html",     "summary.json",     "deposits.csv", "setpoints.bin",
                                 "bead_speeds.csv", "certificate.json", "motions.csv"};
constexpr const char* kFolders[] = {"marks", "inputs"};  // of it, for files that the summary names
constexpr std::size_t kLongestInput = 10'000'000;        // bytes; of a longer file its hash is enough
constexpr std::uintmax_t kLongestSummary = 500'000'000;
constexpr int kHighestNumber = 999'999'999;

bool holds_a_job(const fs::path& folder) {
  return std::any_of(std::begin(kLeft), std::end(kLeft), [&](const char* left) {
    std::error_code error;
    return fs::exists(fs::symlink_status(folder / left, error));
  });
}

/// The highest n of the folders <stem>-<n> in `parent` that hold a job or nothing yet; `last` where none is higher.
/// Others that are called so ("board-20261121") count for nothing.
int last_number(const fs::path& parent, const std::string& stem, int last) {
  std::error_code error, ignored;
  for (const auto& entry : fs::directory_iterator(parent, error)) {
    const std::string name = entry.path().filename().string();
    if (!name.starts_with(stem + "-")) continue;
    int n = 0;
    const char* const end = name.data() + name.size();
    const auto [rest, wrong] = std::from_chars(name.data() + stem.size() + 1, end, n);
    const bool higher = wrong == std::errc() && rest == end && n > last && n <= kHighestNumber;
    if (higher && (holds_a_job(entry.path()) || fs::is_empty(entry.path(), ignored))) last = n;
  }
  return last;
}

/// Numbers are never used twice, also where the newest job was taken away: the highest is kept beside the jobs.
fs::path number_file(const fs::path& parent, const std::string& stem) { return parent / ("." + stem + ".last-number"); }

int kept_number(const fs::path& parent, const std::string& stem) {
  const auto text = config::read_text_file(number_file(parent, stem).string());
  int n = 0;
  return text && std::istringstream(*text) >> n && n > 0 && n <= kHighestNumber ? n : 0;
}

/// Two jobs that begin at once in one folder number theirs one after the other. Whoever holds the lock for longer than
/// a number takes does not keep jobs from beginning.
std::optional<FolderInUse> number_alone(const fs::path& parent) {
  constexpr int kTries = 100;
  for (int n = 0; n < kTries; ++n) {
    if (auto alone = FolderInUse::take(parent.string())) return alone;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  return std::nullopt;
}

/// A file or a link itself; folders and devices are nobody's of a job's.
bool is_file(const fs::path& path) {
  std::error_code ignored;
  const fs::file_status found = fs::symlink_status(path, ignored);
  return fs::is_regular_file(found) || fs::is_symlink(found);
}

/// What the summary of the job in `folder` names as "marks/<file>" or "inputs/<file>". No other path is believed.
std::vector<fs::path> named_by_job(const fs::path& folder) {
  const fs::path file = folder / "summary.json";
  std::error_code error;
  if (!fs::is_regular_file(fs::symlink_status(file, error)) || fs::file_size(file, error) > kLongestSummary) return {};
  std::ifstream in(file);
  const auto summary = nlohmann::json::parse(in, nullptr, false);
  if (!summary.is_object() || !summary.contains("files") || !summary["files"].is_array()) return {};
  std::vector<fs::path> found;
  for (const auto& each : summary["files"]) {
    if (!each.is_string()) continue;
    const fs::path named = each.get<std::string>();
    if (named.has_filename() && std::ranges::find(kFolders, named.parent_path()) != std::end(kFolders))
      found.push_back(named);
  }
  return found;
}

/// Its folders of images and inputs go when they are empty by then: what else lies there is somebody's.
std::error_code remove_job(const fs::path& folder, const std::vector<std::string>& spared = {}) {
  std::vector<fs::path> named(std::begin(kLeft), std::end(kLeft));
  std::error_code error, ignored;
  const auto is_own = [&](const fs::path& within) {
    return fs::is_directory(fs::symlink_status(folder / within, ignored));
  };
  const auto stays = [&](const fs::path& within) {
    return std::ranges::any_of(spared,
                               [&](const std::string& file) { return fs::equivalent(folder / within, file, ignored); });
  };
  for (fs::path& each : named_by_job(folder))
    if (is_own(each.parent_path()) && !stays(each)) named.push_back(std::move(each));
  for (const fs::path& each : named)
    if (is_file(folder / each) && (fs::remove(folder / each, error), error)) return error;
  for (const char* within : kFolders)
    if (is_own(within)) fs::remove(folder / within, ignored);
  return {};
}

/// A file that the job was made of, and its name in the job's folder.
struct Input {
  std::string name, file, sha256;
};
std::vector<Input> inputs_of(const JobResult& r, const fs::path& folder) {
  std::vector<Input> inputs;
  std::error_code ignored;
  const auto add = [&](const std::string& file, const std::string& sha256) {
    if (file.empty() || sha256.empty()) return;
    const std::string base = fs::path(file).filename().string();
    std::string name = "inputs/" + base;
    const auto taken = [&] {
      return std::ranges::find(inputs, name, &Input::name) != inputs.end() ||
             (fs::exists(fs::symlink_status(folder / name, ignored)) && !fs::equivalent(folder / name, file, ignored));
    };
    for (int n = 2; taken(); ++n) name = fmt::format("inputs/{}-{}", n, base);
    inputs.push_back({name, file, sha256});
  };
  for (const recipes::Source& s : r.sources) add(s.file, s.sha256);
  add(r.origin.machine_file, r.origin.machine_sha256);
  for (const recipes::Source& p : r.origin.profiles) add(p.file, p.sha256);
  return inputs;
}

/// The very bytes that the job was made of, or none.
Result<void> keep_input(const std::string& folder, const Input& input) {
  const auto text = config::read_text_file(input.file, kLongestInput);
  if (!text) return tl::unexpected(text.error());
  if (sha256_hex(*text) != input.sha256)
    return fail(Fault::FileUnreadable, "it has changed since the job was made of it", input.file);
  std::error_code ignored;
  if (fs::equivalent(fs::path(folder) / input.name, input.file, ignored)) return {};  // another job has kept it there
  return write_file(folder + "/" + input.name, *text);
}

Result<void> keep_image(const std::string& folder, const std::string& name, const MarkResult& mark) {
  std::error_code ignored;
  if (fs::exists(fs::symlink_status(fs::path(folder) / name, ignored)))
    return fail(Fault::FileUnwritable, "a file of this name was there before the job", folder + "/" + name);
  return write_image(folder, name, mark);
}

}  // namespace

std::optional<FolderInUse> FolderInUse::take(const std::string& folder) {
  const int fd = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (fd < 0 || ::flock(fd, LOCK_EX | LOCK_NB) == 0) return FolderInUse(fd);
  const bool taken = errno == EWOULDBLOCK;
  ::close(fd);
  if (taken) return std::nullopt;
  return FolderInUse();  // a file system without locks
}

FolderInUse::~FolderInUse() {
  if (fd_ >= 0) ::close(fd_);
}

namespace {

tl::unexpected<Error> in_use(const std::string& folder) {
  return fail(Fault::Usage, "another job writes its results into this folder; wait for its end, or name another one",
              folder);
}

}  // namespace

Result<void> check_folder(const WantedFolder& wanted) {
  const bool named = !wanted.path.empty();
  if (named && !wanted.overwrite && holds_a_job(wanted.path))
    return fail(Fault::Usage,
                "this folder holds the results of a job; name another one, or let `--force` overwrite them",
                wanted.path);
  if (named && !FolderInUse::take(wanted.path)) return in_use(wanted.path);
  const std::string& tried = named ? wanted.path : wanted.under;
  if (auto somewhere = absolute_path(tried); !somewhere) return tl::unexpected(somewhere.error());
  if (auto usable = try_folder(tried); !usable)
    return fail(named ? Fault::Usage : Fault::FileUnwritable, usable.error().message, usable.error().where);
  return {};
}

Result<JobFolder> job_folder(const WantedFolder& wanted, const std::string& recipe_file, const Room& room) {
  const bool named = !wanted.path.empty();
  const auto cannot = [&](const fs::path& folder, const std::error_code& error) {
    return fail(named ? Fault::Usage : Fault::FileUnwritable,
                fmt::format("cannot make or clear the folder for results: {}", error.message()), folder.string());
  };
  std::error_code error;
  const fs::path parent = named ? wanted.path : wanted.under;
  if (auto usable = check_folder(wanted); !usable) return tl::unexpected(usable.error());
  if (auto enough = enough_room(parent.string(), room); !enough) return tl::unexpected(enough.error());
  if (auto made = make_folder(parent.string()); !made)
    return fail(named ? Fault::Usage : Fault::FileUnwritable, made.error().message, made.error().where);
  auto kept_room = KeptRoom::keep(parent.string(), room.result_bytes);
  if (!kept_room) return tl::unexpected(kept_room.error());
  if (named) {
    auto ours = FolderInUse::take(wanted.path);
    if (!ours) return in_use(wanted.path);
    if (const std::error_code wrong = wanted.overwrite ? remove_job(parent, wanted.made_of) : std::error_code())
      return cannot(parent, wrong);
    if (::access(parent.c_str(), W_OK | X_OK) != 0) return cannot(parent, {errno, std::generic_category()});
    return JobFolder{wanted.path, *std::move(kept_room), *std::move(ours)};
  }
  const std::string stem = fs::path(recipe_file).stem().string();
  const std::optional<FolderInUse> alone = number_alone(parent);
  for (int n = last_number(parent, stem, kept_number(parent, stem)) + 1; n <= kHighestNumber; ++n) {
    const fs::path folder = parent / fmt::format("{}-{:03}", stem, n);
    if (fs::create_directory(folder, error)) {
      if (auto kept = write_new_file(number_file(parent, stem).string(), fmt::format("{}\n", n)); !kept)
        log::report(kept.error());
      auto ours = FolderInUse::take(folder.string());
      return JobFolder{folder.string(), *std::move(kept_room), ours ? *std::move(ours) : FolderInUse()};
    }
    if (error) return cannot(folder, error);
  }
  return fail(Fault::FileUnwritable,
              fmt::format("no number is left for the results of this recipe; take away '{}' and the folder with the "
                          "highest number",
                          number_file(parent, stem).filename().string()),
              parent.string());
}

void take_away(const std::string& folder) {
  std::error_code ignored;
  if (const std::error_code wrong = remove_job(folder))
    return log::warn("{} is not taken away: {}", folder, wrong.message());
  fs::remove(folder, ignored);
}

Result<void> write_job(JobResult& result, const std::string& folder, const Certify& certify, KeptRoom room) {
  std::vector<std::string> files;
  const auto keep = [&](const std::string& name, const Result<void>& written) {
    if (!written) not_kept(result, name, written.error());
    return written.has_value();
  };
  // The verdict first: what follows may fill the disk, and a program that dies while it writes the report has said what
  // the job came to. Once more at the end, when it is known which files there are, and which could not be kept.
  const Result<void> first = room.become((fs::path(folder) / "summary.json").string(), summary_text(result, files));
  const bool reported = keep("report.html", write_report(folder, result));
  const auto images = image_names(result);
  for (std::size_t i = 0; i < images.size(); ++i)
    if (!images[i].empty() && keep(images[i], keep_image(folder, images[i], result.marks[i])))
      files.push_back(images[i]);
  for (const Input& input : inputs_of(result, folder))
    if (keep(input.name, keep_input(folder, input))) files.push_back(input.name);
  if (certify && reported && first) keep("certificate.json", certify(folder));
  // What it would name tells nothing without it.
  std::error_code ignored;
  if (!is_file(fs::path(folder) / "certificate.json")) fs::remove(fs::path(folder) / "motions.csv", ignored);
  for (const char* left : kLeft)
    if (is_file(fs::path(folder) / left)) files.emplace_back(left);
  const Result<void> last = write_summary(folder, result, files);
  if (first && !last) log::warn("summary.json does not name the files of its folder: {}", last.error().message);
  return first ? first : last;
}

std::string name_of_job(const std::string& folder) {
  std::error_code ignored;
  const fs::path path = fs::absolute(folder, ignored).lexically_normal();
  return (path.has_filename() ? path : path.parent_path()).filename().string();
}

bool has_report(const std::string& folder) {
  std::error_code ignored;
  return !folder.empty() && fs::is_regular_file(fs::path(folder) / "report.html", ignored);
}

}  // namespace gantry::record
