// What a file that is named on the command line is meant to be.
//   if (kind_of("portal.yaml") == FileKind::Machine) ...
#pragma once
#include <string>

namespace gantry::cli {

enum class FileKind { Recipe, Machine, Profile, Script };

/// What a file is meant to be: the format that knows most of its keys; a list, or what is to be done, is a script for
/// the world. What cannot be read is taken for a recipe, whose reader tells why.
FileKind kind_of(const std::string& path);

}  // namespace gantry::cli
