// gantry monitor: what machines tell over DDS.
#include "app/monitor/monitor.hpp"

#include <iostream>
#include <unistd.h>

#include "app/cli/stop_flag.hpp"
#include "app/cli/usage.hpp"
#include "app/cli/verbs.hpp"
#include "core/status_line.hpp"

namespace gantry::cli {

void add_monitor(CLI::App& app, Context& context) {
  auto* verb = app.add_subcommand("monitor", "Shows what machines tell over DDS; it only listens");
  auto options = std::make_shared<monitor::MonitorOptions>();
  verb->add_option("--name", options->machine, "Listen to this machine only");
  verb->add_option("--count", options->count, "End after so many samples")->check(above_zero);
  verb->add_option("--for", options->for_s, "End after so many seconds")->check(above_zero);
  add_network_options(*verb, options->network);
  verb->footer(
      "With --json one line a sample, and one with `errors` where it ends by an error. Example:  gantry --json monitor "
      "--count 5");
  verb->callback([&context, options] {
    options->json = context.json;
    options->live = !context.json && writes_over(STDOUT_FILENO);
    StopFlag stop;
    if (auto done = monitor::monitor(*options, std::cout, stop.flag()); !done)
      context.exit_code = context.json ? show_line(done.error()) : show(done.error(), false);
  });
}

}  // namespace gantry::cli
