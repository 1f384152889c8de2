// Which program this is.
#pragma once
#include <string>

namespace gantry::record {

std::string program_version();  ///< "0.1.0"
/// What was built: the commit's first 12 digits, "-dirty" behind them where files had been changed; "unknown" where it
/// was built outside a repository.
std::string program_commit();

}  // namespace gantry::record
