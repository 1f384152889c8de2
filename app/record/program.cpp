#include "app/record/program.hpp"

#include <gantry_commit.hpp>

namespace gantry::record {

std::string program_version() { return GANTRY_VERSION; }
std::string program_commit() { return GANTRY_COMMIT; }

}  // namespace gantry::record
