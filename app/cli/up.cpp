// gantry up: owns the machine until it is stopped, and takes orders on a local socket. `home`, `jog` and `run` are its
// clients while it is up.
#include <filesystem>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "app/cli/job_verbs.hpp"
#include "app/record/summary.hpp"
#include "app/run/job_files.hpp"
#include "app/run/order_socket.hpp"
#include "app/run/prove.hpp"
#include "core/log.hpp"
#include "core/units.hpp"

namespace gantry::cli {
namespace {

using Json = nlohmann::ordered_json;

Json failure(const std::vector<Error>& errors) {
  Json list = Json::array();
  for (const Error& e : errors)
    list.push_back({{"code", std::string_view(code(e.fault))}, {"message", e.message}, {"where", e.where}});
  return {{"ok", false}, {"exit_code", static_cast<int>(info(errors.front().fault).exit_code)}, {"errors", list}};
}

// The owner with its door: orders that take time run here one at a time, the others are answered between two cycles.
class Desk {
 public:
  Desk(const config::Machine& machine, run::Owner& owner, run::OrderSocket& door)
      : machine_(machine), owner_(owner), door_(door) {}

  /// Called in every step of the run thread.
  void poll() {
    if (interrupted()) {
      stop_ = true;
      if (busy_) owner_.interrupt(Error{Fault::Interrupted, "the owner was asked to end", ""});
    }
    while (auto in = door_.poll()) {
      const auto order = run::parse_order(in->line);
      if (!order) {
        door_.reply(in->client, failure({order.error()}).dump());
      } else if (run::takes_time(order->kind)) {
        if (busy_ || waiting_)
          door_.reply(in->client,
                      failure({Error{Fault::Refused, "the machine is busy with another order", ""}}).dump());
        else
          waiting_ = Waiting{in->client, *order};
      } else {
        door_.reply(in->client, answer_now(*order).dump());
      }
    }
  }

  /// Until it is asked to end. Fault::LoopDied when the machine cannot be served any more.
  Result<void> serve() {
    while (!stop_) {
      if (auto alive = owner_.idle(); !alive) return alive;
      if (!waiting_) continue;
      const Waiting next = *waiting_;
      waiting_.reset();
      busy_ = true;
      door_.reply(next.client, carry_out(next.order).dump());
      busy_ = false;
    }
    return {};
  }

 private:
  struct Waiting {
    std::uint64_t client = 0;
    run::Order order;
  };

  Json answer_now(const run::Order& order) {
    if (order.kind == run::OrderKind::Quit) {
      stop_ = true;
      if (busy_) owner_.interrupt(Error{Fault::Interrupted, "the owner was asked to end", ""});
    } else if (auto done = owner_.order(order); !done) {
      return failure({done.error()});
    }
    return status();
  }

  Json status() const {
    const cycle::Snapshot& s = owner_.latest();
    const run::Progress p = owner_.progress();
    Json axes = Json::array();
    for (const config::Axis& axis : machine_.axes)
      axes.push_back({{"name", axis.name},
                      {"position", s.actual[axis.id.value]},
                      {"enabled", (s.enabled >> axis.id.value & 1u) != 0},
                      {"referenced", (s.referenced >> axis.id.value & 1u) != 0}});
    return {{"ok", true},
            {"state", cycle::name(s.state)},
            {"cycle", s.cycle},
            {"doing", p.doing},
            {"features_done", p.features_done},
            {"features_total", p.features_total},
            {"override", s.override_factor},
            {"axes", axes}};
  }

  Json carry_out(const run::Order& order) {
    Result<void> done;
    switch (order.kind) {
      case run::OrderKind::Enable: done = owner_.enable(); break;
      case run::OrderKind::Disable: done = owner_.disable(); break;
      case run::OrderKind::Home: done = owner_.home(); break;
      case run::OrderKind::Jog: return jog(order.jog);
      case run::OrderKind::Run: return run_job(order);
      default: break;
    }
    return done ? status() : failure({done.error()});
  }

