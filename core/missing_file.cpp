#include "core/missing_file.hpp"

#include <algorithm>
#include <filesystem>
#include <fmt/format.h>

#include "core/near_word.hpp"

namespace gantry {
namespace {

namespace fs = std::filesystem;

/// Names of the folders, or of all else, in a folder.
std::vector<std::string> names_in(const fs::path& folder, bool folders) {
  std::vector<std::string> names;
  std::error_code error;
  for (auto at = fs::directory_iterator(folder.empty() ? "." : folder, error); !error && at != fs::directory_iterator();
       at.increment(error)) {
    std::error_code ignored;
    if (at->is_directory(ignored) == folders) names.push_back(at->path().filename().string());
  }
  std::sort(names.begin(), names.end());
  return names;
}

std::string meant(const fs::path& folder, std::string_view name) {
  return name.empty() ? "" : "; " + did_you_mean((folder / name).string());
}

}  // namespace

std::string_view nearest_file(std::string_view word, const std::vector<std::string>& names) {
  const std::string_view whole = nearest(word, {names.begin(), names.end()});
  if (!whole.empty()) return whole;
  std::vector<std::string> stems;
  for (const std::string& name : names) stems.push_back(fs::path(name).stem().string());
  const std::string_view stem = nearest(fs::path(word).stem().string(), {stems.begin(), stems.end()});
  const auto found = std::find(stems.begin(), stems.end(), stem);
  return stem.empty() ? stem : std::string_view(names[static_cast<std::size_t>(found - stems.begin())]);
}

std::string missing_in_words(const std::string& path) {
  fs::path there;
  for (const fs::path& part : fs::path(path).parent_path()) {
    std::error_code ignored;
    const fs::path next = there / part;
    const bool exists = fs::exists(next, ignored);
    if (exists && !fs::is_directory(next, ignored)) return fmt::format("'{}' is no folder", next.string());
    if (!exists) {
      const std::vector<std::string> folders = names_in(there, true);
      return fmt::format("there is no folder '{}'{}", next.string(),
                         meant(there, nearest(part.string(), {folders.begin(), folders.end()})));
    }
    there = next;
  }
  std::error_code ignored;
  if (fs::is_symlink(path, ignored))
    return fmt::format("it is a link to '{}', which is not there", fs::read_symlink(path, ignored).string());
  const std::string name = fs::path(path).filename().string();
  const std::vector<std::string> files = names_in(there, false);
  const std::string near = meant(there, nearest_file(name, files));
  if (!near.empty()) return "there is no such file" + near;
  return there.empty() ? "there is no such file in this folder"
                       : fmt::format("there is no such file in '{}'", there.string());
}

}  // namespace gantry
