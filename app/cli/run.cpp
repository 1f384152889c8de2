// gantry run RECIPE: the job in real time, on the virtual machine or on a bus.
#include <filesystem>

#include "app/cli/client.hpp"
#include "app/cli/job_verbs.hpp"

namespace gantry::cli {

void add_run(CLI::App& app, Context& context) {
  auto* verb = app.add_subcommand("run", "One job in real time: on the virtual machine, or on a bus");
  auto request = std::make_shared<JobRequest>();
  auto state = std::make_shared<std::string>();
  request->owner.publish = true;
  verb->add_option("RECIPE", request->recipe_file, "Recipe file")->required();
  verb->add_option("--bus", request->owner.bus, "sim, or ethercat:IFACE")->capture_default_str();
  verb->add_option("--loop-cpu", request->owner.loop_cpu, "CPU for the 1 ms loop alone; default: the last of several");
  verb->add_option("--world", request->owner.world_socket, "Socket of a `gantry sim` that shows camera and world");
  verb->add_option("--out", request->out, "Folder for the results; default: a new one under out/");
  verb->add_option("--state", *state, kStateHelp);
  add_publish_options(*verb, request->owner.network, request->owner.name);
  add_world_options(*verb, request->owner.sim);
  verb->footer(
      "Keys on a terminal: space hold and resume, a abort, + and - override, Ctrl-C ends with the safe state.");
  verb->callback([&context, verb, request, state] {
    namespace fs = std::filesystem;
    const auto folder = state_of(context, *state);
    if (!folder) return;
    run::Order order{.kind = run::OrderKind::Run, .recipe = fs::absolute(request->recipe_file).string()};
    if (request->out.empty())
      order.under = fs::absolute("out").string();
    else
      order.out = fs::absolute(request->out).string();
    const Asked asked{.order = order,
                      .state = *folder,
                      .own = &request->owner,
                      .given = given_options(*verb),
                      .shown_folder = request->out};
    if (ask_owner(context, asked)) return;
    request->owner.state = *folder;
    do_job(context, *request);
  });
}

}  // namespace gantry::cli
