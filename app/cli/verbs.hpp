// The verbs of `gantry`, one file each. A verb adds its subcommand; when the user names it, it runs and leaves its exit
// code.
#pragma once
#include <CLI/CLI.hpp>
#include <optional>
#include <string>
#include <vector>

#include "app/cli/signals.hpp"
#include "config/machine.hpp"
#include "core/error.hpp"
#include "sim/machine/virtual_machine.hpp"

namespace gantry::monitor {
struct NetworkOptions;
}

namespace gantry::cli {

/// What all verbs share.
struct Context {
  std::string machine_file;  ///< --machine, or the reference machine
  bool json = false;         ///< --json: one JSON document on stdout
  int exit_code = 0;
};

void add_bus(CLI::App& app, Context& context);
void add_check(CLI::App& app, Context& context);
void add_commission(CLI::App& app, Context& context);
void add_dry_run(CLI::App& app, Context& context);
void add_explain(CLI::App& app, Context& context);
void add_home(CLI::App& app, Context& context);
void add_jog(CLI::App& app, Context& context);
void add_monitor(CLI::App& app, Context& context);
void add_orders(CLI::App& app, Context& context);
void add_publish(CLI::App& app, Context& context);
void add_run(CLI::App& app, Context& context);
void add_sim(CLI::App& app, Context& context);
void add_trace(CLI::App& app, Context& context);
void add_up(CLI::App& app, Context& context);

/// --sim-board, --sim-seed, --sim-script, --sim-state.
void add_world_options(CLI::App& verb, sim::VirtualMachineOptions& options);

/// --domain, --interface, --peer.
void add_network_options(CLI::App& verb, monitor::NetworkOptions& options);
/// The same of a verb that owns a machine, and --name.
void add_publish_options(CLI::App& verb, monitor::NetworkOptions& options, std::string& name);

/// Shows errors (text on stderr, or a JSON document {"errors": [...]} on stdout) and gives the exit code of the worst.
int show(const std::vector<Error>& errors, bool json);
int show(const Error& error, bool json);

/// The machine that --machine names. On mistakes they are shown and context.exit_code is set.
std::optional<config::Machine> load_machine(Context& context);

/// A file that ships with the program ("config/machines/dispenser.yaml"), beside the executable's tree; what lies in
/// the working folder does not replace it.
std::string shipped_file(const std::string& relative);

}  // namespace gantry::cli
