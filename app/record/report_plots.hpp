// The drawings of the report, each an SVG element that takes its colours from the page.
#pragma once
#include <string>

#include "app/record/job_result.hpp"

namespace gantry::record {

/// The board from above, in its own frame: parts, marks with magnified residuals, touches, planned and actual path,
/// deposits coloured by error, collisions. Empty when the job has no drawing.
std::string top_view(const JobResult& result);
/// Height of the working tool over the board's nominal top against time, with the valve.
std::string height_view(const JobResult& result);
/// Counts on a logarithmic scale over logarithmic time.
std::string histogram_view(const std::vector<HistogramBucket>& buckets);

/// Colour of an error: calm at 0, orange at the limit, red beyond it.
std::string error_colour(double error_mm);
/// What the colours are scaled to.
inline constexpr double kErrorLimit_mm = 0.020;

}  // namespace gantry::record
