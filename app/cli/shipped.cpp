#include "app/cli/shipped.hpp"

#include <algorithm>
#include <filesystem>
#include <fmt/format.h>

#include "app/cli/file_kind.hpp"
#include "config/yaml.hpp"
#include "core/missing_file.hpp"
#include "core/near_word.hpp"

namespace gantry::cli {
namespace {

namespace fs = std::filesystem;

constexpr const char* kMachines = "config/machines";

/// Where the program's file lies; a link to it is followed.
fs::path folder_of_program() {
  std::error_code ignored;
  return fs::read_symlink("/proc/self/exe", ignored).parent_path();
}

bool holds_machines(const fs::path& folder) {
  std::error_code ignored;
  return fs::is_directory(folder / kMachines, ignored);
}

/// Recipes lie beside them.
std::vector<std::string> machines_in(const fs::path& folder) {
  std::vector<std::string> names;
  for (const std::string& stem : config::yaml_files_in(folder.string()))
    if (kind_of((folder / (stem + ".yaml")).string()) == FileKind::Machine) names.push_back(stem + ".yaml");
  return names;
}

}  // namespace

std::vector<std::string> installed_folders() {
  return {(folder_of_program() / ".." / "share" / "gantry").lexically_normal().string(), GANTRY_DATA_DIR};
}

std::string shipped_folder() {
  const auto installed = installed_folders();
  if (holds_machines(installed[0])) return installed[0];
  for (fs::path at = folder_of_program(); at.has_relative_path(); at = at.parent_path())
    if (holds_machines(at)) return at.string();
  return holds_machines(installed[1]) ? installed[1] : "";
}

std::string shipped_file(const std::string& relative) {
  const std::string folder = shipped_folder();
  // Where none came with the program, the one that would have: never one that happens to lie where one stands.
  return (fs::path(folder.empty() ? GANTRY_DATA_DIR : folder) / relative).string();
}

std::string reference_machine() { return shipped_file("config/machines/dispenser.yaml"); }

std::string machine_file(const std::string& word) {
  std::error_code ignored;
  const bool path = fs::path(word).has_parent_path() || fs::path(word).has_extension();
  if (path && (fs::exists(word, ignored) || fs::path(word).has_parent_path())) return word;
  for (const char* ending : {"", ".yaml"})
    if (const fs::path shipped = shipped_file(std::string(kMachines) + "/" + word + ending);
        fs::is_regular_file(shipped, ignored))
      return shipped.string();
  return word;
}

namespace {

Error no_machine_file(const std::string& word) {
  std::error_code ignored;
  const fs::path asked = fs::absolute(word, ignored).lexically_normal();
  std::vector<std::string> looked{asked.parent_path().string()}, names = machines_in(asked.parent_path());
  if (word.find('/') == std::string::npos) {
    if (const std::string shipped = shipped_folder(); !shipped.empty()) {
      looked.push_back((fs::path(shipped) / kMachines).string());
    } else {
      for (const std::string& folder : installed_folders()) looked.push_back(folder + "/" + kMachines);
    }
    // A name without an ending is that of a machine that comes with the program.
    for (std::size_t i = 1; i < looked.size(); ++i)
      for (const std::string& name : machines_in(looked[i]))
        names.push_back(asked.has_extension() ? name : fs::path(name).stem().string());
  }
  const std::string name = asked.filename().string();
  const std::string_view near = nearest_file(name, names);
  return {Fault::FileUnreadable,
          fmt::format("there is no machine file '{}'; looked for in {}; {}", name, fmt::join(looked, " and "),
                      near.empty() ? did_you_mean(name, {names.begin(), names.end()}) : did_you_mean(near)),
          word};
}

}  // namespace

Checked<config::Machine> machine_in(const std::string& word) {
  std::error_code ignored;  // a link that leads nowhere is there, and reading it says what is wrong with it
  if (!fs::exists(fs::symlink_status(word, ignored))) return tl::unexpected(std::vector{no_machine_file(word)});
  return config::load_machine(word);
}

}  // namespace gantry::cli
