// write_formats: writes the schemas and the tables of keys. scripts/docs calls it.
#include <filesystem>
#include <fstream>

#include "tests/recipes/made_files.hpp"

int main() {
  for (const gantry::MadeFile& file : gantry::made_files()) {
    const auto path = std::filesystem::path(GANTRY_SOURCE_DIR) / file.path;
    std::filesystem::create_directories(path.parent_path());
    std::ofstream(path) << file.text;
  }
}