  /// "said" is the same for people.
  Json jog(const run::JogWords& words) {
    const auto done = owner_.jog(words);
    if (!done) return failure({done.error()});
    Json axes = Json::array();
    std::string said;
    for (const config::Axis& axis : machine_.axes) {
      if ((done->axes >> axis.id.value & 1u) == 0) continue;
      const double start = done->start[axis.id.value], end = done->end[axis.id.value];
      axes.push_back({{"name", axis.name}, {"unit", axis.rotary ? "rad" : "mm"}, {"start", start}, {"end", end}});
      const double shown = axis.rotary ? units::deg(1) : 1;
      said +=
          fmt::format("{} {:.3f} -> {:.3f} {}, ", axis.name, start * shown, end * shown, axis.rotary ? "deg" : "mm");
    }
    said += fmt::format("{:.3f} s", done->duration_s);
    return {{"ok", true},
            {"state", cycle::name(owner_.latest().state)},
            {"said", said},
            {"axes", axes},
            {"duration_s", done->duration_s}};
  }

  Json run_job(const run::Order& order) {
    const auto recipe = recipes::load(order.recipe);
    if (!recipe) return failure(recipe.error());
    const auto job = recipes::compile(*recipe, machine_);
    if (!job) return failure(job.error());
    const auto folder = run::job_folder(order.out, order.recipe);
    if (!folder) return failure({folder.error()});
    const run::RunOptions options{.out = *folder, .dry_run = false};
    record::JobResult result = run::begin_result(machine_, *recipe, *job, options);
    if (const auto proof = run::prove_nominal(machine_, *recipe, *job); proof)
      result = owner_.run(*recipe, *job, options);
    else
      run::add_error(result, proof.error());
    if (auto written = run::write_job(result, options.out); !written) run::add_error(result, written.error());
    Json document = record::to_json(result);
    document["ok"] = result.exit_code == ExitCode::Done;
    document["folder"] = std::filesystem::absolute(options.out).string();
    return document;
  }

  const config::Machine& machine_;
  run::Owner& owner_;
  run::OrderSocket& door_;
  std::optional<Waiting> waiting_;
  bool busy_ = false, stop_ = false;
};

}  // namespace

std::string owner_socket(const std::string& state_dir) { return state_dir + "/owner.sock"; }

void add_up(CLI::App& app, Context& context) {
  auto* verb = app.add_subcommand("up", "Owns the machine until stopped; `run`, `home` and `jog` are its clients");
  auto options = std::make_shared<run::OwnerOptions>();
  auto state = std::make_shared<std::string>("state");
  options->publish = true;
  verb->add_option("--bus", options->bus, "sim, or ethercat:IFACE")->capture_default_str();
  verb->add_option("--loop-cpu", options->loop_cpu, "CPU for the 1 ms loop alone; default: the last of several");
  verb->add_option("--world", options->world_socket, "Socket of a `gantry sim` that shows camera and world");
  verb->add_option("--state", *state, "Folder of the machine's state; holds owner.sock")->capture_default_str();
  add_world_options(*verb, options->sim);
  verb->footer(
      "Orders are JSON lines on STATE/owner.sock: {\"order\": \"status\"}, enable, disable, home, jog, run, hold, "
      "resume, "
      "abort, override, reset, quit.");
  verb->callback([&context, options, state] {
    const auto machine = load_machine(context);
    if (!machine) return;
    auto door = run::OrderSocket::listen(owner_socket(*state));
    if (!door) return void(context.exit_code = show(door.error(), context.json));
    auto owner = run::Owner::open(*machine, *options);
    if (!owner) return void(context.exit_code = show(owner.error(), context.json));
    Desk desk(*machine, **owner, **door);
    (*owner)->on_step([&] { desk.poll(); });
    if (auto up = (*owner)->bring_up(); !up) return void(context.exit_code = show(up.error(), context.json));
    log::info("'{}' is up; orders on {}", machine->name, owner_socket(*state));
    if (auto served = desk.serve(); !served) context.exit_code = show(served.error(), context.json);
    (*owner)->on_step({});
    (*owner)->shut_down();
    log::info("'{}' is down", machine->name);
  });
}

}  // namespace gantry::cli
