#include "app/record/outcome.hpp"

#include <algorithm>
#include <filesystem>
#include <fmt/format.h>

#include "app/record/drawing.hpp"
#include "app/record/environment.hpp"
#include "app/record/job_folder.hpp"
#include "core/log.hpp"
#include "core/utc_stamp.hpp"

namespace gantry::record {
namespace fs = std::filesystem;

JobResult begin_result(const config::Machine& machine, const recipes::Recipe& recipe, const recipes::Job& job,
                       const std::string& out, bool dry_run) {
  JobResult result;
  if (!out.empty()) result.job = name_of_job(out);
  if (result.job.empty()) result.job = fs::path(recipe.file).stem().string();
  result.recipe_file = recipe.file;
  result.recipe_name = recipe.name;
  result.machine_name = machine.name;
  result.dry_run = dry_run;
  result.started = utc_stamp();
  result.environment = environment_facts();
  result.blocks_total = job.blocks.size();
  result.feature_order = recipes::dispensed_by(job);
  result.features_total = result.feature_order.size();
  result.marks_total = recipe.marks.size();
  result.disturbed = result.features_total < recipe.features.size();
  result.order = recipe.order;
  result.travel = recipes::travel_of(recipe, result.feature_order);
  result.sources = recipe.sources;
  result.fills = recipe.fills;
  result.materials = recipe.materials;
  for (const recipes::Feature& feature : recipe.features) result.feature_names.push_back(recipes::id_of(feature));
  for (const recipes::Feature& feature : recipe.features)
    if (const auto* bead = std::get_if<recipes::Bead>(&feature))
      result.beads.push_back({bead->id, bead->kind, recipes::length_mm(*bead)});
  result.drawing = drawing_of(recipe, machine, job);
  return result;
}

void add_error(JobResult& result, Error error) {
  if (result.exit_code == ExitCode::Done || result.exit_code == ExitCode::DoneWithDefects)
    result.exit_code = info(error.fault).exit_code;
  result.errors.push_back(std::move(error));
}

void not_kept(JobResult& result, const std::string& file, const Error& why) {
  result.not_kept.push_back({file, why.message});
  log::warn("{} is not kept: {}", file, why.message);
}

SeenByWorld ask_world(sim::WorldAccess& world, const std::string& out, sim::WorldAccess::Machine machine) {
  SeenByWorld seen;
  seen.deposits = world.deposits();
  if (!seen.deposits) return seen;  // then it answers nothing else either
  seen.collisions = world.collisions();
  seen.placement = world.placement();
  seen.script_left = world.script_left(machine);
  if (!out.empty()) seen.written = world.write_deposits(out + "/deposits.csv");
  return seen;
}

void add_world(JobResult& result, SeenByWorld seen) {
  if (!seen.deposits) {  // it has been told where it ended the job
    const auto told = [&](const Error& e) { return e.fault == seen.deposits.error().fault; };
    if (std::none_of(result.errors.begin(), result.errors.end(), told)) add_error(result, seen.deposits.error());
    return;
  }
  result.deposits = std::move(*seen.deposits), result.has_world = true;
  if (seen.collisions)
    result.collisions = std::move(*seen.collisions);
  else
    add_error(result, seen.collisions.error());
  if (seen.placement) result.placement = std::move(*seen.placement);
  if (seen.script_left)
    for (const std::string& entry : *seen.script_left) {
      result.events.push_back(fmt::format("script: {} did not happen before the job ended", entry));
      log::warn("{}", result.events.back());
    }
  if (!seen.written) {
    if (seen.written.error().fault == Fault::FileUnwritable)
      not_kept(result, "deposits.csv", seen.written.error());
    else
      add_error(result, seen.written.error());
  }
  if (result.collisions.empty() || result.exit_code != ExitCode::Done) return;
  const sim::Collision& first = result.collisions.front();
  add_error(result, {Fault::Collision,
                     fmt::format("the virtual world saw {} collisions, the first of {} with {} at {:.3f} s",
                                 result.collisions.size(), first.moving, first.standing, first.t_s),
                     {}});
}

}  // namespace gantry::record
