#include "app/record/job_folder.hpp"

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <filesystem>
#include <fmt/format.h>
#include <iterator>
#include <system_error>
#include <unistd.h>

#include "app/record/report.hpp"
#include "app/record/summary.hpp"
#include "core/new_file.hpp"

namespace gantry::record {
namespace fs = std::filesystem;
namespace {

/// What a job leaves in its folder.
constexpr const char* kLeft[] = {"report.html",   "summary.json",     "deposits.csv",
                                 "setpoints.bin", "certificate.json", "marks"};
constexpr int kMostFolders = 100000;

bool holds_a_job(const fs::path& folder) {
  return std::any_of(std::begin(kLeft), std::end(kLeft), [&](const char* left) {
    std::error_code error;
    return fs::exists(fs::symlink_status(folder / left, error));
  });
}

/// The highest n of the folders <stem>-<n> in `parent`; 0 where there is none.
int last_number(const fs::path& parent, const std::string& stem) {
  int last = 0;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(parent, error)) {
    const std::string name = entry.path().filename().string();
    if (!name.starts_with(stem + "-")) continue;
    int n = 0;
    const char* const end = name.data() + name.size();
    const auto [rest, wrong] = std::from_chars(name.data() + stem.size() + 1, end, n);
    if (wrong == std::errc() && rest == end && n <= kMostFolders) last = std::max(last, n);
  }
  return last;
}

}  // namespace

Result<std::string> job_folder(const WantedFolder& wanted, const std::string& recipe_file) {
  const bool named = !wanted.path.empty();
  const auto cannot = [&](const fs::path& folder, const std::error_code& error) {
    return fail(named ? Fault::Usage : Fault::FileUnwritable,
                fmt::format("cannot make or clear the folder for results: {}", error.message()), folder.string());
  };
  std::error_code error;
  const fs::path parent = named ? wanted.path : wanted.under;
  if (auto made = make_folder(parent.string()); !made)
    return fail(named ? Fault::Usage : Fault::FileUnwritable, made.error().message, made.error().where);
  if (named) {
    if (!wanted.overwrite && holds_a_job(parent))
      return fail(Fault::Usage,
                  "this folder holds the results of a job; name another one, or let `--force` overwrite them",
                  wanted.path);
    for (const char* left : kLeft)
      if (fs::remove_all(parent / left, error); error) return cannot(parent, error);
    if (::access(parent.c_str(), W_OK | X_OK) != 0) return cannot(parent, {errno, std::generic_category()});
    return wanted.path;
  }
  const std::string stem = fs::path(recipe_file).stem().string();
  for (int n = last_number(parent, stem) + 1; n <= kMostFolders; ++n) {
    const fs::path folder = parent / fmt::format("{}-{:03}", stem, n);
    if (fs::create_directory(folder, error)) return folder.string();
    if (error) return cannot(folder, error);
  }
  return fail(Fault::FileUnwritable, "too many results of this recipe; clear the folder", parent.string());
}

Result<void> write_job(const JobResult& result, const std::string& folder) {
  if (auto r = write_report(folder, result); !r) return r;
  return write_summary(folder, result);
}

}  // namespace gantry::record
