#include "app/run/job_files.hpp"

#include <cerrno>
#include <filesystem>
#include <fmt/format.h>
#include <system_error>
#include <unistd.h>

#include "app/record/drawing.hpp"
#include "app/record/environment.hpp"
#include "app/record/report.hpp"
#include "app/record/summary.hpp"
#include "core/log.hpp"

namespace gantry::run {
namespace fs = std::filesystem;
namespace {

/// What a job leaves in its folder.
constexpr const char* kLeft[] = {"report.html", "summary.json", "deposits.csv", "setpoints.bin", "marks"};

}  // namespace

record::JobResult begin_result(const config::Machine& machine, const recipes::Recipe& recipe, const recipes::Job& job,
                               const RunOptions& options) {
  record::JobResult result;
  result.job = options.out.empty() ? fs::path(recipe.file).stem().string() : fs::path(options.out).filename().string();
  result.recipe_file = recipe.file;
  result.recipe_name = recipe.name;
  result.machine_name = machine.name;
  result.dry_run = options.dry_run;
  result.started = record::utc_now();
  result.environment = record::environment_facts();
  result.blocks_total = job.blocks.size();
  result.features_total = recipe.features.size();
  result.drawing = record::drawing_of(recipe, machine, job);
  return result;
}

void add_error(record::JobResult& result, Error error) {
  if (result.exit_code == ExitCode::Done) result.exit_code = info(error.fault).exit_code;
  result.errors.push_back(std::move(error));
}

void add_world(record::JobResult& result, sim::WorldAccess& world, const RunOptions& options) {
  if (auto deposits = world.deposits())
    result.deposits = std::move(*deposits), result.has_world = true;
  else
    add_error(result, deposits.error());
  if (auto collisions = world.collisions())
    result.collisions = std::move(*collisions);
  else
    add_error(result, collisions.error());
  if (auto placement = world.placement()) result.placement = std::move(*placement);
  if (const auto left = world.script_left())
    for (const std::string& entry : *left) {
      result.events.push_back(fmt::format("script: {} did not happen before the job ended", entry));
      log::warn("{}", result.events.back());
    }
  if (!options.out.empty())
    if (auto written = world.write_deposits(fs::absolute(options.out).string() + "/deposits.csv"); !written)
      add_error(result, written.error());
  if (result.collisions.empty() || result.exit_code != ExitCode::Done) return;
  const sim::Collision& first = result.collisions.front();
  add_error(result, {Fault::Collision,
                     fmt::format("the virtual world saw {} collisions, the first of {} with {} at {:.3f} s",
                                 result.collisions.size(), first.moving, first.standing, first.t_s),
                     {}});
}

Result<std::string> job_folder(const std::string& wanted, const std::string& recipe_file) {
  constexpr int kMost = 100000;
  const auto cannot = [&](const fs::path& folder, const std::error_code& error) {
    return fail(wanted.empty() ? Fault::FileUnwritable : Fault::Usage,
                fmt::format("cannot make or clear the folder for results: {}", error.message()), folder.string());
  };
  std::error_code error;
  const fs::path parent = wanted.empty() ? fs::path("out") : fs::path(wanted);
  fs::create_directories(parent, error);
  if (error) return cannot(parent, error);
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

Result<void> write_job(const record::JobResult& result, const std::string& folder) {
  if (auto r = record::write_report(folder, result); !r) return r;
  return record::write_summary(folder, result);
}

}  // namespace gantry::run
