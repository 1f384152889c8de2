#include "app/cli/client.hpp"

#include <algorithm>
#include <array>
#include <csignal>
#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <nlohmann/json.hpp>

#include "app/cli/keys.hpp"
#include "app/cli/signals.hpp"
#include "app/cli/terminal.hpp"
#include "app/desk/answer.hpp"
#include "app/desk/identity.hpp"
#include "app/desk/order_client.hpp"
#include "app/desk/order_line.hpp"
#include "app/desk/state_folder.hpp"
#include "app/record/job_folder.hpp"
#include "core/log.hpp"

namespace gantry::cli {
namespace {

using desk::Json;

/// What the client calls its orders.
constexpr int kTheOrder = 1, kLook = 2, kKey = 3, kHold = 4;
/// How often it asks for the status: of a jog this is the sign of life that keeps it going (docs/owner-socket.md).
constexpr Time kLookEvery = milliseconds(100), kJogLookEvery = milliseconds(15);

/// An owner at the other end of a connection, as its last status tells.
class OwnerElsewhere final : public Operated {
 public:
  explicit OwnerElsewhere(desk::OrderClient& owner) : owner_(owner) {}

  [[nodiscard]] JobSeen seen() const override { return seen_; }
  Result<void> order(const run::Order& order) override { return say(order, kKey); }
  void interrupt() override {
    if (terminal_lost()) return;  // a job does not depend on its client
    static_cast<void>(say({.kind = run::OrderKind::Abort}, kKey));
    interrupted_ = true;
  }
  [[nodiscard]] bool interrupted() const { return interrupted_; }
  /// What homes or is prepared comes to it first. A hold that is refused (an abort is under way) is asked for again,
  /// until the job is over.
  Stands come_to_stand() override {
    if (!hold_taken_ && (!hold_asked_ || clock_.now() - *hold_asked_ >= kLookEvery)) {
      hold_asked_ = clock_.now();
      static_cast<void>(say({.kind = run::OrderKind::Hold, .now = true}, kHold));
    }
    const bool stands = seen_.held && (seen_.state == "held" || seen_.state == "stopped");
    return hold_taken_ && stands ? Stands::Yes : Stands::NotYet;
  }
  /// This process takes no 1 ms loop with it, so that it needs no front as a verb that holds the machine does.
  void suspend() override {
    hold_taken_ = false;
    hold_asked_.reset();
    log::info("held; the owner keeps the job while the shell has the terminal");
    raise(SIGSTOP);  // until `fg`
  }
  void hear(const Json& answer) {
    if (!answer.value("ok", false)) return;
    look_at(answer);
    if (hold_asked_ && answer.value("id", Json()) == kHold) hold_taken_ = true;
  }

  Result<void> say(const run::Order& order, int id) {
    if (owner_.send(desk::to_line(order, id))) return {};
    return fail(Fault::Refused, "the owner does not listen");
  }

 private:
  void look_at(const Json& status) {
    seen_.state = status.value("state", "");
    seen_.held = status.value("held", false);
    seen_.cycle = status.value("cycle", CycleIndex{});
    seen_.override_factor = status.value("override", 1.0);
    seen_.progress = {.features_done = status.value("features_done", std::size_t{}),
                      .features_total = status.value("features_total", std::size_t{}),
                      .doing = status.value("doing", ""),
                      .elapsed_s = status.value("elapsed_s", 0.0)};
    const auto left = status.find("remaining_s");
    seen_.progress.remaining_s =
        left != status.end() && left->is_number() ? std::optional(left->get<double>()) : std::nullopt;
  }

