#include "core/absolute_path.hpp"

#include <filesystem>

namespace gantry {

Result<std::string> absolute_path(const std::string& path) {
  if (path.empty()) return path;
  std::error_code gone;
  const std::filesystem::path whole = std::filesystem::absolute(path, gone);
  if (!gone) return whole.string();
  return fail(Fault::Usage,
              "the folder that this program stands in was deleted: go to one that exists (cd), or give names from / on",
              path);
}

}  // namespace gantry
