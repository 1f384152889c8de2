// What a terminal shows of a job, while it runs and when it has ended: the same words whoever did the job, the owner in
// this process or another one.
#pragma once
#include <string>

#include "app/record/job_result.hpp"

namespace gantry::desk {

/// Several lines without the last newline: the result, then offset, deposits, cycles, hash.
std::string figures(const record::JobResult& result);

}  // namespace gantry::desk
