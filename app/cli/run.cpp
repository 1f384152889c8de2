// gantry run RECIPE: the job in real time, on the simulated machine or on a bus.
#include "app/cli/client.hpp"
#include "app/cli/job_verbs.hpp"
#include "app/cli/signals.hpp"
#include "app/cli/usage.hpp"
#include "core/absolute_path.hpp"

namespace gantry::cli {

void add_run(CLI::App& app, Context& context) {
  auto* verb = app.add_subcommand("run", "One job in real time: on the simulated machine, or on a bus");
  does_a_job(*verb, context);
  auto request = std::make_shared<JobRequest>();
  auto state = std::make_shared<std::string>();
  request->owner.publish = true;
  request->owner.interrupted = interrupted;
  verb->add_option("RECIPE", request->recipe_file, "Recipe file")->required();
  verb->add_option("--bus", request->owner.bus, "sim, or ethercat:IFACE")->capture_default_str();
  verb->add_option("--loop-cpu", request->owner.loop_cpu, "CPU for the 1 ms loop alone; default: the last of several");
  verb->add_option("--world", request->owner.world_socket, "Socket of a `gantry sim` that shows camera and world");
  add_folder(*verb, *request);
  add_selection(*verb, request->select);
  verb->add_flag("--finish", request->select.finish, "Dispense what the begun part lacks, and nothing else")
      ->excludes("--from")
      ->excludes("--only");
  verb->add_option("--certificate", request->certificate,
                   "certificate.json of a dry run: the job is refused (exit 7) when scene, head, recipe, limits or "
                   "calibration have changed since");
  verb->add_option("--serial", request->serial, kSerialHelp)->check(run::wrong_with_serial);
  verb->add_option("--state", *state, kStateHelp);
  add_publish_options(*verb, request->owner.network, request->owner.name);
  add_world_options(*verb, request->owner.sim);
  verb->footer(
      "Keys on a terminal: space hold and resume, n hold now, a abort, r reset, + and - override, Ctrl-Z holds and\n"
      "suspends, Ctrl-C ends with the safe state.\n"
      "A part that a job has begun and not finished is refused (exit 7) without --finish, --from or --only, until\n"
      "`gantry part-removed`: it is known by its --serial; without serials it is the one in the machine, until the "
      "clamp has\n"
      "opened. The terminal says what finishes it:  gantry run RECIPE --only transformer_dam,'spreader[1][2]'");
  verb->callback([&context, verb, request, state] {
    const auto folder = state_of(context, *state);
    if (!folder) return;
    const auto recipe = absolute_path(request->recipe_file), certificate = absolute_path(request->certificate),
               out = absolute_path(request->out.empty() ? "out" : request->out);
    for (const auto* path : {&recipe, &certificate, &out})
      if (!*path) return void(context.exit_code = show(path->error(), context.json, context.board));
    run::Order order{.kind = run::OrderKind::Run,
                     .recipe = *recipe,
                     .serial = request->serial,
                     .select = request->select,
                     .certificate = *certificate};
    if (request->out.empty())
      order.under = *out;
    else
      order.out = *out, order.force = request->force;
    const Asked asked{.order = order,
                      .state = *folder,
                      .state_option = *state,
                      .own = &request->owner,
                      .given = given_options(*verb),
                      .shown_folder = request->out};
    if (ask_owner(context, asked)) return;
    request->owner.state = *folder;
    request->same_machine = {.all = same_machine(*verb, {"--machine", "--state"}),
                             .run = same_machine(*verb, {"--bus", "--world", "--sim-state"})};
    do_job(context, *request);
  });
}

}  // namespace gantry::cli
