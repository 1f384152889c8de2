// gantry sim: the simulated machine in a process of its own.
#include "app/cli/stop_flag.hpp"
#include "app/cli/usage.hpp"
#include "app/cli/verbs.hpp"
#include "core/log.hpp"
#include "sim/machine/serve.hpp"
#include "sim/world/board.hpp"

namespace gantry::cli {
namespace {

std::string is_placement(const std::string& word) {
  const auto read = sim::parse_placement(word);
  return read ? "" : read.error().message;
}

}  // namespace

void add_sim(CLI::App& app, Context& context) {
  auto* verb = app.add_subcommand(
      "sim", "The simulated machine in a process of its own: bus on a network interface, camera and world on a socket");
  auto options = std::make_shared<sim::ServeOptions>();
  verb->add_option("--interface", options->interface, "Network interface that the stations answer on")->required();
  verb->add_option("--world", options->world_socket, "Unix socket for camera and world (gantry run --world)");
  add_world_options(*verb, options->world);
  verb->add_flag("--script-stdin", options->script_on_stdin, "Take script entries from stdin, one a line");
  verb->footer(
      "Example:  gantry sim --interface veth1 --world /tmp/world.sock\n"
      "          gantry run recipes/demo-board.yaml --bus ethercat:veth0 --world /tmp/world.sock");
  verb->callback([&context, options] {
    const auto machine = load_machine(context);
    if (!machine) return;
    StopFlag stop;
    log::info("simulated machine '{}' on {}", machine->name, options->interface);
    if (auto served = sim::serve(*machine, *options, stop.flag()); !served)
      context.exit_code = show(served.error(), context.json);
  });
}

void add_world_options(CLI::App& verb, sim::SimulatedMachineOptions& options) {
  verb.add_option("--sim-board", options.placement,
                  "Where the board lies, e.g. \"dx=1.3 mm, dy=-0.7 mm, rot=0.8 deg\"; else the seed places it")
      ->check(is_placement);
  verb.add_option("--sim-seed", options.seed, "Seed of everything random in the virtual world")
      ->check(whole_from_zero)
      ->capture_default_str();
  verb.add_option("--sim-script", options.script_file, "What happens in the world: a script file");
  verb.add_option("--sim-state", options.state_dir, "Folder in which the world outlives this program")
      ->check(folder_to_be);
}

}  // namespace gantry::cli
