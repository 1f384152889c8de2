// gantry doctor: is this computer fit to control a machine? Each line with its fix. It changes nothing.
#include "app/cli/doctor.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "app/cli/client.hpp"
#include "app/cli/terminal.hpp"
#include "app/cli/verbs.hpp"
#include "app/desk/state_folder.hpp"
#include "core/absolute_path.hpp"

namespace gantry::cli {
namespace {

std::string_view word(Finding::Level level) {
  switch (level) {
    case Finding::Level::Ok: return "ok";
    case Finding::Level::Warning: return "warning";
    case Finding::Level::Error: return "error";
  }
  return "";
}

void add(Findings& to, Findings more) { to.insert(to.end(), more.begin(), more.end()); }

/// The machine file, and the folders that go by its name.
Findings look_at_machine(const std::string& file, const std::string& state_option) {
  const auto machine = config::load_machine(file);
  if (!machine)
    return {{"machine file", Finding::Level::Error, to_text(machine.error().front()),
             "`gantry check` shows every mistake in it", machine.error().front().fault}};
  Findings findings{{"machine file", Finding::Level::Ok, file, "", {}}};
  const auto state = desk::state_folder(state_option, machine->name, desk::environment);
  if (state)
    add(findings, look_at_folders(*state, absolute_path("out").value_or("out")));
  else
    findings.push_back({"state folder", Finding::Level::Error, state.error().message,
                        "name one with --state or GANTRY_STATE", state.error().fault});
  return findings;
}

}  // namespace

void add_doctor(CLI::App& app, Context& context) {
  auto* verb = app.add_subcommand("doctor", "Is this computer fit to control a machine? Each finding with its fix");
  auto interface = std::make_shared<std::string>(), state = std::make_shared<std::string>();
  verb->add_option("--interface", *interface, "Network interface of the bus; without it: for the simulated machine");
  verb->add_option("--state", *state, kStateHelp);
  verb->footer("Exit code 0 unless a line says error: then that of the fault it would lead to. Changes nothing.");
  verb->callback([&context, interface, state] {
    Findings findings;
    add(findings, look_at_real_time(!interface->empty()));
    add(findings, look_at_interface(*interface));
    add(findings, look_at_dds());
    add(findings, look_at_machine(context.machine_file, *state));

    const auto worst = std::max_element(findings.begin(), findings.end(),
                                        [](const auto& a, const auto& b) { return a.level < b.level; });
    const bool failed = worst->level == Finding::Level::Error;
    context.exit_code = static_cast<int>(failed ? info(worst->fault).exit_code : ExitCode::Done);
    if (context.json) {
      auto rows = nlohmann::ordered_json::array();
      std::vector<Error> errors;
      for (const Finding& f : findings) {
        rows.push_back(
            nlohmann::ordered_json{{"name", f.name}, {"level", word(f.level)}, {"text", f.text}, {"fix", f.fix}});
        if (f.level == Finding::Level::Error) errors.push_back({f.fault, f.text, f.name});
      }
      return show_document(failed ? "failed" : word(worst->level), {{"findings", rows}}, context.exit_code, errors);
    }
    for (const Finding& f : findings) {
      print_text("{:<8} {:<20} {}\n", word(f.level), f.name, f.text);
      if (!f.fix.empty()) print_text("{:<8} {:<20} fix: {}\n", "", "", f.fix);
    }
  });
}

}  // namespace gantry::cli
