// A name as it is from every folder.
//   auto out = absolute_path("out/demo");   // "/srv/line-3/out/demo" where one stands in /srv/line-3
#pragma once
#include <string>

#include "core/error.hpp"

namespace gantry {

/// `path` from /; "" of "". Fault::Usage where it is seen from a working folder that was deleted.
Result<std::string> absolute_path(const std::string& path);

}  // namespace gantry
