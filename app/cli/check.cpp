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
    auto notes = config::notes(*machine);
    const auto assumed = config::assumptions(*machine);
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
      for (const std::string& note : recipes::notes(*recipe, *machine)) notes.push_back(file + ": " + note);
    }
    if (!errors.empty()) {
      context.exit_code = show(errors, context.json);
      return;
    }
    if (context.json) {
      fmt::print(
          "{}\n",
          nlohmann::ordered_json{{"result", "ok"}, {"checked", checked}, {"notes", notes}, {"assumptions", assumed}}
              .dump(2));
      return;
    }
    fmt::print("{}: {} axes, {} stations\n", context.machine_file, machine->axes.size(), machine->stations.size());
    for (const std::string& file : *files) fmt::print("{}: ok\n", file);
    for (const std::string& note : notes) fmt::print("  note: {}\n", note);
    if (files->empty())
      for (const std::string& each : assumed) fmt::print("  assumed: {}\n", each);
    else
      fmt::print("  {} things are assumed of the stations; `gantry check` alone lists them\n", assumed.size());
  });
}

}  // namespace gantry::cli
