// Files that come with the program: machines, profiles of stations, recipes, schemas. Of an installed program they lie
// in share/gantry beside its bin, of a build in the tree that holds it; else where the build was told to install. What
// lies in the working folder does not replace them.
//   context.machine_file = shipped_file("config/machines/dispenser.yaml");
#pragma once
#include <string>
#include <vector>

#include "config/machine.hpp"
#include "core/error.hpp"

namespace gantry::cli {

/// The folder that holds config/ and recipes/; "" when there is none.
std::string shipped_folder();

/// Where it is looked for when the program is installed, in this order.
std::vector<std::string> installed_folders();

/// A file below it; `relative` itself when there is no such folder.
std::string shipped_file(const std::string& relative);

/// The machine that comes with the program, and is meant where no other is named.
std::string reference_machine();

/// What --machine means: a file, or the name of a machine that comes with the program ("dispenser"; "dispenser.yaml"
/// where no such file lies here). A bare name is the program's own machine whatever lies in the working folder.
std::string machine_file(const std::string& word);

/// The machine in that file. Fault::FileUnreadable where it is not there: where it was looked for, and the nearest
/// that is; else every mistake in it.
Checked<config::Machine> machine_in(const std::string& word);

}  // namespace gantry::cli
