// A job result with something of everything, for the tests of summary and report. Not from a machine.
#pragma once
#include "app/record/job_result.hpp"

namespace gantry::record {
JobResult made_up_job();
/// The same job, stopped by a drive's fault half way.
JobResult made_up_failure();
}  // namespace gantry::record
