#include "app/cli/file_kind.hpp"

#include <algorithm>
#include <utility>

#include "config/formats.hpp"
#include "recipes/recipe_file.hpp"

namespace gantry::cli {

FileKind kind_of(const std::string& path) {
  const auto text = config::read_text_file(path);
  config::Mistakes ignored(path);
  const auto root = text ? config::read_yaml(*text, ignored) : std::nullopt;
  if (!root) return FileKind::Recipe;
  if (root->kind == config::Node::Kind::Sequence || root->find("do") != nullptr) return FileKind::Script;
  FileKind best = FileKind::Recipe;
  std::ptrdiff_t most = 0;
  for (const auto& [kind, format] : {std::pair{FileKind::Recipe, &recipes::recipe_format()},
                                     {FileKind::Machine, &config::machine_format()},
                                     {FileKind::Profile, &config::profile_format()}}) {
    const auto known = std::count_if(format->begin(), format->end(),
                                     [&](const config::FieldShape& field) { return root->find(field.key) != nullptr; });
    if (known > most) best = kind, most = known;
  }
  return best;
}

}  // namespace gantry::cli
