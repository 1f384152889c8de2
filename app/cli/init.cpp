// gantry init DIR: a machine and a recipe to start from, copied from what comes with the program.
#include <algorithm>
#include <filesystem>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "app/cli/shipped.hpp"
#include "app/cli/terminal.hpp"
#include "app/cli/verbs.hpp"
#include "config/yaml.hpp"
#include "core/absolute_path.hpp"
#include "core/new_file.hpp"
#include "core/shell_words.hpp"

namespace gantry::cli {
namespace {

namespace fs = std::filesystem;

constexpr const char* kMachine = "config/machines/dispenser.yaml";
constexpr const char* kRecipe = "recipes/demo-board.yaml";
/// Whole folders: profiles, and schemas for editors.
constexpr const char* kFolders[] = {"config/drives", "config/devices", "config/schema", "recipes/schema"};

/// What is to be copied, relative to both folders.
Result<std::vector<std::string>> files_to_copy(const fs::path& from) {
  std::vector<std::string> files{kMachine, kRecipe};
  for (const char* folder : kFolders) {
    std::error_code error;
    for (const auto& entry : fs::directory_iterator(from / folder, error))
      if (entry.is_regular_file(error)) files.push_back(fs::path(folder) / entry.path().filename());
    if (error)
      return fail(Fault::FileUnreadable, fmt::format("cannot be read ({})", error.message()), (from / folder).string());
  }
  std::sort(files.begin() + 2, files.end());
  return files;
}

tl::unexpected<Error> cannot_be_written(const fs::path& path, const std::error_code& error) {
  return fail(Fault::Usage, fmt::format("cannot be written ({})", error.message()), path.string());
}

tl::unexpected<Error> is_there_already(const fs::path& file) {
  return fail(Fault::Refused, "is there already and is not overwritten; name another folder", file.string());
}

/// Nothing stands where this file is to be written, or where one of the folders down to it is.
Result<void> is_free(const fs::path& file) {
  fs::path at;
  for (const fs::path& step : file) {
    at /= step;
    const bool is_folder = at != file;
    std::error_code error;
    const fs::file_type found = fs::symlink_status(at, error).type();
    if (found == fs::file_type::not_found) return {};
    if (found == fs::file_type::none)  // nobody lets it be seen
      return cannot_be_written(at, error);
    if (!is_folder) return is_there_already(at);
    if (!fs::is_directory(at, error))  // a link may lead to one
      return fail(Fault::Refused, "is there already and is no folder; name another folder", at.string());
  }
  return {};
}

/// Files and folders that were not there before; what it has made is gone when it goes, unless it is kept.
class Made {
 public:
  Made() = default;
  Made(const Made&) = delete;
  Made& operator=(const Made&) = delete;
  ~Made() {
    std::error_code ignored;
    for (auto each = made_.rbegin(); each != made_.rend(); ++each) fs::remove(*each, ignored);
  }
  void keep() { made_.clear(); }

  Result<void> folder(const fs::path& path) {
    std::error_code error;
    if (path.empty() || fs::is_directory(path, error)) return {};
    if (auto above = folder(path.parent_path()); !above) return above;
    if (fs::create_directory(path, error)) made_.push_back(path);
    if (error) return cannot_be_written(path, error);
    return {};
  }
  Result<void> copy(const fs::path& from, const fs::path& to) {
    std::error_code error;
    if (fs::exists(fs::symlink_status(to, error))) return is_there_already(to);
    const auto text = config::read_text_file(from.string());
    if (!text) return tl::unexpected(text.error());
    made_.push_back(to);
    if (auto written = write_new_file(to.string(), *text); !written)
      return fail(Fault::Usage, written.error().message, written.error().where);
    return {};
  }

 private:
  std::vector<fs::path> made_;
};

/// Nothing is written unless all of it can be: a file that is there already is not overwritten, and what a failure
/// leaves half is taken away.
Result<std::vector<std::string>> copy_to(const fs::path& folder) {
  const std::string from = shipped_folder();
  if (from.empty())
    return fail(Fault::FileUnreadable,
                fmt::format("the files that come with gantry are not there; looked for in {}",
                            fmt::join(installed_folders(), " and ")),
                "");
  const auto files = files_to_copy(from);
  if (!files) return files;
  if (auto ours = no_foreign_link(folder.string()); !ours) return tl::unexpected(ours.error());
  for (const std::string& file : *files)
    if (auto free = is_free(folder / file); !free) return tl::unexpected(free.error());
  Made made;
  for (const std::string& file : *files) {
    if (auto done = made.folder((folder / file).parent_path()); !done) return tl::unexpected(done.error());
    if (auto done = made.copy(fs::path(from) / file, folder / file); !done) return tl::unexpected(done.error());
  }
  made.keep();
  return files;
}

}  // namespace

void add_init(CLI::App& app, Context& context) {
  auto* verb = app.add_subcommand("init", "Copies a working machine and a recipe into a folder, to start from");
  auto folder = std::make_shared<std::string>();
  verb->add_option("DIR", *folder, "Where to; it is made when it is not there")->required();
  verb->callback([&context, folder] {
    const auto whole = absolute_path(*folder);
    if (!whole) return void(context.exit_code = show(whole.error(), context.json));
    const auto files = copy_to(*folder);
    if (!files) return void(context.exit_code = show(files.error(), context.json));
    const std::vector<std::string> next{fmt::format("cd {}", shell_word(*folder)),
                                        fmt::format("gantry --machine {} check {}", kMachine, kRecipe),
                                        fmt::format("gantry --machine {} dry-run {}", kMachine, kRecipe),
                                        fmt::format("gantry --machine {} run {}", kMachine, kRecipe)};
    if (context.json) {
      return show_document(
          "ok", {{"folder", fs::path(*whole).lexically_normal().string()}, {"files", *files}, {"next", next}});
    }
    print_text(
        "{}: {} files\n  {}  the machine: axes, stations, limits, scene\n  {}         a recipe for it\n"
        "  config/drives, config/devices   profiles of its stations\nNext:\n",
        *folder, files->size(), kMachine, kRecipe);
    for (const std::string& line : next) print_text("  {}\n", line);
  });
}

}  // namespace gantry::cli
