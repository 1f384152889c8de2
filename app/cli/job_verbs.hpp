// What `run` and `dry-run` have in common: the recipe, the owner's options, the result.
#pragma once
#include <string>

#include "app/cli/verbs.hpp"
#include "app/record/job_result.hpp"
#include "app/run/owner.hpp"
#include "recipes/job.hpp"

namespace gantry::cli {

struct JobRequest {
  std::string recipe_file;
  std::string out;  ///< folder for the results; "" makes a new one under out/
  run::OwnerOptions owner;
  bool dry_run = false;
};

/// Loads, compiles and proves; brings a machine up, runs the job, writes and shows what became of it. Sets
/// context.exit_code.
void do_job(Context& context, JobRequest request);

}  // namespace gantry::cli
