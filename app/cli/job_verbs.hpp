// What `run` and `dry-run` have in common: the recipe, the owner's options, the result.
#pragma once
#include <string>

#include "app/cli/verbs.hpp"
#include "app/record/job_result.hpp"
#include "app/run/owner.hpp"
#include "recipes/selection.hpp"

namespace gantry::cli {

/// What it refuses, before it knows more, leaves the board untouched; so do mistakes of its command line.
void does_a_job(CLI::App& verb, Context& context);

inline constexpr const char* kSerialHelp = "Serial number of the part: for the result, and to know it again";

struct JobRequest {
  std::string recipe_file;
  recipes::Selection select;
  std::string serial;
  std::string certificate;  ///< that the job must match; "": none is demanded
  std::string out;          ///< folder for the results; "" makes a new one under out/
  bool force = false;       ///< what another job has left in it may be overwritten
  run::OwnerOptions owner;
  record::SameMachine same_machine{};
  bool dry_run = false;
};

/// --out and --force.
void add_folder(CLI::App& verb, JobRequest& request);
/// --from and --only.
void add_selection(CLI::App& verb, recipes::Selection& select);

/// Loads, compiles and proves; brings a machine up, runs the job, writes and shows what became of it. Sets
/// context.exit_code.
void do_job(Context& context, JobRequest request);

}  // namespace gantry::cli
