#include "app/cli/client.hpp"

#include <algorithm>
#include <array>
#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <nlohmann/json.hpp>

#include "app/cli/keys.hpp"
#include "app/cli/owner_elsewhere.hpp"
#include "app/cli/signals.hpp"
#include "app/cli/terminal.hpp"
#include "app/desk/answer.hpp"
#include "app/desk/identity.hpp"
#include "app/desk/order_client.hpp"
#include "app/desk/order_line.hpp"
#include "app/desk/patience.hpp"
#include "app/desk/state_folder.hpp"
#include "app/job/hold_to_run.hpp"
#include "app/record/job_folder.hpp"
#include "core/log.hpp"
#include "core/shell_words.hpp"

namespace gantry::cli {
namespace {

using desk::Json;

constexpr int kNoCode = 1;  // of an answer that has none

/// How often it asks for the status: of a jog this is the sign of life that keeps it going.
constexpr Time kLookEvery = milliseconds(100), kJogLookEvery = job::hold_to_run::kBeat;
/// Looks without an answer: an owner that says nothing is asked no more. A jog's are its sign of life, too.
constexpr int kMostLooks = 1, kMostJogLooks = 20;

Error left(std::string_view why) { return {Fault::ClientEnded, std::string(why), ""}; }
const Error kInterrupted = left("interrupted before the owner had answered");

/// The answer to `OwnerElsewhere::kTheOrder`; what else comes meanwhile is looked at or shown.
Result<Json> wait_for_answer(desk::OrderClient& owner, OwnerElsewhere& elsewhere, Keys& keys, bool jogs) {
  const MonotonicClock clock;
  const Time look_every = jogs ? kJogLookEvery : kLookEvery;
  const int most_looks = jogs ? kMostJogLooks : kMostLooks;
  desk::Patience patience(clock);
  Time next_look = clock.now();
  for (;;) {
    if (clock.now() >= next_look) {
      if (elsewhere.looks_open() < most_looks)
        static_cast<void>(elsewhere.say({.kind = run::OrderKind::Status}, OwnerElsewhere::kLook));
      next_look = clock.now() + look_every;
    }
    const auto line = owner.read_line(std::clamp(next_look - clock.now(), Time(0), Time(milliseconds(25))));
    if (line) patience.heard();
    if (terminal_lost()) return tl::unexpected(left("the terminal is gone; the owner goes on"));
    keys.poll();
    const auto answer = line ? Json::parse(*line, nullptr, false) : Json();
    if (answer.is_object()) {
      const Json id = answer.value("id", Json());
      if (id == OwnerElsewhere::kTheOrder || id.is_null()) return answer;  // without: the connection is refused
      elsewhere.hear(answer);
      if (!answer.value("ok", false) && id == OwnerElsewhere::kKey)
        for (const Error& e : desk::errors_of(answer)) log::report(e);
    }
    if (elsewhere.left()) return tl::unexpected(kInterrupted);
    if (!line && owner.gone()) return fail(Fault::Refused, "the owner has ended before it answered");
    if (!patience.over()) continue;
    elsewhere.take_back();
    return tl::unexpected(owner.silent());
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
  std::error_code gone;
  const std::string here = std::filesystem::current_path(gone).string() + "/";
  return !gone && folder.starts_with(here) ? folder.substr(here.size()) : folder;
}

/// The exit code, which is that of the document if one is shown.
int show_answer(const Context& context, const Json& answer, const std::string& shown_folder) {
  const int exit_code =
      answer.value("ok", false) ? static_cast<int>(ExitCode::Done) : answer.value("exit_code", kNoCode);
  const std::vector<Error> errors = desk::errors_of(answer);
  const std::string folder = answer.value("folder", "");
  const std::string shown = shown_folder.empty() ? as_seen_from_here(folder) : shown_folder;
  if (folder.empty() && !errors.empty())
    return show(errors, context.json, answer.value("board", std::string(context.board)));
  for (const Error& e : errors) say("{}\n    remedy: {}\n", to_text(e), info(e.fault).remedy);
  if (context.json) {
    Json summary = folder.empty() ? Json() : summary_in(folder, shown);
    if (summary.is_null()) {
      show_document(errors.empty() ? "ok" : "failed", answer, exit_code, errors);
    } else {
      summary["exit_code"] = exit_code;
      print_document(summary);
    }
    return exit_code;
  }
  print_text("{}\n", answer.value("said", answer.value("state", "done")));
  if (record::has_report(folder)) print_text("  report         {}/report.html\n", shown);
  return exit_code;
}

/// The options that the user wrote are those of the owner.
Result<void> compare(desk::OrderClient& owner, const Context& context, const Asked& asked) {
  if (asked.given.empty()) return {};
  if (!owner.send(desk::to_line(run::Order{.kind = run::OrderKind::Status}, OwnerElsewhere::kLook)))
    return tl::unexpected(owner.silent());
  const MonotonicClock clock;
  desk::Patience patience(clock);
  std::optional<std::string> line;
  while (!(line = owner.read_line(milliseconds(25))) && !owner.gone()) {
    if (interrupted()) return tl::unexpected(left("interrupted before anything was ordered"));
    if (patience.over()) return tl::unexpected(owner.silent());
  }
  const auto status = line ? Json::parse(*line, nullptr, false) : Json();
  if (!status.is_object() || !status.contains("owner"))
    return fail(Fault::Refused, "the owner does not say which machine it owns", asked.state);
  static const run::OwnerOptions none;
  return desk::same(status["owner"], desk::identity_of(context.machine_file, asked.own != nullptr ? *asked.own : none),
                    asked.given, asked.changed_since ? desk::MachineFile::SamePath : desk::MachineFile::SameBytes);
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
  for (const CLI::App* app = &verb; app != nullptr; app = app->get_parent())
    for (const CLI::Option* option : app->get_options())
      if (option->count() > 0) given.push_back(option->get_name());
  return given;
}

std::string same_machine(const CLI::App& verb, const std::vector<std::string>& names) {
  std::string words;
  for (const CLI::App* app = &verb; app != nullptr; app = app->get_parent())
    for (const CLI::Option* option : app->get_options())
      if (option->count() > 0 && std::ranges::find(names, option->get_name()) != names.end())
        for (const std::string& value : option->results())
          words += fmt::format(" {} {}", option->get_name(), shell_word(value));
  return words;
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
  const run::OrderKind kind = asked.order.kind;
  OwnerElsewhere elsewhere(owner, kind);
  const bool shows_job = kind == run::OrderKind::Run && !context.json;
  if (client_row(kind).on_stop_key != OnStopKey::Stops) hold_on_stop_key();
  if (interrupted()) return stop_with(left("interrupted before anything was ordered"));
  Keys keys(elsewhere, shows_job ? Keys::Shows::ProgressAndKeys : Keys::Shows::Nothing);
  auto answer = [&]() -> Result<Json> {
    if (auto said = elsewhere.say(asked.order, OwnerElsewhere::kTheOrder); !said) return tl::unexpected(owner.silent());
    return wait_for_answer(owner, elsewhere, keys, kind == run::OrderKind::Jog);
  }();
  keys.end();
  if (!answer) {
    const Error lost{answer.error().fault, answer.error().message, socket};
    context.exit_code = show(lost, context.json, context.board.empty() ? context.board : kBoardUnknown);
    return true;
  }
  if (answer->value("ok", false) && asked.afterwards)
    if (auto r = asked.afterwards(owner, socket); !r) return stop_with({r.error().fault, r.error().message, socket});
  context.exit_code = show_answer(context, *answer, asked.shown_folder);
  return true;
}

}  // namespace

}  // namespace gantry::cli
