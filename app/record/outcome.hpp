// A job's result before it begins and after it has ended: what is known beforehand, and what the virtual world adds.
//   auto result = begin_result(machine, recipe, job, out, dry_run);   ...   add_world(result, world, out);
#pragma once
#include <string>

#include "app/record/job_result.hpp"
#include "config/machine.hpp"
#include "sim/world/world_access.hpp"

namespace gantry::record {

/// `out` is the folder for the results, "" where none are kept.
JobResult begin_result(const config::Machine& machine, const recipes::Recipe& recipe, const recipes::Job& job,
                       const std::string& out, bool dry_run);
/// The error counts; the first one gives the exit code, and comes before defects.
void add_error(JobResult& result, Error error);

/// Deposits, collisions and the hidden placement; the world also writes its own deposits.csv to `out`. What cannot be
/// had is added to the result's errors.
void add_world(JobResult& result, sim::WorldAccess& world, const std::string& out);

}  // namespace gantry::record
