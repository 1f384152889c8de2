// A job's result from its first line to the files that it leaves: what is known before it starts, what the virtual
// world adds, and the folder.
//   auto result = begin_result(machine, recipe, job, options);   ...   write_job(result, options.out);
#pragma once
#include <string>

#include "app/record/job_result.hpp"
#include "app/run/owner.hpp"

namespace gantry::run {

record::JobResult begin_result(const config::Machine& machine, const recipes::Recipe& recipe, const recipes::Job& job,
                               const RunOptions& options);
/// The error counts; the first one gives the exit code.
void add_error(record::JobResult& result, Error error);

/// Deposits, collisions and the hidden placement; the world also writes its own deposits.csv. What cannot be had is
/// added to the result's errors.
void add_world(record::JobResult& result, sim::WorldAccess& world, const RunOptions& options);

/// The folder for a job's results, made: `wanted`, cleared of what another job has left in it, or where that is empty
/// the first out/<recipe>-<n> that is not there yet. Fault::Usage (a wanted folder cannot be written), FileUnwritable.
Result<std::string> job_folder(const std::string& wanted, const std::string& recipe_file);

/// report.html, summary.json and the images of the marks. Fault::FileUnwritable.
Result<void> write_job(const record::JobResult& result, const std::string& folder);

}  // namespace gantry::run
