// The address of a Unix socket from its path, for the owner and for its clients.
#pragma once
#include <string>
#include <sys/un.h>

#include "core/error.hpp"

namespace gantry::desk {

/// Fault::FileUnwritable when the path is too long: the system's limit is 107 bytes (unix(7)).
inline Result<sockaddr_un> socket_address(const std::string& path) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (path.size() >= sizeof(address.sun_path))
    return fail(Fault::FileUnwritable,
                "the path is too long for a socket (at most 107 bytes); choose a shorter state folder with --state",
                path);
  path.copy(address.sun_path, path.size());
  return address;
}

}  // namespace gantry::desk
