#include "tests/recipes/made_files.hpp"

#include "config/formats.hpp"
#include "config/schema.hpp"
#include "recipes/recipe_file.hpp"

namespace gantry {
namespace {

/// The page with its table of keys written anew, between the lines <!-- keys --> and <!-- end of keys -->.
std::string with_table(const std::string& path, const std::string& table) {
  const std::string page = config::read_text_file(std::string(GANTRY_SOURCE_DIR "/") + path).value_or("");
  const std::string open = "<!-- keys -->\n", close = "<!-- end of keys -->";
  const auto from = page.find(open), to = page.find(close);
  if (from == std::string::npos || to == std::string::npos) return "the marks are missing";
  return page.substr(0, from + open.size()) + table + page.substr(to);
}

}  // namespace

std::vector<MadeFile> made_files() {
  using config::json_schema;
  using config::key_table;
  return {
      {"config/schema/machine.schema.json", json_schema("gantry machine", config::machine_format())},
      {"config/schema/profile.schema.json", json_schema("gantry station profile", config::profile_format())},
      {"recipes/schema/recipe.schema.json", json_schema("gantry recipe", recipes::recipe_format())},
      {"docs/machine.md", with_table("docs/machine.md", key_table(config::machine_format()))},
      {"docs/recipe.md", with_table("docs/recipe.md", key_table(recipes::recipe_format()))},
  };
}

}  // namespace gantry
