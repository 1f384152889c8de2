// A job's result before it begins and after it has ended: what is known beforehand, and what the virtual world adds.
//   auto result = begin_result(machine, recipe, job, out, dry_run);   ...
//   add_world(result, ask_world(world, out, sim::WorldAccess::Machine::Ends));
#pragma once
#include <string>
#include <vector>

#include "app/record/job_result.hpp"
#include "config/machine.hpp"
#include "core/error.hpp"
#include "sim/world/world_access.hpp"

namespace gantry::record {

/// `out` is the folder for the results, "" where none are kept.
JobResult begin_result(const config::Machine& machine, const recipes::Recipe& recipe, const recipes::Job& job,
                       const std::string& out, bool dry_run);
/// The error counts; the first one gives the exit code, and comes before defects.
void add_error(JobResult& result, Error error);
/// A file of its folder could not be written: told at once and in the result. The job is as good as without.
void not_kept(JobResult& result, const std::string& file, const Error& why);

/// What a job came to as the virtual world saw it.
struct SeenByWorld {
  Result<std::vector<Deposit>> deposits;
  Result<std::vector<sim::Collision>> collisions;
  Result<std::string> placement;
  Result<std::vector<std::string>> script_left;
  Result<void> written;
};

/// Waits for the world, which also writes its own deposits.csv to `out`, unless that is "". `machine`: what becomes of
/// the simulated machine when the job is over.
SeenByWorld ask_world(sim::WorldAccess& world, const std::string& out, sim::WorldAccess::Machine machine);
/// What the world could not tell is added to the result's errors.
void add_world(JobResult& result, SeenByWorld seen);

}  // namespace gantry::record
