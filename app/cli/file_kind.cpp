#include "app/cli/file_kind.hpp"

#include <algorithm>
#include <utility>

#include "config/formats.hpp"
#include "config/text_lines.hpp"
#include "recipes/recipe_file.hpp"

namespace gantry::cli {
namespace {

/// Of a file that is not well-formed: what stands before a colon where lines begin.
std::vector<std::string> keys_by_lines(std::string_view text) {
  const config::TextLines lines(text);
  std::vector<std::string> keys;
  for (std::size_t n = 0; n < lines.count(); ++n)
    if (lines.says_something(n) && lines.indent(n) == 0)
      keys.emplace_back(lines.line(n).substr(0, lines.line(n).find(':')));
  return keys;
}

std::vector<std::string> keys_of(const config::Node& root) {
  std::vector<std::string> keys;
  for (const config::Node::Key& key : root.keys) keys.push_back(key.text);
  return keys;
}

}  // namespace

FileKind kind_of(const std::string& path) {
  const auto text = config::read_text_file(path);
  if (!text) return FileKind::Recipe;
  config::Mistakes ignored(path);
  const auto root = config::read_yaml(*text, ignored);
  const std::vector<std::string> keys = root ? keys_of(*root) : keys_by_lines(*text);
  const auto has = [&](std::string_view key) { return std::ranges::find(keys, key) != keys.end(); };
  if (root && (root->kind == config::Node::Kind::Sequence || has("do"))) return FileKind::Script;
  FileKind best = FileKind::Recipe;
  std::ptrdiff_t most = 0;
  for (const auto& [kind, format] : {std::pair{FileKind::Recipe, &recipes::recipe_format()},
                                     {FileKind::Machine, &config::machine_format()},
                                     {FileKind::Profile, &config::profile_format()}}) {
    const auto known =
        std::count_if(format->begin(), format->end(), [&](const config::FieldShape& field) { return has(field.key); });
    if (known > most) best = kind, most = known;
  }
  return best;
}

}  // namespace gantry::cli
