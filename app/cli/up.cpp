// gantry up: owns the machine until it is stopped, and takes orders on a local socket. `home`, `jog` and `run` are its
// clients while it is up.
#include <filesystem>

#include "app/cli/client.hpp"
#include "app/cli/front.hpp"
#include "app/cli/shell_job.hpp"
#include "app/cli/signals.hpp"
#include "app/cli/usage.hpp"
#include "app/cli/verbs.hpp"
#include "app/desk/desk.hpp"
#include "app/desk/do_job.hpp"
#include "app/desk/identity.hpp"
#include "app/desk/order_line.hpp"
#include "app/desk/state_folder.hpp"
#include "core/absolute_path.hpp"
#include "core/log.hpp"

namespace gantry::cli {

void add_up(CLI::App& app, Context& context) {
  auto* verb = app.add_subcommand("up", "Owns the machine until stopped; `run`, `home` and `jog` are its clients");
  auto options = std::make_shared<run::OwnerOptions>();
  auto state = std::make_shared<std::string>(), recipe = std::make_shared<std::string>();
  auto shared = std::make_shared<std::string>();
  options->publish = true;
  verb->add_option("--bus", options->bus, "sim, or ethercat:IFACE")->capture_default_str();
  verb->add_option("--loop-cpu", options->loop_cpu, "CPU for the 1 ms loop alone; default: the last of several");
  verb->add_option("--world", options->world_socket, "Socket of a `gantry sim` that shows camera and world");
  verb->add_option("--recipe", *recipe, "Recipe that the machine's start button runs");
  verb->add_option("--state", *state, kStateHelp);
  verb->add_option("--socket", *shared,
                   "Takes orders there as well, from this program's group (mode 0660); default: from this user alone")
      ->check(file_to_be);
  add_publish_options(*verb, options->network, options->name);
  add_world_options(*verb, options->sim);
  verb->footer(
      "Orders are JSON lines on STATE/owner.sock: {\"order\": \"status\"}, enable, disable, home, jog, park, run, "
      "part_removed, hold, resume, abort, override, reset, quit.");
  verb->callback([&context, verb, options, state, recipe, shared] {
    if (auto fits = run::check(*options); !fits) return void(context.exit_code = show(fits.error(), context.json));
    const auto machine = load_machine(context);
    if (!machine) return;
    if (auto fits = sim::check_script(options->sim, *machine); !fits)
      return void(context.exit_code = show(fits.error(), context.json));
    if (!recipe->empty()) {
      const auto prepared = desk::prepare(*machine, *recipe);
      if (!prepared) return void(context.exit_code = show(prepared.error(), context.json));
      if (!prepared->proof) return void(context.exit_code = show(prepared->proof.error(), context.json));
    }
    const auto folder = state_of(context, *state);
    if (!folder) return;
    hold_machine(Terminal::MattersIfThereIsOne);
    hold_on_stop_key();
    stand_behind_a_front();
    if (auto r = desk::open_state_folder(*folder); !r) return void(context.exit_code = show(r.error(), context.json));
    const std::string socket = desk::owner_socket(*folder);
    const auto shared_link = absolute_path(*shared), recipe_file = absolute_path(*recipe);
    for (const auto* path : {&shared_link, &recipe_file})
      if (!*path) return void(context.exit_code = show(path->error(), context.json));
    auto door = desk::OrderSocket::listen(socket, std::filesystem::path(*shared_link).lexically_normal().string());
    if (!door) return void(context.exit_code = show(door.error(), context.json));
    options->state = *folder;
    options->interrupted = interrupted;
    desk::BegunParts parts(*desk::BegunParts::folder(*folder, *options, true));
    if (options->bus == "sim" && options->sim.state_dir.empty()) parts.forget_all();  // of a world that is gone
    auto owner = run::Owner::open(*machine, *options);
    if (!owner) return void(context.exit_code = show(owner.error(), context.json));
    const MonotonicClock clock;
    desk::Desk desk(*machine, **owner, **door, clock,
                    {.interrupted = interrupted,
                     .identity = desk::identity_of(context.machine_file, *options),
                     .recipe = *recipe_file,
                     .same_machine = {.all = same_machine(*verb, {"--machine", "--state"})},
                     .parts = &parts});
    OwnerOperated operated(**owner, OwnerOperated::Of::Service);
    ShellJob shell(operated);
    (*owner)->on_step([&] {
      desk.poll();
      shell.poll();
    });
    if (auto up = desk.bring_up(); !up) return void(context.exit_code = show(up.error(), context.json));
    log::info("'{}' is up; orders on {}", machine->name, shared->empty() ? socket : *shared);
    if (auto served = desk.serve(); !served) context.exit_code = show(served.error(), context.json);
    (*owner)->on_step({});
    (*owner)->shut_down();
    log::info("'{}' is down", machine->name);
  });
}

}  // namespace gantry::cli
