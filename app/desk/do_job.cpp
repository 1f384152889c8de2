#include "app/desk/do_job.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <optional>
#include <utility>

#include "app/record/certificate.hpp"
#include "app/record/defects.hpp"
#include "app/record/outcome.hpp"
#include "app/record/room.hpp"
#include "app/record/summary.hpp"
#include "config/inputs.hpp"
#include "core/log.hpp"

namespace gantry::desk {
namespace {

/// The files that its stations are described in.
std::vector<recipes::Source> profiles_of(const config::Machine& machine) {
  std::vector<recipes::Source> profiles;
  for (const config::Station& station : machine.stations) {
    const config::StationProfile& profile = station.profile;
    if (std::ranges::find(profiles, profile.file, &recipes::Source::file) == profiles.end())
      profiles.push_back({profile.file, 0, profile.sha256});
  }
  return profiles;
}

/// All files of the job. A certificate stands beside the report of its job, or nowhere.
Result<void> write_files(JobDone& done, record::KeptRoom room, const config::Machine& machine,
                         const Prepared& prepared) {
  const auto certify = [&](const std::string& folder) -> Result<void> {
    if (!prepared.proof) return {};
    return record::write_certificate(folder, done.result,
                                     {machine, prepared.recipe, prepared.selection, *prepared.proof});
  };
  return record::write_job(done.result, done.folder, certify, std::move(room));
}

/// Of a job that was not proved a report alone is left.
record::Room room_of(const config::Machine& machine, const Prepared& prepared, bool lists_motions) {
  return record::room_for(prepared.proof ? prepared.proof->forecast : job::Forecast{}, prepared.recipe,
                          seconds(machine.bus.cycle), prepared.proof && lists_motions ? prepared.proof->motions : 0);
}

/// The machine had taken it, and did nothing for it.
bool is_refused(const record::JobResult& result) {
  return result.setpoint_ticks == 0 && !result.errors.empty() &&
         (result.errors.front().fault == Fault::Refused || result.errors.front().fault == Fault::SetupMode);
}

}  // namespace

Clamp clamp_at(const config::Machine& machine, const cycle::Snapshot& now) {
  const bool is_moved = machine.outputs[static_cast<std::size_t>(config::Output::Clamp)].has_value();
  const bool told_to_close = (now.outputs & config::bit(config::Output::Clamp)) != 0;
  if ((is_moved && !told_to_close) || config::is_low(machine, now.inputs, config::Input::ClampClosed))
    return Clamp::Open;
  return is_moved ? Clamp::Holds : Clamp::Unseen;
}

Result<JobDone> do_job(const config::Machine& machine, const Prepared& prepared, const record::WantedFolder& wanted,
                       const run::RunOptions& options, const Bench& bench) {
  const auto aside = [&](const std::function<void()>& work) { bench.owner ? bench.owner->aside(work) : work(); };
  const record::Room room = room_of(machine, prepared, options.dry_run);
  record::WantedFolder place = wanted;
  for (const recipes::Source& source : prepared.recipe.sources) place.made_of.push_back(source.file);
  for (const recipes::Source& profile : profiles_of(machine)) place.made_of.push_back(profile.file);
  place.made_of.push_back(machine.file);
  std::optional<Result<record::JobFolder>> folder;
  aside([&] { folder.emplace(record::job_folder(place, prepared.recipe.file, room)); });
  if (!*folder) return tl::unexpected(folder->error());
  JobDone done;
  done.folder = (*folder)->path;
  if (prepared.proof && !prepared.proof->only_when_placed.empty())
    log::info("proved free only when the board is found: {}", job::to_text(prepared.proof->only_when_placed));
  PartOfJob part(bench.parts, prepared, options.serial);
  Result<void> may_run;
  if (!prepared.proof) may_run = tl::unexpected(prepared.proof.error());
  // A bus that is still to come up knows of no hand that has opened the clamp.
  if (may_run)
    aside([&, clamp = bench.bring_up ? Clamp::Unseen : clamp_at(machine, bench.owner->latest())] {
      may_run = part.may_begin(clamp);
    });
  const bool on_bus = bench.owner != nullptr && (!bench.bring_up || may_run);
  if (may_run && bench.bring_up) may_run = bench.bring_up();
  if (may_run) aside([&] { may_run = part.begin(); });
  if (may_run && bench.may_start) may_run = bench.may_start();
  if (may_run) {
    done.result = bench.owner->run(prepared.recipe, prepared.job,
                                   {.out = done.folder,
                                    .dry_run = options.dry_run,
                                    .forecast = &prepared.proof->forecast,
                                    .serial = part.serial(),
                                    .another_board = part.comes_new(),
                                    .before = part.before(),
                                    .begin = bench.begin ? bench.begin() : run::Begin::AtOnce,
                                    .slow_beads = prepared.proof->slow_beads,
                                    .outlives_stops = options.outlives_stops,
                                    .opinion = options.opinion,
                                    .goes_on = !bench.release});
    done.begun = !is_refused(done.result);
    if (done.begun) done.result.once_more = part.once_more();
    if (bench.parts != nullptr) bench.parts->clamped(clamp_at(machine, bench.owner->latest()) != Clamp::Open);
  } else {
    aside([&] {
      done.result = record::begin_result(machine, prepared.recipe, prepared.job, done.folder, options.dry_run);
    });
    if (on_bus) done.result.bus = bench.owner->bus();
    record::add_error(done.result, may_run.error());
  }
  done.result.origin = {prepared.recipe.sources.front().sha256,
                        machine.file,
                        machine.sha256,
                        part.serial(),
                        profiles_of(machine),
                        options.same_machine};
  const bool holds = bench.owner != nullptr && clamp_at(machine, bench.owner->latest()) == Clamp::Holds;
  done.clamp_holds = !bench.release && holds;
  const bool held_on = holds && (!bench.release || (bench.parts != nullptr && bench.parts->outlives_programs()));
  if (bench.release) bench.release();
  Result<void> written;
  aside([&] {
    part.end(done.result, held_on);
    written = write_files(done, std::move((*folder)->room), machine, prepared);
  });
  if (!written)
    record::add_error(
        done.result,
        {written.error().fault,
         fmt::format("summary.json is not kept ({}); the job itself ended as '{}', with the board {}",
                     written.error().message, record::result_word(done.result), record::name(done.result.board)),
         done.folder});
  return done;
}

}  // namespace gantry::desk
