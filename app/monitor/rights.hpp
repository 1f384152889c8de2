// What the publisher gives up before it listens to anybody: a sample from the network may be made to break it, and what
// broke it can then do little.
//   if (auto done = give_up_rights(); !done) return show(done.error());     // before the first thread
#pragma once
#include "core/error.hpp"

namespace gantry::monitor {

inline constexpr unsigned kNobody = 65534;  ///< user and group, on every Linux

/// No capability, no new privileges by starting another program; as root also user and group nobody, no other groups
/// and an empty bounding set. For good. Fault::DdsUnusable when something of it is left, or when there are threads
/// already, which would keep theirs.
Result<void> give_up_rights();

}  // namespace gantry::monitor
