#include "app/desk/do_job.hpp"

#include <fmt/format.h>

#include "app/cli/front.hpp"
#include "app/cli/job_verbs.hpp"
#include "app/cli/keys.hpp"
#include "app/record/deposit_figures.hpp"
#include "app/record/summary.hpp"
#include "core/log.hpp"
#include "core/units.hpp"

namespace gantry::cli {
namespace {

void show_figures(const record::JobResult& result) {
  fmt::print("{}: {} of {} features, {:.1f} s of motion ({:.1f} s planned)\n", record::result_word(result),
             result.features_done, result.features_total, result.actual_s, result.predicted_s);
  if (result.has_offset)
    fmt::print("  work offset    dx {:+.3f} mm, dy {:+.3f} mm, rot {:+.4f} deg (rms {:.1f} um)\n",
               result.offset.shift.x, result.offset.shift.y, units::deg(result.offset.rotation),
               result.offset_rms_mm * 1000);
  if (result.has_world) {
    const record::DepositFigures f = record::deposit_figures(result);
    fmt::print("  deposits       {}", result.deposits.size());
    if (f.worst != nullptr)
      fmt::print(", worst '{}': {:.1f} um beside, {:.0f} um allowed", f.worst->id, f.worst->error_mm * 1000,
                 f.worst_allowed_mm * 1000);
    if (f.strays > 0) fmt::print(", {} on no feature", f.strays);
    fmt::print("\n  collisions     {}\n", result.collisions.size());
  }
  fmt::print("  wake-up        p50 {:.0f} us, p99 {:.0f} us, max {:.0f} us; {} cycles skipped\n",
             static_cast<double>(result.cycles.wake.p50) / 1e3, static_cast<double>(result.cycles.wake.p99) / 1e3,
             static_cast<double>(result.cycles.wake.max) / 1e3, result.cycles.skipped);
  fmt::print("  setpoint hash  {:016x} over {} ticks{}\n", result.setpoint_hash, result.setpoint_ticks,
             result.setpoint_stream_complete ? "" : " (incomplete)");
}

void show_result(const record::JobResult& result, const std::string& folder, bool json) {
  for (const Error& e : result.errors) say("{}\n    remedy: {}\n", to_text(e), info(e.fault).remedy);
  if (json) {
    auto document = record::to_json(result);
    document["folder"] = folder;
    fmt::print("{}\n", document.dump(2));
    return;
  }
  if (result.cycles.cycles == 0)
    fmt::print("{} before it began\n", record::result_word(result));
  else
    show_figures(result);
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
    log::info("{}: {} motions proved free at the nominal place, nearest {:.2f} mm; about {:.0f} s",
              prepared->recipe.name, prepared->proof->motions, prepared->proof->minimum_clearance_mm,
              prepared->proof->duration_s);
    auto opened = run::Owner::open(*machine, request.owner);
    if (!opened) return stop_with({opened.error()});
    owner = std::move(*opened);
  }

  std::optional<Keys> keys;
  desk::Bench bench{.owner = owner.get()};
  if (owner) {
    bench.bring_up = [&] {
      keys.emplace(*owner, !context.json && !request.dry_run);
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
