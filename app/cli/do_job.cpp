#include "app/desk/do_job.hpp"

#include <fmt/format.h>

#include "app/cli/front.hpp"
#include "app/cli/job_verbs.hpp"
#include "app/cli/keys.hpp"
#include "app/desk/figures.hpp"
#include "app/record/summary.hpp"
#include "core/log.hpp"

namespace gantry::cli {
namespace {

void show_result(const record::JobResult& result, const std::string& folder, bool json) {
  for (const Error& e : result.errors) say("{}\n    remedy: {}\n", to_text(e), info(e.fault).remedy);
  if (json) {
    auto document = record::to_json(result);
    document["folder"] = folder;
    fmt::print("{}\n", document.dump(2));
    return;
  }
  fmt::print("{}\n", desk::figures(result));
  fmt::print("  report         {}/report.html\n", folder);
}

}  // namespace

void do_job(Context& context, JobRequest request) {
  hold_machine(Terminal::Matters);
  if (!request.dry_run) hold_on_stop_key();
  if (!request.dry_run && !context.json) stand_behind_a_front();
  const auto stop_with = [&](const std::vector<Error>& errors) { context.exit_code = show(errors, context.json); };
  const auto machine = load_machine(context);
  if (!machine) return;
  const auto prepared = desk::prepare(*machine, request.recipe_file);
  if (!prepared) return stop_with(prepared.error());
  std::unique_ptr<run::Owner> owner;
  if (prepared->proof) {
    log::info("{}: {} motions proved free at the nominal place; nearest {}; about {:.0f} s", prepared->recipe.name,
              prepared->proof->motions, job::to_text(prepared->proof->nearest.others), prepared->proof->duration_s);
    auto opened = run::Owner::open(*machine, request.owner);
    if (!opened) return stop_with({opened.error()});
    owner = std::move(*opened);
  }

  std::optional<OwnerOperated> operated;
  std::optional<Keys> keys;
  desk::Bench bench{.owner = owner.get()};
  if (owner) {
    bench.bring_up = [&] {
      operated.emplace(*owner, [&] {
        return desk::remaining_s(prepared->proof->duration_s, owner->progress(), owner->latest().override_factor);
      });
      keys.emplace(*operated, !context.json && !request.dry_run, request.dry_run ? nullptr : owner.get());
      owner->on_step([&] { keys->poll(); });
      return owner->bring_up();
    };
    bench.release = [&] {
      if (keys) keys->end();
      owner->shut_down();
    };
  }
  const auto done = desk::do_job(*machine, *prepared, {.out = request.out, .dry_run = request.dry_run}, bench);
  if (!done) return stop_with({done.error()});
  context.exit_code = static_cast<int>(done->result.exit_code);
  show_result(done->result, done->folder, context.json);
}

}  // namespace gantry::cli
