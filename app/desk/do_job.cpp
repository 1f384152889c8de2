#include "app/desk/do_job.hpp"

#include "app/record/job_folder.hpp"
#include "app/record/outcome.hpp"

namespace gantry::desk {

Checked<Prepared> prepare(const config::Machine& machine, const std::string& recipe_file) {
  auto recipe = recipes::load(recipe_file);
  if (!recipe) return tl::unexpected(recipe.error());
  auto job = recipes::compile(*recipe, machine);
  if (!job) return tl::unexpected(job.error());
  auto proof = job::prove_nominal(machine, *recipe, *job);
  return Prepared{std::move(*recipe), std::move(*job), std::move(proof)};
}

Result<JobDone> do_job(const config::Machine& machine, const Prepared& prepared, const run::RunOptions& options,
                       const Bench& bench, const std::string& under) {
  const auto folder = record::job_folder(options.out, prepared.recipe.file, under);
  if (!folder) return tl::unexpected(folder.error());
  JobDone done{record::begin_result(machine, prepared.recipe, prepared.job, *folder, options.dry_run), *folder};
  Result<void> may_run;
  if (!prepared.proof)
    may_run = tl::unexpected(prepared.proof.error());
  else if (bench.bring_up)
    may_run = bench.bring_up();
  if (may_run)
    done.result = bench.owner->run(prepared.recipe, prepared.job, {.out = *folder, .dry_run = options.dry_run});
  else
    record::add_error(done.result, may_run.error());
  if (bench.release) bench.release();
  Result<void> written;
  const auto write = [&] { written = record::write_job(done.result, *folder); };
  if (bench.aside)
    bench.aside(write);
  else
    write();
  if (!written) record::add_error(done.result, written.error());
  return done;
}

}  // namespace gantry::desk
