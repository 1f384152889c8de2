// gantry check [FILE...]: machine files, recipes, profiles of stations and world scripts, every mistake at once.
#include <algorithm>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "app/cli/file_kind.hpp"
#include "app/cli/prepare_heard.hpp"
#include "app/cli/shipped.hpp"
#include "app/cli/signals.hpp"
#include "app/cli/terminal.hpp"
#include "app/cli/verbs.hpp"
#include "app/desk/do_job.hpp"
#include "app/desk/state_folder.hpp"
#include "app/job/settle.hpp"
#include "app/stations/measured.hpp"
#include "config/bus_notes.hpp"
#include "core/shell_words.hpp"
#include "recipes/bus_notes.hpp"
#include "recipes/job.hpp"
#include "recipes/travel.hpp"
#include "sim/script/script.hpp"
#include "sim/world/script_on_board.hpp"

namespace gantry::cli {
namespace {

/// What was found in the files.
struct Findings {
  std::vector<Error> errors;
  std::vector<std::string> good;  ///< a line for each file that is right
  std::vector<std::string> notes, assumptions;
  std::vector<std::string> bus_notes;  ///< what the loss of the bus or of the program costs

  /// Takes the mistakes; true: there are none.
  template <class T>
  bool take(const Checked<T>& checked) {
    if (!checked) errors.insert(errors.end(), checked.error().begin(), checked.error().end());
    return checked.has_value();
  }
};

/// Stated and measured delays side by side; what was measured on virtual drives is told as such.
void add_measured(config::Machine& machine, Findings& to) {
  const auto folder = desk::state_folder("", machine.name, desk::environment);
  if (!folder) return;
  for (const char* bus : {"ethercat", "sim"}) {
    for (config::Axis& axis : machine.axes) axis.measured.reset();
    if (auto read = stations::read_measured(stations::measured_file(*folder, bus), machine); !read)
      to.notes.push_back("warning: " + to_text(read.error()));
    for (const config::Axis& axis : machine.axes)
      if (axis.measured) to.notes.push_back(fmt::format("{} [{}]", stations::measured_in_words(axis), bus));
  }
}

std::optional<config::Machine> check_machine(const std::string& file, Findings& to) {
  auto machine = machine_in(file);
  if (!to.take(machine)) return std::nullopt;
  to.good.push_back(fmt::format("{}: {} axes, {} stations", file, machine->axes.size(), machine->stations.size()));
  for (auto& note : config::notes(*machine)) to.notes.push_back(std::move(note));
  for (auto& note : config::bus_notes(*machine)) to.bus_notes.push_back(std::move(note));
  add_measured(*machine, to);
  for (auto& each : config::assumptions(*machine)) to.assumptions.push_back(std::move(each));
  return std::move(*machine);
}

std::optional<recipes::Recipe> check_recipe(const std::string& file, const config::Machine& machine,
                                            const Context& context, Findings& to) {
  auto prepared = prepare_heard("checking " + file, context, [&](const Heard& heard) {
    return desk::prepare(machine, file, {}, {.breath = heard.breath, .progress = heard.progress});
  });
  if (!to.take(prepared)) return std::nullopt;
  if (prepared->proof) {
    to.good.push_back(fmt::format("{}: {} features on '{}', {} motions proved free, about {:.0f} s", file,
                                  prepared->recipe.features.size(), machine.name, prepared->proof->motions,
                                  prepared->proof->forecast.s));
    for (const auto& note : recipes::notes(prepared->recipe, machine)) to.notes.push_back(file + ": " + note);
    for (const auto& note : recipes::bus_notes(prepared->recipe, machine)) to.bus_notes.push_back(file + ": " + note);
    if (prepared->recipe.order == recipes::Order::Shortest)
      to.notes.push_back(
          fmt::format("{}: `order: shortest`: the needle {}", file,
                      to_text(recipes::travel_of(prepared->recipe, recipes::dispensed_by(prepared->job)))));
    for (const job::SlowBead& slow : prepared->proof->slow_beads) {
      const auto& bead = std::get<recipes::Bead>(prepared->recipe.features[slow.feature]);
      to.notes.push_back(fmt::format("{}: bead '{}' {}; as it is, {}", job::at_line(prepared->recipe, bead.location),
                                     bead.id, job::in_words(slow, prepared->recipe),
                                     slow.narrowly ? "a job may end with defects" : "every job ends with defects"));
    }
    for (const job::RunUp& begun : prepared->proof->run_ups) {
      const auto& bead = std::get<recipes::Bead>(prepared->recipe.features[begun.feature]);
      to.notes.push_back(fmt::format("{}: bead '{}' {}", job::at_line(prepared->recipe, bead.location), bead.id,
                                     job::in_words(begun, *recipes::find_material(prepared->recipe, bead.material))));
    }
    if (const auto& named = prepared->proof->only_when_placed; !named.empty())
      to.notes.push_back(
          fmt::format("{}: proved free at the nominal placement, but not wherever marks and touches may find "
                      "the board: {}; found where they are not, a job ends before it dispenses",
                      file, job::to_text(named)));
  } else {
    to.errors.push_back(prepared->proof.error());
  }
  return std::move(prepared->recipe);
}

void check_profile(const std::string& file, Findings& to) {
  const auto profile = config::load_profile(file);
  if (to.take(profile)) to.good.push_back(fmt::format("{}: {}", file, profile->title));
}

/// On the board of `recipe`, when there is one: without it nobody knows its marks and features.
void check_script(const std::string& file, const config::Machine& machine, const std::optional<recipes::Recipe>& recipe,
                  Findings& to) {
  const auto script = sim::load_script(file, machine);
  if (!to.take(script)) return;
  const auto misfits = recipe ? sim::misfits_of(*script, sim::board_plan(*recipe), {}) : std::vector<Error>{};
  to.errors.insert(to.errors.end(), misfits.begin(), misfits.end());
  if (misfits.empty()) to.good.push_back(fmt::format("{}: {} entries", file, script->size()));
}

void show_findings(const Findings& found, const std::vector<std::string>& files, bool list_assumptions,
                   const Context& context) {
  if (context.json) {
    show_document("ok", {{"checked", files},
                         {"notes", found.notes},
                         {"bus_notes", found.bus_notes},
                         {"assumptions", found.assumptions}});
    return;
  }
  for (const std::string& line : found.good) print_text("{}\n", line);
  for (const std::string& note : found.notes) print_text("  note: {}\n", note);
  if (context.verbose)
    for (const std::string& note : found.bus_notes) print_text("  note: {}\n", note);
  else if (!found.bus_notes.empty())
    print_text("  {} notes say what the loss of the bus or of the program costs; `gantry -v check` lists them\n",
               found.bus_notes.size());
  if (list_assumptions)
    for (const std::string& each : found.assumptions) print_text("  assumed: {}\n", each);
  else
    print_text("  {} things are assumed of the stations; {} lists them\n", found.assumptions.size(),
               files.front() == reference_machine() ? "`gantry check` alone"
                                                    : "`gantry check " + shell_word(files.front()) + "`");
}

}  // namespace

void add_check(CLI::App& app, Context& context) {
  auto* verb = app.add_subcommand("check", "Machine files, recipes, scripts: every mistake at once, file:line:col");
  auto files = std::make_shared<std::vector<std::string>>();
  verb->add_option(
      "FILE", *files,
      "What to check: files, or the name of a machine that comes with gantry; recipes on the first machine named here, "
      "else on --machine; scripts on the first recipe");
  verb->callback([&context, files] {
    std::vector<std::pair<std::string, FileKind>> rest;
    std::vector<std::string> machines;
    for (const std::string& word : *files) {
      const std::string file = machine_file(word);  // or the name of one that comes with gantry
      const FileKind kind = kind_of(file);
      if (kind == FileKind::Machine)
        machines.push_back(file);
      else
        rest.emplace_back(file, kind);
    }
    if (machines.empty()) machines.push_back(context.machine_file);

    Findings found;
    std::vector<std::string> checked = machines;
    std::optional<config::Machine> machine;
    for (const std::string& file : machines) {
      auto read = check_machine(file, found);
      if (file == machines.front()) machine = std::move(read);
    }
    std::optional<recipes::Recipe> board;
    std::stable_partition(rest.begin(), rest.end(), [](const auto& each) { return each.second != FileKind::Script; });
    for (const auto& [file, kind] : rest) {
      if (interrupted()) break;
      checked.push_back(file);
      if (kind == FileKind::Profile) check_profile(file, found);
      if (!machine) continue;  // its own mistakes are told
      if (kind == FileKind::Recipe)
        if (auto recipe = check_recipe(file, *machine, context, found); recipe && !board) board = std::move(recipe);
      if (kind == FileKind::Script) check_script(file, *machine, board, found);
    }
    if (interrupted() && found.errors.empty())
      found.errors.push_back({Fault::Interrupted, "interrupted before every file was checked", ""});
    if (found.errors.empty())
      show_findings(found, checked, rest.empty(), context);
    else
      context.exit_code = show(found.errors, context.json);
  });
}

}  // namespace gantry::cli
