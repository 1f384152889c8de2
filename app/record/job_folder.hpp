// Where a job leaves its files.
//   auto folder = job_folder({.path = "out/first"}, recipe_file);   ...   write_job(result, *folder);
#pragma once
#include <string>

#include "app/record/job_result.hpp"

namespace gantry::record {

struct WantedFolder {
  std::string path{};  ///< empty: the first <under>/<recipe>-<n> behind all that are there
  std::string under = "out";
  bool overwrite = false;  ///< what another job has left in `path` goes; nothing else does
};

/// The folder for a job's results, made. Fault::Usage (a wanted folder cannot be written, or holds a job),
/// FileUnwritable.
Result<std::string> job_folder(const WantedFolder& wanted, const std::string& recipe_file);

/// report.html, summary.json and the images of the marks. Fault::FileUnwritable.
Result<void> write_job(const JobResult& result, const std::string& folder);

}  // namespace gantry::record
