// gantry dry-run RECIPE: the simulated machine in virtual time.
#include "app/cli/job_verbs.hpp"
#include "app/cli/signals.hpp"
#include "app/cli/usage.hpp"

namespace gantry::cli {

void add_dry_run(CLI::App& app, Context& context) {
  auto* verb =
      app.add_subcommand("dry-run", "The whole job on the simulated machine, as fast as it can; report and figures");
  does_a_job(*verb, context);
  auto request = std::make_shared<JobRequest>();
  request->dry_run = true;
  request->owner.virtual_time = true;
  request->owner.interrupted = interrupted;
  verb->add_option("RECIPE", request->recipe_file, "Recipe file")->required();
  add_folder(*verb, *request);
  add_selection(*verb, request->select);
  verb->add_option("--serial", request->serial, kSerialHelp)->check(run::wrong_with_serial);
  add_world_options(*verb, request->owner.sim);
  verb->footer("Example:  gantry dry-run recipes/demo-board.yaml --sim-board \"dx=1.3 mm, dy=-0.7 mm, rot=0.8 deg\"");
  verb->callback([&context, request] { do_job(context, *request); });
}

}  // namespace gantry::cli
