// The project's own files, read as text: what the checks of this folder look at.
#pragma once
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

namespace gantry::architecture {

struct SourceFile {
  std::string path;  ///< from the root of the tree, with '/'
  std::string text;
};

inline std::string read(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// All files of the project: everything but what is built, written by runs, or belongs to git.
inline std::vector<SourceFile> source_tree() {
  const std::filesystem::path root = GANTRY_SOURCE_DIR;
  std::vector<SourceFile> files;
  for (auto it = std::filesystem::recursive_directory_iterator(root); it != std::filesystem::end(it); ++it) {
    const std::string path = it->path().lexically_relative(root).generic_string();
    if (path == "build" || path == "out" || path == "state" || path == ".git" || path == ".cache") {
      if (it->is_directory()) it.disable_recursion_pending();
      continue;
    }
    if (it->is_regular_file()) files.push_back({path, read(it->path())});
  }
  return files;
}

inline bool is_code(const SourceFile& file) {
  const auto ends = [&](std::string_view end) { return file.path.ends_with(end); };
  return ends(".cpp") || ends(".hpp") || ends(".c") || ends(".h");
}

/// True when `path` is `room` or lies in it.
inline bool within(std::string_view path, std::string_view room) {
  return path == room || (path.starts_with(room) && path[room.size()] == '/');
}

/// Rows of the block ```name of a page, each split at blanks; '#' opens a comment.
inline std::vector<std::vector<std::string>> table(const std::string& page, std::string_view name) {
  std::vector<std::vector<std::string>> rows;
  std::istringstream lines(page);
  bool inside = false;
  for (std::string line; std::getline(lines, line);) {
    if (line == "```" + std::string(name)) {
      inside = true;
    } else if (line == "```") {
      inside = false;
    } else if (inside) {
      std::istringstream words(line.substr(0, line.find('#')));
      std::vector<std::string> row{std::istream_iterator<std::string>(words), {}};
      if (!row.empty()) rows.push_back(std::move(row));
    }
  }
  return rows;
}

/// Path between quotes or angles of each #include of a text.
struct Include {
  std::string path;
  int line = 0;
  bool angled = false;
};
inline std::vector<Include> includes(const std::string& text) {
  std::vector<Include> found;
  std::istringstream lines(text);
  int number = 0;
  for (std::string line; std::getline(lines, line);) {
    ++number;
    std::istringstream words(line);
    std::string directive, target;
    words >> directive >> target;
    if (directive == "#") words >> directive >> target;
    if (directive != "#include" || target.size() < 3) continue;
    const auto end = target.find_first_of("\">", 1);
    found.push_back({target.substr(1, end - 1), number, target[0] == '<'});
  }
  return found;
}

}  // namespace gantry::architecture
