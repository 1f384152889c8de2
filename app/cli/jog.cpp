// gantry jog AXIS DISTANCE ...: moves axes by a displacement, as a client of the owner that is up.
#include "app/job/jog.hpp"

#include <fmt/format.h>

#include "app/cli/client.hpp"
#include "app/desk/state_folder.hpp"

namespace gantry::cli {
namespace {

/// "X", "10mm", "Z", "-2 mm": pairs of what was typed.
Result<job::JogWords> pairs(const std::vector<std::string>& typed, std::string speed) {
  job::JogWords words{.by = {}, .speed = std::move(speed)};
  if (typed.size() % 2 != 0)
    return fail(Fault::Usage, "each axis is followed by how far it goes, in one word: X 10mm, or X \"10 mm\"");
  for (std::size_t i = 0; i < typed.size(); i += 2)
    if (!words.by.emplace(typed[i], typed[i + 1]).second)
      return fail(Fault::Usage, fmt::format("axis {} is named twice", typed[i]));
  return words;
}

}  // namespace

void add_jog(CLI::App& app, Context& context) {
  auto* verb =
      app.add_subcommand("jog", "Moves axes by a displacement on a straight line; needs `gantry up` and `gantry home`");
  auto typed = std::make_shared<std::vector<std::string>>();
  auto speed = std::make_shared<std::string>();
  auto state = std::make_shared<std::string>();
  verb->add_option("AXIS DISTANCE", *typed, "Axes, each with how far it goes from where it stands")->required();
  verb->add_option("--speed", *speed,
                   "Of all mm axes together; deg/s where only rotary axes go; default: 20 of these; never more than "
                   "what stands within 100 ms");
  verb->add_option("--state", *state, kStateHelp);
  verb->footer(
      "  gantry jog Z -2mm\n"
      "  gantry jog X 40mm Y \"-12.5 mm\" --speed \"50 mm/s\"\n"
      "The whole path is proved free before anything moves: of the machine's own bodies, and of the board and parts "
      "of\n"
      "the last job where that has found them. A hold and an abort (Ctrl-C) stop on that path. The valve stays shut.\n"
      "The axes move while this program runs: they stand within 100 ms when it ends, is stopped or is killed, and go "
      "no\n"
      "faster than that allows (docs/operating.md). An override above 100 % makes no jog faster.");
  verb->callback([&context, verb, typed, speed, state] {
    const auto words = pairs(*typed, *speed);
    if (!words) return void(context.exit_code = show(words.error(), context.json));
    const auto folder = state_of(context, *state);
    if (!folder) return;
    if (ask_owner(context, {.order = {.kind = run::OrderKind::Jog, .jog = *words},
                            .state = *folder,
                            .state_option = *state,
                            .given = given_options(*verb)}))
      return;
    const auto machine = load_machine(context);
    if (!machine) return;
    const auto jog = job::read_jog(*machine, *words, job::JogFor::Client);
    const Error nobody{Fault::NotReferenced,
                       "no owner is up, and only one that is knows where the axes stand; start `gantry up`, then "
                       "`gantry home`",
                       desk::owner_socket(*folder)};
    context.exit_code = show(jog ? nobody : jog.error(), context.json);
  });
}

}  // namespace gantry::cli
