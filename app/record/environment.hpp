// What a reader of a report needs to know of the computer that ran the job: figures of timing mean nothing without it.
#pragma once
#include <vector>

#include "app/record/job_result.hpp"

namespace gantry::record {

/// Program version, host, kernel, processor, memory. Reads /proc; leaves out what it cannot read.
std::vector<Fact> environment_facts();

}  // namespace gantry::record
