#include "app/record/job_folder.hpp"

#include <cerrno>
#include <filesystem>
#include <fmt/format.h>
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

}  // namespace

Result<std::string> job_folder(const std::string& wanted, const std::string& recipe_file, const std::string& under) {
  constexpr int kMost = 100000;
  const auto cannot = [&](const fs::path& folder, const std::error_code& error) {
    return fail(wanted.empty() ? Fault::FileUnwritable : Fault::Usage,
                fmt::format("cannot make or clear the folder for results: {}", error.message()), folder.string());
  };
  std::error_code error;
  const fs::path parent = wanted.empty() ? fs::path(under) : fs::path(wanted);
  if (auto made = make_folder(parent.string()); !made)
    return fail(wanted.empty() ? Fault::FileUnwritable : Fault::Usage, made.error().message, made.error().where);
  if (!wanted.empty()) {
    for (const char* left : kLeft)
      if (fs::remove_all(parent / left, error); error) return cannot(parent, error);
    if (::access(parent.c_str(), W_OK | X_OK) != 0) return cannot(parent, {errno, std::generic_category()});
    return wanted;
  }
  const std::string stem = fs::path(recipe_file).stem().string();
  for (int n = 1; n <= kMost; ++n) {
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
