#include "app/record/write_file.hpp"

#include <filesystem>

#include "core/new_file.hpp"

namespace gantry::record {

Result<void> write_file(const std::string& path, std::string_view bytes) {
  if (const std::filesystem::path above = std::filesystem::path(path).parent_path(); !above.empty())
    if (auto made = make_folder(above.string()); !made) return made;
  return write_new_file(path, bytes);
}

}  // namespace gantry::record
