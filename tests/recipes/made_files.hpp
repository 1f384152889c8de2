// Files that are made from the tables of fields: JSON Schemas, and the tables of keys in docs/recipe.md and
// docs/machine.md. write_formats writes them (scripts/docs calls it), a test compares them.
#pragma once
#include <string>
#include <vector>

namespace gantry {

struct MadeFile {
  std::string path;  ///< from the root of the project
  std::string text;
};

/// What each of them must hold. Pages keep their own words: only what stands between their marks is made.
std::vector<MadeFile> made_files();

}  // namespace gantry
