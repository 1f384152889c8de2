// gantry status, hold, resume, abort, reset, override, enable, disable, park, part-removed, down: one order each to the
// owner that is up.
#include <algorithm>
#include <array>
#include <filesystem>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>
#include <thread>

#include "app/cli/client.hpp"
#include "app/cli/terminal.hpp"
#include "app/cli/usage.hpp"
#include "app/desk/begun_parts.hpp"
#include "app/desk/order_client.hpp"
#include "app/desk/state_folder.hpp"

namespace gantry::cli {
namespace {

using run::OrderKind;

struct OrderVerb {
  OrderKind kind;
  const char* name;
  const char* does;
  const char* more;
};

constexpr std::array kVerbs{
    OrderVerb{OrderKind::Status, "status", "State, job, faults with their remedies, override and axes of the machine",
              "Asks only; it may be called at any time, also while a job runs."},
    OrderVerb{OrderKind::Hold, "hold", "Stops the job, jog or parking that runs, on its path, and keeps it",
              "A feature that is being dispensed is finished first if its end is near (`hold_within` of the machine\n"
              "file, 2 s). If it is not, at the second hold, and with --now the valve shuts in the next cycle and the\n"
              "axes brake on the path; then the needle lifts. They stand with torque: `gantry resume` goes on,\n"
              "`gantry abort` ends the job."},
    OrderVerb{OrderKind::Resume, "resume", "Goes on with what `hold` has stopped",
              "The axes go on along the same path. A bead that the hold has cut is joined where its valve shut, if\n"
              "that is not longer ago than `rejoin_within` of its material; a dot that was cut stays cut."},
    OrderVerb{OrderKind::Abort, "abort", "Ends what is under way: a job, a jog, parking, homing",
              "The valve shuts in the next cycle, the axes brake on their path and keep their torque. It cannot be\n"
              "resumed. The job's report tells how far it came."},
    OrderVerb{OrderKind::Reset, "reset", "Clears a latched fault whose cause is gone; nothing moves",
              "It gives no torque: `gantry enable` does, or the next `gantry run`. `gantry status` names the fault."},
    OrderVerb{OrderKind::Override, "override", "Speed of the motion in percent of what the recipe says",
              "  gantry override 50\nMore than 100 % as far as the `override_max` of the machine file allows, or, "
              "while a job runs,\n"
              "that of all its materials; the axes' own limits always hold. 0 holds now. What is being dispensed is "
              "made slower at "
              "once, and faster when its valve has "
              "shut."},
    OrderVerb{OrderKind::Enable, "enable", "Gives the drives torque", "Homing is an order of its own: `gantry home`."},
    OrderVerb{OrderKind::Disable, "disable", "Takes the torque off all drives, in order",
              "Brakes close first. Refused while something moves: `gantry abort` ends it."},
    OrderVerb{
        OrderKind::Park, "park", "Moves the head to the park position of the machine file; needs `gantry home`",
        "Straight up to the safe height where the head is lower, then on a path that is proved free, at the speed of\n"
        "a job's travel. The valve stays shut, the clamp may be open; refused in setup. A hold and an abort (Ctrl-C)\n"
        "stop on that path."},
    OrderVerb{
        OrderKind::PartRemoved, "part-removed", "Opens the clamp: the part may be taken out by hand",
        "After a job that ended otherwise than done the clamp stays shut until this is said. A part that was\n"
        "begun and not finished is not waited for in the machine any more; one with a serial stays known by it,\n"
        "so that it can be finished later, until this is said with --serial. Without an owner no clamp opens, and\n"
        "the rest is done all the same."},
    OrderVerb{OrderKind::Quit, "down", "Ends the owner: torque off, bus down in order",
              "A job that runs is stopped first, on its path and with the valve shut, and its report is written."},
};

/// Its socket goes before it does, and is all that is seen of an owner in another PID namespace.
Result<void> wait_until_gone(const desk::OrderClient& owner, const std::string& socket) {
  constexpr std::chrono::seconds kPatience{30};
  constexpr Time kLookEvery = milliseconds(20);
  const auto gone = [&] {
    if (const auto ended = owner.process_ended(kLookEvery)) return *ended;
    std::this_thread::sleep_for(kLookEvery);
    return !std::filesystem::exists(socket);
  };
  const auto until = std::chrono::steady_clock::now() + kPatience;
  while (!gone()) {
    if (interrupted()) return fail(Fault::ClientEnded, "interrupted while the owner was ending, which it goes on with");
    if (std::chrono::steady_clock::now() >= until)
      return fail(Fault::Refused,
                  "the owner has taken the order and has not ended yet: it still writes the files of a job, or waits "
                  "for a station; it ends by itself when the disk or the station answers");
  }
  return {};
}

/// Of a machine without an owner.
void forget_part(Context& context, const std::string& state, const std::string& serial) {
  std::vector<std::string> said;
  for (desk::BegunParts& parts : desk::BegunParts::all(state)) {
    const auto forgotten = parts.forget_removed(serial);
    if (!forgotten) return void(context.exit_code = show(forgotten.error(), context.json));
    if (*forgotten) said.push_back(desk::removal_in_words(*forgotten, serial, !parts.outlives_programs()));
  }
  if (said.empty()) said.push_back(desk::removal_in_words(std::nullopt, serial, true));
  const std::string words = fmt::format(
      "{}\nno owner is up: the clamp stays as it is, and what is remembered was looked for in {}; another "
      "machine's or the service's stands elsewhere (--machine, --state)",
      fmt::join(said, "\n"), state);
  if (context.json)
    show_document("ok", {{"ok", true}, {"said", words}});
  else
    print_text("{}\n", words);
}

/// A machine file that the user names is the owner's, but for a stop: that is never refused.
std::vector<std::string> compared(const CLI::App& verb, const run::Order& order) {
  const bool stops = order.kind == OrderKind::Abort || order.kind == OrderKind::Hold ||
                     (order.kind == OrderKind::Override && order.value == 0);
  const std::vector<std::string> given = given_options(verb);
  const bool named = std::ranges::find(given, "--machine") != given.end();
  return named && !stops ? std::vector<std::string>{"--machine"} : std::vector<std::string>();
}

void send_order(Context& context, const CLI::App& verb, const std::string& option, const run::Order& order) {
  const auto state = state_of(context, option);
  if (!state) return;
  const std::string socket = desk::owner_socket(*state);
  Asked asked{
      .order = order, .state = *state, .state_option = option, .given = compared(verb, order), .changed_since = true};
  if (order.kind == OrderKind::Quit) asked.afterwards = wait_until_gone;
  if (ask_owner(context, asked)) return;
  if (order.kind == OrderKind::PartRemoved) return forget_part(context, *state, order.serial);
  const Error nobody{Fault::Refused, "no owner is up here; start one with `gantry up`", socket};
  context.exit_code = show(nobody, context.json);
}

}  // namespace

namespace {

void add_order(CLI::App& to, const char* name, const OrderVerb& row, Context& context) {
  auto* verb = to.add_subcommand(name, row.does);
  auto state = std::make_shared<std::string>();
  auto percent = std::make_shared<double>(100);
  auto serial = std::make_shared<std::string>();
  auto now = std::make_shared<bool>(false);
  verb->add_option("--state", *state, kStateHelp);
  if (row.kind == OrderKind::PartRemoved)
    verb->add_option("--serial", *serial, "Serial number of the part, where it is not the one in the machine")
        ->check(run::wrong_with_serial);
  if (row.kind == OrderKind::Override)
    verb->add_option("PERCENT", *percent, "100 is the recipe's speed")->required()->check(override_percent);
  if (row.kind == OrderKind::Hold) verb->add_flag("--now", *now, "Do not wait for the end of the feature");
  verb->footer(row.more);
  verb->callback([&context, &row, verb, state, percent, serial, now] {
    send_order(context, *verb, *state, {.kind = row.kind, .serial = *serial, .value = *percent / 100, .now = *now});
  });
}

}  // namespace

void add_orders(CLI::App& app, Context& context) {
  for (const OrderVerb& row : kVerbs) {
    add_order(app, row.name, row, context);
    if (row.kind != OrderKind::PartRemoved) continue;
    // Said in two words, too: what a person tries first must not be told as a slip for `park`.
    auto* part = app.add_subcommand("part", "")->group("")->require_subcommand(1);
    add_order(*part, "removed", row, context);
  }
}

}  // namespace gantry::cli
