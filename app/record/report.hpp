// report.html: a job's result for people. One file that needs nothing else: style, drawings, images and the scene's
// scripts are inside, and nothing is fetched. Follows the reader's light or dark setting.
//   write_report("out/job", result);   write_image("out/job", image_names(result)[0], result.marks[0]);
#pragma once
#include <string>
#include <vector>

#include "app/record/job_result.hpp"
#include "core/error.hpp"

namespace gantry::record {

/// The whole page.
std::string report_page(const JobResult& result);

/// report.html. Fault::FileUnwritable.
Result<void> write_report(const std::string& dir, const JobResult& result);

/// Under which names the images of the marks stand in the job's folder, one a mark: "marks/front-left.png"; "" of a
/// mark without one.
std::vector<std::string> image_names(const JobResult& result);
/// Fault::FileUnwritable.
Result<void> write_image(const std::string& dir, const std::string& name, const MarkResult& mark);

}  // namespace gantry::record
