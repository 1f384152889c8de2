// gantry check [FILE...]: machine and recipe files, every mistake at once.
#include <filesystem>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "app/cli/verbs.hpp"
#include "recipes/job.hpp"

namespace gantry::cli {

void add_check(CLI::App& app, Context& context) {
  auto* verb = app.add_subcommand("check", "Machine and recipe files: every mistake at once, file:line:col");
  auto files = std::make_shared<std::vector<std::string>>();
  verb->add_option("FILE", *files, "Recipes; without one only the machine file is checked");
  verb->callback([&context, files] {
    const auto machine = load_machine(context);
    if (!machine) return;
    std::vector<Error> errors;
    nlohmann::ordered_json checked = nlohmann::json::array({context.machine_file});
    for (const std::string& file : *files) {
      checked.push_back(file);
      auto recipe = recipes::load(file);
      if (!recipe) {
        errors.insert(errors.end(), recipe.error().begin(), recipe.error().end());
        continue;
      }
      if (auto job = recipes::compile(*recipe, *machine); !job)
        errors.insert(errors.end(), job.error().begin(), job.error().end());
    }
    if (!errors.empty()) {
      context.exit_code = show(errors, context.json);
      return;
    }
    const auto notes = config::notes(*machine);
    if (context.json) {
      fmt::print("{}\n", nlohmann::ordered_json{{"result", "ok"}, {"checked", checked}, {"notes", notes}}.dump(2));
      return;
    }
    fmt::print("{}: {} axes, {} stations\n", context.machine_file, machine->axes.size(), machine->stations.size());
    for (const std::string& file : *files) fmt::print("{}: ok\n", file);
    for (const std::string& note : notes) fmt::print("  note: {}\n", note);
  });
}

}  // namespace gantry::cli
