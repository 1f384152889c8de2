// When something happened, for files and people: ISO 8601, in UTC, to the millisecond.
#pragma once
#include <string>

namespace gantry {

/// Now, as "2026-11-21T08:30:16.123Z".
std::string utc_stamp();

}  // namespace gantry
