// Every network socket that this process makes is bound to one device before it can have an address: nothing that comes
// in by another device is ever received, and nothing leaves by one.
//   confine_sockets("lo");         // before DDS is set up
//   check_sockets("lo");           // after it: what it has made is confined indeed
// Cyclone DDS 0.10 has no setting for this, so the program has a socket() of its own, which DDS's library finds before
// the system's (docs/decisions/010). A process that has confined nothing gets plain sockets from it.
#pragma once
#include <string>

#include "core/error.hpp"

namespace gantry::monitor {

/// For good, and for all threads: a second device is refused with Fault::Refused. Also Fault::DdsUnusable when this
/// system binds no socket to it: from then on socket() fails rather than give a socket that is open to others.
Result<void> confine_sockets(const std::string& device);
/// Fault::DdsUnusable when a network socket of this process is not bound to `device`.
Result<void> check_sockets(const std::string& device);

}  // namespace gantry::monitor
