// What a person may type next, as a shell takes it, on the machine of the job.
#pragma once
#include <string>

#include "app/record/job_result.hpp"

namespace gantry::record {

/// "gantry run board.yaml --only dam --serial A7 --machine cell.yaml"; "" where nothing of the board is left.
std::string finish_command(const JobResult& result);

/// "gantry part-removed --serial A7 --machine cell.yaml"
std::string part_removed_command(const JobResult& result);

}  // namespace gantry::record
