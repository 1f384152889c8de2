// report.html: a job's result for people. One file that needs nothing else: style, drawings, images and the scene's
// scripts are inside, and nothing is fetched. Follows the reader's light or dark setting.
//   write_report("out/job", result);    // report.html, and the marks' images under out/job/marks/
#pragma once
#include <string>

#include "app/record/job_result.hpp"
#include "core/error.hpp"

namespace gantry::record {

/// The whole page.
std::string report_page(const JobResult& result);

/// Fault::FileUnwritable.
Result<void> write_report(const std::string& dir, const JobResult& result);

}  // namespace gantry::record
