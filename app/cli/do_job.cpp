#include "app/desk/do_job.hpp"

#include <fmt/format.h>

#include "app/cli/front.hpp"
#include "app/cli/job_verbs.hpp"
#include "app/cli/keys.hpp"
#include "app/cli/prepare_heard.hpp"
#include "app/cli/terminal.hpp"
#include "app/desk/figures.hpp"
#include "app/desk/held_for_ever.hpp"
#include "app/desk/state_folder.hpp"
#include "app/record/defects.hpp"
#include "app/record/job_folder.hpp"
#include "app/record/summary.hpp"
#include "core/log.hpp"

namespace gantry::cli {
namespace {

void show_result(const record::JobResult& result, const std::string& folder, bool json) {
  for (const Error& e : result.errors) say("{}\n    remedy: {}\n", to_text(e), info(e.fault).remedy);
  if (json) {
    auto document = record::to_json(result);
    document["folder"] = folder;
    print_document(document);
    return;
  }
  print_text("{}\n", desk::figures(result));
  if (record::has_report(folder)) print_text("  report         {}/report.html\n", folder);
}

/// Somebody at the machine can reset and resume what a stop has left on hold.
bool has_buttons(const config::Machine& machine) {
  const auto has = [&](config::Input input) { return machine.inputs[static_cast<std::size_t>(input)].has_value(); };
  return has(config::Input::Reset) && has(config::Input::Start);
}

}  // namespace

void does_a_job(CLI::App& verb, Context& context) {
  verb.preparse_callback([&context](std::size_t) { context.board = record::name(record::Board::Untouched); });
}

void add_folder(CLI::App& verb, JobRequest& request) {
  auto* out = verb.add_option("--out", request.out, "Folder for the results; default: a new one under out/");
  verb.add_flag("--force", request.force, "Overwrite the results of another job in that folder")->needs(out);
}

void add_selection(CLI::App& verb, recipes::Selection& select) {
  auto* from = verb.add_option("--from", select.from,
                               "Dispense this feature and all behind it; marks, touches and the purge are done anyway");
  auto* only =
      verb.add_option("--only", select.only,
                      "Dispense these features only: names of features, arrays, fills or elements, with commas "
                      "between; may be given again");
  only->delimiter(',')->allow_extra_args(false)->excludes(from);
}

void do_job(Context& context, JobRequest request) {
  hold_machine(Terminal::Matters);
  if (!request.dry_run) hold_on_stop_key();
  if (!request.dry_run && !context.json) stand_behind_a_front();
  const auto stop_with = [&](const std::vector<Error>& errors) {
    context.exit_code = show(errors, context.json, context.board);
  };
  std::optional<desk::BegunParts> parts;
  if (const auto folder = desk::BegunParts::folder(request.owner.state, request.owner, false);
      folder && !request.dry_run) {
    parts.emplace(*folder);
    context.board = record::name(parts->board(request.serial));  // of whatever is refused
  }
  // Mistakes of the command line first: what it names is proved for long.
  if (auto fits = run::check(request.owner); !fits) return stop_with({fits.error()});
  const auto machine = load_machine(context);
  if (!machine) return;
  const record::WantedFolder wanted{.path = request.out, .overwrite = request.force};
  if (auto fits = sim::check_script(request.owner.sim, *machine); !fits) return stop_with(fits.error());
  auto selection =
      desk::filled_in(std::move(request.select), parts ? &*parts : nullptr, request.serial, desk::Clamp::Unseen);
  if (!selection) return stop_with({selection.error()});
  const motion::Opinion opinion = request.dry_run ? motion::fcl_opinion() : motion::Opinion{};
  const auto prepared = prepare_heard("proving " + request.recipe_file, context, [&](const Heard& heard) {
    return desk::prepare(*machine, request.recipe_file, *selection,
                         {.folder = wanted,
                          .certificate = request.certificate,
                          .breath = heard.breath,
                          .progress = heard.progress,
                          .opinion = opinion});
  });
  if (!prepared) return stop_with(prepared.error());
  if (auto fits = sim::check_script(request.owner.sim, *machine, prepared->recipe); !fits)
    return stop_with(fits.error());
  if (parts)
    if (auto open = desk::open_state_folder(request.owner.state); !open) return stop_with({open.error()});
  std::unique_ptr<run::Owner> owner;
  if (prepared->proof) {
    log::info("{}: {} motions proved free at the nominal placement; nearest {}; about {:.0f} s", prepared->recipe.name,
              prepared->proof->motions, job::to_text(prepared->proof->nearest.others), prepared->proof->forecast.s);
    auto opened = run::Owner::open(*machine, request.owner);
    if (!opened) return stop_with({opened.error()});
    owner = std::move(*opened);
  }

  std::optional<OwnerOperated> operated;
  std::optional<Keys> keys;
  desk::Bench bench{.owner = owner.get(), .parts = parts ? &*parts : nullptr};
  std::optional<desk::HeldForEver> held;
  const bool at_keys = Keys::usable(!context.json && !request.dry_run);
  if (owner && !at_keys)
    held.emplace(*owner, machine->bus.cycle,
                 request.dry_run ? desk::HeldForEver::Ends::HoldsToo : desk::HeldForEver::Ends::Stops);
  if (owner) {
    bench.bring_up = [&] {
      operated.emplace(*owner);
      keys.emplace(*operated,
                   context.json      ? Keys::Shows::Nothing
                   : request.dry_run ? Keys::Shows::Progress
                                     : Keys::Shows::ProgressAndKeys,
                   !request.dry_run);
      owner->on_step([&] {
        keys->poll();
        if (held) held->poll();
      });
      return owner->bring_up();
    };
    bench.release = [&] {
      if (keys) keys->end();
      owner->shut_down();
    };
  }
  const bool resumed = at_keys || (owner && owner->world() != nullptr) || has_buttons(*machine);
  const run::RunOptions options{.dry_run = request.dry_run,
                                .serial = request.serial,
                                .same_machine = request.same_machine,
                                .outlives_stops = resumed,
                                .opinion = opinion};
  const auto done = desk::do_job(*machine, *prepared, wanted, options, bench);
  if (!done) return stop_with({done.error()});
  context.exit_code = static_cast<int>(done->result.exit_code);
  show_result(done->result, done->folder, context.json);
}

}  // namespace gantry::cli
