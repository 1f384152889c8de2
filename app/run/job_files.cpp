#include "app/run/job_files.hpp"

#include <filesystem>
#include <fmt/format.h>
#include <system_error>

#include "app/record/drawing.hpp"
#include "app/record/environment.hpp"
#include "app/record/report.hpp"
#include "app/record/summary.hpp"

namespace gantry::run {
namespace fs = std::filesystem;

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
  result.drawing = record::drawing_of(recipe, machine, job);
  return result;
}

void add_world(record::JobResult& result, sim::WorldAccess& world, const RunOptions& options) {
  const auto complain = [&](const Error& e) {
    result.errors.push_back(e);
    if (result.exit_code == ExitCode::Done) result.exit_code = info(e.fault).exit_code;
  };
  if (auto deposits = world.deposits())
    result.deposits = std::move(*deposits), result.has_world = true;
  else
    complain(deposits.error());
  if (auto collisions = world.collisions())
    result.collisions = std::move(*collisions);
  else
    complain(collisions.error());
  if (auto placement = world.placement()) result.placement = std::move(*placement);
  if (!options.out.empty())
    if (auto written = world.write_deposits(fs::absolute(options.out).string() + "/deposits.csv"); !written)
      complain(written.error());
}

Result<std::string> job_folder(const std::string& wanted, const std::string& recipe_file) {
  constexpr int kMost = 100000;
  const auto cannot = [](const fs::path& folder, const std::error_code& error) {
    return fail(Fault::FileUnwritable, fmt::format("cannot make the folder: {}", error.message()), folder.string());
  };
  std::error_code error;
  const fs::path parent = wanted.empty() ? fs::path("out") : fs::path(wanted);
  fs::create_directories(parent, error);
  if (error) return cannot(parent, error);
  if (!wanted.empty()) return wanted;
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
