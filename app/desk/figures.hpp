// What a terminal shows of a job, while it runs and when it has ended: the same words whoever did the job, the owner in
// this process or another one.
#pragma once
#include <optional>
#include <string>

#include "app/record/job_result.hpp"
#include "app/run/owner.hpp"

namespace gantry::desk {

/// Several lines without the last newline: the result, then offset, deposits, cycles, hash.
std::string figures(const record::JobResult& result);

/// About how long a job will still take: `duration_s` of planned motion, as far as its features are not done. Nothing
/// before the first feature is known of.
std::optional<double> remaining_s(double duration_s, const run::Progress& progress, double override_factor);

}  // namespace gantry::desk
