// gantry home: enables the drives and references every axis, in its own owner or in the one that is up; what it shows
// is the same.
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "app/cli/client.hpp"
#include "app/cli/keys.hpp"
#include "app/cli/signals.hpp"
#include "app/cli/terminal.hpp"
#include "app/desk/machine_status.hpp"
#include "app/job/jog.hpp"
#include "app/run/owner.hpp"

namespace gantry::cli {

void add_home(CLI::App& app, Context& context) {
  auto* verb = app.add_subcommand("home", "References every axis, Z first, or those that are named alone");
  auto axes = std::make_shared<std::vector<std::string>>();
  auto options = std::make_shared<run::OwnerOptions>();
  auto state = std::make_shared<std::string>();
  verb->add_option("AXIS", *axes, "These alone; needs X, Y and Z to be referenced; default: every axis");
  verb->add_option("--bus", options->bus, "sim, or ethercat:IFACE")->capture_default_str();
  verb->add_option("--loop-cpu", options->loop_cpu, "CPU for the 1 ms loop alone; default: the last of several");
  verb->add_option("--state", *state, kStateHelp);
  add_world_options(*verb, options->sim);
  verb->callback([&context, verb, axes, options, state] {
    const auto folder = state_of(context, *state);
    if (!folder) return;
    if (ask_owner(context, {.order = {.kind = run::OrderKind::Home, .axes = *axes},
                            .state = *folder,
                            .state_option = *state,
                            .own = options.get(),
                            .given = given_options(*verb)}))
      return;
    const auto machine = load_machine(context);
    if (!machine) return;
    for (const std::string& name : *axes)
      if (const auto axis = job::axis_named(*machine, name); !axis)
        return void(context.exit_code = show(axis.error(), context.json));
    hold_machine(Terminal::Matters);
    hold_on_stop_key();
    options->state = *folder;
    options->interrupted = interrupted;
    auto owner = run::Owner::open(*machine, *options);
    if (!owner) return void(context.exit_code = show(owner.error(), context.json));
    OwnerOperated operated(**owner);
    Keys keys(operated, Keys::Shows::Nothing);
    (*owner)->on_step([&] { keys.poll(); });
    Result<void> done = (*owner)->bring_up();
    if (done) done = (*owner)->home(*axes);
    nlohmann::ordered_json status = desk::machine_status(*machine, **owner);
    (*owner)->shut_down();  // before anything is shown: whoever reads it may take their time
    if (!done) return void(context.exit_code = show(done.error(), context.json));
    status["said"] =
        desk::in_words(status) +
        "\nended: the drives have lost their torque again; `gantry up` keeps the machine and its references";
    if (context.json) return show_document("ok", status);
    print_text("{}\n", status["said"].get<std::string>());
  });
}

}  // namespace gantry::cli
