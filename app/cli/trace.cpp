// gantry trace diff A B: did two runs of a job command the same?
#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <nlohmann/json.hpp>

#include "app/cli/terminal.hpp"
#include "app/cli/verbs.hpp"
#include "app/record/setpoint_file.hpp"

namespace gantry::cli {
namespace {

struct DiffOptions {
  std::string a, b;
};

Result<std::string> setpoints_of(const std::string& named) {
  std::error_code ignored;
  if (!std::filesystem::is_directory(named, ignored)) return named;
  const auto file = std::filesystem::path(named) / "setpoints.bin";
  if (std::filesystem::exists(file, ignored)) return file.string();
  return fail(Fault::FileUnreadable, "this folder holds no setpoints.bin, which every job that began has written",
              named);
}

/// What a disturbed job commanded is nobody else's, however equal it may be in parts.
Result<void> comparable(const std::string& named) {
  const auto folder = std::filesystem::path(named);
  std::ifstream file(folder / "summary.json");
  const auto summary = file ? nlohmann::json::parse(file, nullptr, false) : nlohmann::json();
  if (!summary.is_object() || !summary.value("disturbed", false)) return {};
  return fail(
      Fault::Refused,
      fmt::format("this job was disturbed (a hold, an override, a stop, or features that were left out), so that "
                  "it says nothing of another run; to compare it all the same, name '{}'",
                  (folder / "setpoints.bin").string()),
      named);
}

void show_comparison(const record::SetpointComparison& c, const std::string& file, Context& context) {
  std::vector<Error> errors;
  if (const auto& d = c.first_difference)
    errors.push_back({Fault::SetpointsDiffer, fmt::format("block {}, tick {}: {}", d->block, d->tick, d->what), file});
  if (!errors.empty()) context.exit_code = static_cast<int>(info(Fault::SetpointsDiffer).exit_code);
  if (context.json) {
    nlohmann::ordered_json document{
        {"ticks", {c.ticks_a, c.ticks_b}}, {"sent_by_both", c.common}, {"sent_by_one", {c.only_a, c.only_b}}};
    if (const auto& d = c.first_difference)
      document["first_difference"] = {{"block", d->block}, {"tick", d->tick}, {"what", d->what}};
    return show_document(c.first_difference ? "different" : "equal", document, context.exit_code, errors);
  }
  print_text("{} ticks were sent by both, {} by the first alone, {} by the second alone\n", c.common, c.only_a,
             c.only_b);
  if (errors.empty())
    print_text("equal wherever both sent\n");
  else
    show(errors, false);
}

void diff(Context& context, const DiffOptions& options) {
  for (const std::string& named : {options.a, options.b})
    if (auto may = comparable(named); !may) return void(context.exit_code = show(may.error(), context.json));
  const auto a = setpoints_of(options.a), b = setpoints_of(options.b);
  for (const auto* file : {&a, &b})
    if (!*file) return void(context.exit_code = show(file->error(), context.json));
  const auto compared = record::compare(*a, *b);
  if (!compared) return void(context.exit_code = show(compared.error(), context.json));
  show_comparison(*compared, *b, context);
}

}  // namespace

void add_trace(CLI::App& app, Context& context) {
  auto* verb = app.add_subcommand("trace", "What a job commanded, tick by tick");
  verb->require_subcommand(1);
  auto* diff_verb = verb->add_subcommand(
      "diff",
      "Compares two runs: where the host stalled, or frames were lost, only the ticks that both sent can be compared");
  auto options = std::make_shared<DiffOptions>();
  diff_verb->add_option("A", options->a, "A job's folder, or its setpoints.bin")->required();
  diff_verb->add_option("B", options->b, "The other")->required();
  diff_verb->footer(
      "Exit code 0: equal wherever both sent; 7: they differ. For example:\n"
      "  gantry trace diff out/demo-board-001 out/demo-board-002");
  diff_verb->callback([&context, options] { diff(context, *options); });
}

}  // namespace gantry::cli
