// A file that is not there: which part of its path is wrong, and what is there that may be meant.
//   if (errno == ENOENT) return fail(Fault::FileUnreadable, missing_in_words("recipes/demo-bord.yaml"), path);
//   // "there is no such file; did you mean 'recipes/demo-board.yaml'?"
#pragma once
#include <string>
#include <string_view>
#include <vector>

namespace gantry {

/// Of a path that leads to nothing: the first part that is not there, with the nearest name that is; or the link that
/// leads nowhere.
std::string missing_in_words(const std::string& path);

/// The nearest of these names of files; a word without an ending is meant with any. Empty when none is near.
std::string_view nearest_file(std::string_view word, const std::vector<std::string>& names);

}  // namespace gantry
