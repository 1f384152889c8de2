// gantry publish: the child process of an owner that speaks DDS. People rarely start it themselves.
#include "app/monitor/publish.hpp"

#include <sys/prctl.h>

#include "app/cli/stop_flag.hpp"
#include "app/cli/verbs.hpp"
#include "app/monitor/rights.hpp"

namespace gantry::cli {

void add_network_options(CLI::App& verb, monitor::NetworkOptions& options) {
  verb.add_option("--domain", options.domain, "DDS domain")->capture_default_str();
  verb.add_option("--interface", options.interface,
                  "Speak on the network of this interface, and nowhere else; without it on this computer alone");
  verb.add_option("--peer", options.peers,
                  "IPv4 address of a computer that multicast does not reach; may be given again")
      ->allow_extra_args(false);
}

void add_publish_options(CLI::App& verb, monitor::NetworkOptions& options, std::string& name) {
  add_network_options(verb, options);
  verb.add_option("--name", name, "The machine's name on DDS; default: the one in the machine file");
}

void add_publish(CLI::App& app, Context& context) {
  auto* verb = app.add_subcommand("publish", "Tells an owner's shared memory over DDS; the owner starts it by itself");
  auto options = std::make_shared<monitor::PublishOptions>();
  auto shm = std::make_shared<int>(-1);
  verb->add_option("--shm", *shm, "The owner's memory: the number of an inherited file descriptor")->required();
  verb->add_option("--rate", options->rate_hz, "Samples of the state a second")->capture_default_str();
  add_network_options(*verb, options->network);
  verb->callback([&context, options, shm] {
    // Before the first thread: each thread has rights of its own.
    if (auto given_up = monitor::give_up_rights(); !given_up)
      return void(context.exit_code = show(given_up.error(), context.json));
    ::prctl(PR_SET_NAME, "gantry-publish");  // as `ps` and `ss` show it, which else name how it was started
    StopFlag stop;
    if (auto done = monitor::publish(*shm, *options, stop.flag()); !done)
      context.exit_code = show(done.error(), context.json);
  });
}

}  // namespace gantry::cli
