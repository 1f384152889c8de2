// gantry: machine controller for gantry and dispensing machines. main builds the house and hands the parts down; each
// verb has its file.
#include <algorithm>
#include <exception>
#include <string_view>

#include "app/cli/shipped.hpp"
#include "app/cli/terminal.hpp"
#include "app/cli/usage.hpp"
#include "app/cli/verbs.hpp"
#include "core/log.hpp"

int main(int argc, char** argv) try {
  using namespace gantry;
  CLI::App app{"gantry - controller for gantry and dispensing machines", "gantry"};
  app.require_subcommand(1);
  app.fallthrough();
  app.add_flag_callback(
      "--version", [] { throw CLI::CallForVersion("", 0); }, "Display program version information and exit");
  app.footer(
      "Exit codes: 0 done, 1 internal error, 2 usage, 3 invalid file, 4 not feasible, 5 device or bus fault,\n"
      "6 vision or probe failed, 7 refused, 8 deadline broken, 9 done with defects, 130 interrupted with the safe "
      "state\n"
      "reached.\n"
      "Start with:  gantry init my-machine");

  cli::Context context;
  context.machine_file = cli::reference_machine();
  bool quiet = false;
  app.add_option("--machine", context.machine_file, "Machine file, or the name of one that comes with gantry")
      ->capture_default_str();
  app.add_flag("--json", context.json, "One JSON document on stdout; logs go to stderr");
  app.add_flag("-q,--quiet", quiet, "Only warnings and errors on stderr");
  app.add_flag("-v,--verbose", context.verbose, "More detail on stderr");
  app.parse_complete_callback([&] {
    context.machine_file = cli::machine_file(context.machine_file);
    log::open(quiet ? log::Level::Quiet : context.verbose ? log::Level::Verbose : log::Level::Normal);
    cli::catch_signals();
  });

  cli::add_init(app, context);
  cli::add_doctor(app, context);
  cli::add_check(app, context);
  cli::add_dry_run(app, context);
  cli::add_run(app, context);
  cli::add_up(app, context);
  cli::add_home(app, context);
  cli::add_jog(app, context);
  cli::add_orders(app, context);
  cli::add_plan(app, context);
  cli::add_sim(app, context);
  cli::add_publish(app, context);
  cli::add_commission(app, context);
  cli::add_bus(app, context);
  cli::add_monitor(app, context);
  cli::add_trace(app, context);
  cli::add_explain(app, context);
  cli::add_pages(app, context);
  cli::refuse_slips(app);

  // What stands behind a mistake, or behind --version, was not read: --json is looked for by hand.
  const bool json = std::find(argv, argv + argc, std::string_view("--json")) != argv + argc;
  try {
    app.parse(argc, argv);
  } catch (const CLI::CallForVersion&) {
    cli::show_version(json);
    return cli::close_output(0);
  } catch (const CLI::Success& help) {
    return cli::close_output(app.exit(help));
  } catch (const CLI::ParseError& error) {
    return cli::show(cli::usage_error(app, error), json, context.board);
  }
  return cli::close_output(context.exit_code);
} catch (const std::exception& error) {
  gantry::cli::say("internal error: {}\n", error.what());
  return 1;
}
