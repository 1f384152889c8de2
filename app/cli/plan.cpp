// gantry plan --scene FILE --queries FILE.json | --motions FILE.json: paths and motions among bodies, without a
// machine.
#include <fmt/format.h>
#include <memory>

#include "app/cli/plan_questions.hpp"
#include "app/cli/terminal.hpp"
#include "app/cli/verbs.hpp"
#include "motion/plan/scene_file.hpp"

namespace gantry::cli {
namespace {

using Json = nlohmann::ordered_json;

struct Options {
  std::string scene, queries, motions;
};

/// {result, exit_code, errors, queries, motions}, or the mistakes.
Checked<Json> answer(const Options& options) {
  const auto machine = motion::load_scene(options.scene);
  std::vector<Error> errors;
  if (!machine) errors = machine.error();
  // Of a scene that cannot be read nobody knows.
  const Turns turns = !machine || machine->c ? Turns::Yes : Turns::No;
  const auto read = [&](const std::string& path, auto&& reader) {
    std::vector<Question> out;
    if (path.empty()) return out;
    auto questions = reader(path, turns);
    if (questions) return *std::move(questions);
    errors.insert(errors.end(), questions.error().begin(), questions.error().end());
    return out;
  };
  const auto queries = read(options.queries, read_queries), motions = read(options.motions, read_motions);
  if (!errors.empty()) return tl::unexpected(std::move(errors));

  Json out = Json::object();
  const motion::Scene scene(*machine);
  if (!options.queries.empty()) out["queries"] = answer_queries(scene, machine->clearance_mm, queries);
  if (!options.motions.empty()) out["motions"] = answer_motions(scene, machine->clearance_mm, motions);
  return out;
}

std::string text(const Json& value) { return value.is_string() ? value.get<std::string>() : value.dump(); }
std::string pair(const Json& row) {
  return row["pair"].is_null() ? "" : fmt::format("; {} and {}", text(row["pair"][0]), text(row["pair"][1]));
}

void show_rows(const Json& document) {
  for (const Json& row : document.value("queries", Json::array())) {
    const std::string closed =
        row["closed_in"].is_null() ? "" : fmt::format(", {} is closed in", text(row["closed_in"]));
    if (text(row["status"]) == "ok") {
      print_text("{}: {:.3f} mm{}\n", text(row["id"]), row["length_mm"].get<double>(),
                 row["min_clearance_mm"].is_null()
                     ? ""
                     : fmt::format(", nearest {:.4f} mm{}", row["min_clearance_mm"].get<double>(), pair(row)));
      for (const Json& p : row["path"])
        print_text("  {:.3f} {:.3f} {:.3f}{}\n", p[0].get<double>(), p[1].get<double>(), p[2].get<double>(),
                   p.size() > 3 ? fmt::format(" {:.3f} deg", p[3].get<double>()) : "");
    } else {
      print_text("{}: {}{}{}\n", text(row["id"]), text(row["status"]), closed, pair(row));
    }
  }
  for (const Json& row : document.value("motions", Json::array()))
    print_text("{}: {}{}{}\n", text(row["id"]), row["free"].get<bool>() ? "free" : "collides",
               row["t"].is_null() ? "" : fmt::format(" at {:.4f} of it", row["t"].get<double>()), pair(row));
}

}  // namespace

void add_plan(CLI::App& app, Context& context) {
  auto* verb = app.add_subcommand("plan", "Paths and motions among the bodies of a scene document, proved free");
  auto options = std::make_shared<Options>();
  verb->add_option("--scene", options->scene, "Scene document, YAML or JSON")->required();
  verb->add_option("--queries", options->queries, "JSON: [{id, start: [x, y, z], goal: [x, y, z]}], paths to find");
  verb->add_option("--motions", options->motions, "JSON: [{id, from: [x, y, z], to: [x, y, z]}], lines to judge");
  verb->callback([&context, options] {
    if (options->queries.empty() && options->motions.empty()) {
      context.exit_code =
          show(Error{Fault::Usage, "nothing is asked; give --queries FILE.json or --motions FILE.json", "gantry plan"},
               context.json);
      return;
    }
    const auto document = answer(*options);
    if (!document)
      context.exit_code = show(document.error(), context.json);
    else if (context.json)
      show_document("ok", *document);
    else
      show_rows(*document);
  });
}

}  // namespace gantry::cli