  desk::OrderClient& owner_;
  MonotonicClock clock_;
  JobSeen seen_;
  bool interrupted_ = false;
  std::optional<Time> hold_asked_;  ///< for the shell, since it wished for its terminal
  bool hold_taken_ = false;
};

/// The answer to `kTheOrder`; what else comes meanwhile is looked at or shown.
Result<Json> wait_for_answer(desk::OrderClient& owner, OwnerElsewhere& elsewhere, Keys& keys, Time look_every) {
  const MonotonicClock clock;
  Time next_look = clock.now();
  for (;;) {
    if (clock.now() >= next_look) {
      static_cast<void>(elsewhere.say({.kind = run::OrderKind::Status}, kLook));
      next_look = clock.now() + look_every;
    }
    const auto line = owner.read_line(std::clamp(next_look - clock.now(), Time(0), Time(milliseconds(25))));
    if (terminal_lost()) return fail(Fault::Interrupted, "the terminal is gone; the owner goes on");
    keys.poll();
    if (!line && owner.gone()) return fail(Fault::Refused, "the owner has ended before it answered");
    const auto answer = line ? Json::parse(*line, nullptr, false) : Json();
    if (!answer.is_object()) continue;
    const Json id = answer.value("id", Json());
    if (id == kTheOrder || id.is_null()) return answer;  // without: the connection is refused
    elsewhere.hear(answer);
    if (!answer.value("ok", false) && id == kKey)
      for (const Error& e : desk::errors_of(answer)) log::report(e);
  }
}

/// The summary that the owner has written, as `run` in process shows it.
Json summary_in(const std::string& folder, const std::string& shown_folder) {
  std::ifstream file(folder + "/summary.json");
  Json document = file ? Json::parse(file, nullptr, false) : Json();
  if (!document.is_object()) return {};
  document.erase("files");
  document["folder"] = shown_folder;
  return document;
}

/// Without what one stands in.
std::string as_seen_from_here(const std::string& folder) {
  const std::string here = std::filesystem::current_path().string() + "/";
  return folder.starts_with(here) ? folder.substr(here.size()) : folder;
}

void show_answer(const Context& context, const Json& answer, const std::string& shown_folder) {
  const std::vector<Error> errors = desk::errors_of(answer);
  const std::string folder = answer.value("folder", "");
  const std::string shown = shown_folder.empty() ? as_seen_from_here(folder) : shown_folder;
  if (folder.empty() && !errors.empty())
    return void(show(errors, context.json, answer.value("board", std::string(context.board))));
  for (const Error& e : errors) say("{}\n    remedy: {}\n", to_text(e), info(e.fault).remedy);
  if (context.json) {
    const Json summary = folder.empty() ? Json() : summary_in(folder, shown);
    if (summary.is_null())
      return show_document(errors.empty() ? "ok" : "failed", answer, answer.value("exit_code", 0), errors);
    return print_document(summary);
  }
  print_text("{}\n", answer.value("said", answer.value("state", "done")));
  if (record::has_report(folder)) print_text("  report         {}/report.html\n", shown);
}

int exit_code_of(const Json& answer, bool interrupted) {
  if (answer.value("ok", false)) return static_cast<int>(ExitCode::Done);
  return interrupted ? static_cast<int>(ExitCode::Interrupted) : answer.value("exit_code", 1);
}

/// The options that the user wrote are those of the owner.
Result<void> compare(desk::OrderClient& owner, const Context& context, const Asked& asked) {
  if (asked.given.empty()) return {};
  constexpr Time kPatience = std::chrono::seconds(10);
  if (!owner.send(desk::to_line(run::Order{.kind = run::OrderKind::Status}, kLook)))
    return fail(Fault::Refused, "the owner does not listen");
  const auto line = owner.read_line(kPatience);
  const auto status = line ? Json::parse(*line, nullptr, false) : Json();
  if (!status.is_object() || !status.contains("owner"))
    return fail(Fault::Refused, "the owner does not say which machine it owns", asked.state);
  static const run::OwnerOptions none;
  return desk::same(status["owner"], desk::identity_of(context.machine_file, asked.own != nullptr ? *asked.own : none),
                    asked.given);
}

}  // namespace

std::optional<std::string> state_of(Context& context, const std::string& option) {
  std::string name;
  if (option.empty() && desk::environment("GANTRY_STATE").empty()) {
    const auto machine = load_machine(context);
    if (!machine) return std::nullopt;
    name = machine->name;
  }
  auto folder = desk::state_folder(option, name, desk::environment);
  if (folder)
    if (auto fit = desk::look_at_state_folder(*folder); !fit) folder = tl::unexpected(fit.error());
  if (folder) return std::move(*folder);
  context.exit_code = show(folder.error(), context.json, context.board);
  return std::nullopt;
}

std::vector<std::string> given_options(const CLI::App& verb) {
  std::vector<std::string> given;
  for (const CLI::App* app : {&verb, verb.get_parent()})
    for (const CLI::Option* option : app->get_options())
      if (option->count() > 0) given.push_back(option->get_name());
  return given;
}

namespace {

constexpr std::array kAlsoAlone{run::OrderKind::Run, run::OrderKind::Home, run::OrderKind::Jog};

bool also_alone(const Asked& asked) { return std::ranges::find(kAlsoAlone, asked.order.kind) != kAlsoAlone.end(); }

/// The owner of the service may be another machine than the one that is meant, and writes results where it may.
Asked to_service(Asked asked) {
  if (also_alone(asked) && std::ranges::find(asked.given, "--machine") == asked.given.end())
    asked.given.push_back("--machine");
  if (asked.shown_folder.empty()) asked.order.under.clear();
  return asked;
}

Error not_that_machine(const std::string& socket) {
  return {Fault::Usage,
          "the owner that is up as a service has another machine than this command; name its machine file with "
          "--machine, or a state folder of your own with --state",
          socket};
}

/// True: it was asked, and what came of it is shown.
bool ask(Context& context, const Asked& asked, const std::string& socket, desk::OrderClient& owner);

}  // namespace

bool ask_owner(Context& context, const Asked& asked) {
  const auto stop_with = [&](const Error& error) {
    context.exit_code = show(error, context.json, context.board);
    return true;
  };
  const std::string own = desk::owner_socket(asked.state);
  auto connected = desk::OrderClient::connect(own);
  if (!connected) return stop_with(connected.error());
  if (*connected) {
    if (auto r = compare(**connected, context, asked); !r) return stop_with(r.error());
    return ask(context, asked, own, **connected);
  }
  const std::string shared = desk::shared_socket(asked.state_option, desk::environment);
  if (shared.empty()) return false;
  auto service = desk::OrderClient::connect(shared);
  // Who may not order the service's machine may still have one of their own.
  if (!service) return also_alone(asked) ? false : stop_with(service.error());
  if (!*service) return false;
  const bool named = std::ranges::find(asked.given, "--machine") != asked.given.end();
  const Asked order = to_service(asked);
  if (auto r = compare(**service, context, order); !r)
    return stop_with(named || r.error().where != "--machine" ? r.error() : not_that_machine(shared));
  return ask(context, order, shared, **service);
}

namespace {

bool ask(Context& context, const Asked& asked, const std::string& socket, desk::OrderClient& owner) {
  const auto stop_with = [&](const Error& error) {
    context.exit_code = show(error, context.json, context.board);
    return true;
  };
  if (also_alone(asked)) log::info("'{}' goes to the owner that is up ({})", run::name(asked.order.kind), socket);
  OwnerElsewhere elsewhere(owner);
  const bool shows_job = asked.order.kind == run::OrderKind::Run && !context.json;
  if (Keys::usable(shows_job)) hold_on_stop_key();
  Keys keys(elsewhere, shows_job ? Keys::Shows::ProgressAndKeys : Keys::Shows::Nothing);
  if (auto r = elsewhere.say(asked.order, kTheOrder); !r) return stop_with(r.error());
  const bool jogs = asked.order.kind == run::OrderKind::Jog;
  const auto answer = wait_for_answer(owner, elsewhere, keys, jogs ? kJogLookEvery : kLookEvery);
  keys.end();
  if (!answer) {
    const Error lost{answer.error().fault, answer.error().message, socket};
    context.exit_code = show(lost, context.json, context.board.empty() ? context.board : kBoardUnknown);
    return true;
  }
  show_answer(context, *answer, asked.shown_folder);
  context.exit_code = exit_code_of(*answer, elsewhere.interrupted());
  return true;
}

}  // namespace

}  // namespace gantry::cli
