// The sections of the report that are text and tables. Each returns HTML, or nothing when the job has nothing to say
// there.
#pragma once
#include <string>

#include "app/record/job_result.hpp"

namespace gantry::record {

std::string headline(const JobResult& result);
std::string tiles(const JobResult& result);
std::string error_section(const JobResult& result);
std::string defect_section(const JobResult& result);
std::string finish_section(const JobResult& result);
std::string joined_section(const JobResult& result);
std::string mark_section(const JobResult& result);
std::string height_section(const JobResult& result);
std::string deposit_section(const JobResult& result);
std::string length_section(const JobResult& result);
std::string speed_section(const JobResult& result);
std::string times_section(const JobResult& result);
std::string recipe_section(const JobResult& result);
std::string following_section(const JobResult& result);
std::string cycle_section(const JobResult& result);
std::string operator_section(const JobResult& result);
std::string event_section(const JobResult& result);
std::string fact_section(const JobResult& result);

}  // namespace gantry::record
