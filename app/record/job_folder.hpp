// Where a job leaves its files.
//   auto folder = job_folder(wanted, recipe_file);   ...   write_job(result, *folder);
#pragma once
#include <string>

#include "app/record/job_result.hpp"

namespace gantry::record {

/// The folder for a job's results, made: `wanted`, cleared of what another job has left in it, or where that is empty
/// the first <under>/<recipe>-<n> that is not there yet. Fault::Usage (a wanted folder cannot be written),
/// FileUnwritable.
Result<std::string> job_folder(const std::string& wanted, const std::string& recipe_file,
                               const std::string& under = "out");

/// report.html, summary.json and the images of the marks. Fault::FileUnwritable.
Result<void> write_job(const JobResult& result, const std::string& folder);

}  // namespace gantry::record
