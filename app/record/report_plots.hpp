// The drawings of the report, each an SVG element that takes its colours from the page.
#pragma once
#include <string>

#include "app/record/job_result.hpp"

namespace gantry::record {

/// The board from above, in its own frame: parts, marks with magnified residuals, touches, planned and actual path,
/// deposits coloured by error, collisions. Empty when the job has no drawing.
std::string top_view(const JobResult& result);
/// Height of the working tool over the board's nominal top against time, with the valve and where the job was stopped.
std::string height_view(const JobResult& result);
/// Following error of an axis over time, with what is allowed; empty where neither is known.
std::string following_view(const AxisResult& axis);
/// Counts on a logarithmic scale over logarithmic time.
std::string histogram_view(const std::vector<HistogramBucket>& buckets);

/// How many times longer than they are residuals of marks are drawn: a round number.
double residual_magnification(const JobResult& result);
/// Colour of an error by its part of what is allowed: calm at 0, orange at 1, red beyond.
std::string error_colour(double part);

}  // namespace gantry::record
