// A file that appears whole or not at all, however the program ends.
//   write_file("out/job/summary.json", text);
#pragma once
#include <string>
#include <string_view>

#include "core/error.hpp"

namespace gantry::record {

/// Writes beside the target and renames; makes missing folders. Fault::FileUnwritable.
Result<void> write_file(const std::string& path, std::string_view bytes);

}  // namespace gantry::record
