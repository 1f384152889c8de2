// The verbs of `gantry`, one file each. A verb adds its subcommand; when the user names it, it runs and leaves its exit
// code.
#pragma once
#include <CLI/CLI.hpp>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "app/cli/signals.hpp"
#include "config/machine.hpp"
#include "core/error.hpp"
#include "sim/machine/simulated_machine.hpp"

namespace gantry::monitor {
struct NetworkOptions;
}

namespace gantry::cli {

/// What all verbs share.
struct Context {
  std::string machine_file;  ///< --machine, or the reference machine that comes with the program
  bool json = false;         ///< --json: one JSON document on stdout
  bool verbose = false;      ///< --verbose: more detail
  /// What a refusal says of the board, in its document: of a verb that does a job. Empty: it does none.
  std::string_view board{};
  int exit_code = 0;
};

void add_bus(CLI::App& app, Context& context);
void add_check(CLI::App& app, Context& context);
void add_commission(CLI::App& app, Context& context);
void add_doctor(CLI::App& app, Context& context);
void add_dry_run(CLI::App& app, Context& context);
void add_explain(CLI::App& app, Context& context);
void add_home(CLI::App& app, Context& context);
void add_init(CLI::App& app, Context& context);
void add_jog(CLI::App& app, Context& context);
void add_monitor(CLI::App& app, Context& context);
void add_orders(CLI::App& app, Context& context);
void add_pages(CLI::App& app, Context& context);
void add_plan(CLI::App& app, Context& context);
void add_publish(CLI::App& app, Context& context);
void add_run(CLI::App& app, Context& context);
void add_sim(CLI::App& app, Context& context);
void add_trace(CLI::App& app, Context& context);
void add_up(CLI::App& app, Context& context);

/// --sim-board, --sim-seed, --sim-script, --sim-state.
void add_world_options(CLI::App& verb, sim::SimulatedMachineOptions& options);

/// --domain, --interface, --peer.
void add_network_options(CLI::App& verb, monitor::NetworkOptions& options);
/// The same of a verb that owns a machine, and --name.
void add_publish_options(CLI::App& verb, monitor::NetworkOptions& options, std::string& name);

/// Shows errors (text on stderr, or a JSON document {"errors": [...]} on stdout) and gives the exit code of the worst.
/// `board`: of the job that they have refused or ended, told in the document; "": it was no job.
int show(const std::vector<Error>& errors, bool json, std::string_view board = {});
int show(const Error& error, bool json, std::string_view board = {});
/// In one line of JSON, where such lines went before, and on stderr.
int show_line(const Error& error);
void show_version(bool json);
/// The JSON document of a verb that did its work: `result`, `exit_code` and `errors` stand in front of `rest`, which
/// may not say them itself.
void show_document(std::string_view result, const nlohmann::ordered_json& rest, int exit_code = 0,
                   const std::vector<Error>& errors = {});
/// A document as stdout shows it: exact, and in ASCII alone.
void print_document(const nlohmann::ordered_json& document);
/// Nobody here knows how the job's board is left: null in the document.
inline constexpr std::string_view kBoardUnknown = "unknown";

/// The machine that --machine names. On mistakes they are shown and context.exit_code is set.
std::optional<config::Machine> load_machine(Context& context);

}  // namespace gantry::cli
