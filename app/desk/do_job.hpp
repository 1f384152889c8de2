// The one way in which a prepared job is done, whoever asks for it: there is a folder, the machine is made ready, the
// job runs, and whatever becomes of it is written there.
//   auto prepared = prepare(machine, "board.yaml");                                      // Checked<Prepared>
//   auto done = do_job(machine, *prepared, {}, {.dry_run = false}, {&owner});   // Result<JobDone>
#pragma once
#include <functional>
#include <string>

#include "app/desk/part_of_job.hpp"
#include "app/desk/prepare.hpp"
#include "app/record/job_folder.hpp"
#include "app/record/job_result.hpp"
#include "app/run/owner.hpp"
#include "config/machine.hpp"
#include "core/error.hpp"

namespace gantry::desk {

/// As far as the machine's outputs and inputs tell. Without them nobody sees it open; what holds a part by an output of
/// the program's own lets nobody get it out before it opens.
Clamp clamp_at(const config::Machine& machine, const cycle::Snapshot& now);

struct JobDone {
  record::JobResult result;
  std::string folder;
  bool begun = false;        ///< false: not proved, or refused, before anything was done for it
  bool clamp_holds = false;  ///< its part, and the owner goes on: an order opens the clamp
};

/// The machine that a job is done on.
struct Bench {
  run::Owner* owner = nullptr;               ///< null only where the proof has failed
  std::function<Result<void>()> bring_up{};  ///< before the first motion; empty: the owner is up
  std::function<void()> release{};           ///< when nothing moves any more, before the files are written
  /// Asked last before the owner has the job: an order that came in while the owner was served beside files may have
  /// ended it. Empty: nothing has.
  std::function<Result<void>()> may_start{};
  /// Asked behind it: somebody may want the job to wait before its first motion. Empty: nobody does.
  std::function<run::Begin()> begin{};
  BegunParts* parts = nullptr;  ///< what is remembered of parts that were not finished; null: nothing is
};

/// A job that was not proved is not run, and its result says why; so it does of one whose part was begun before and
/// not finished (part_of_job.hpp). `options.out` is set here. An error: there is no folder, and nothing has begun.
Result<JobDone> do_job(const config::Machine& machine, const Prepared& prepared, const record::WantedFolder& folder,
                       const run::RunOptions& options, const Bench& bench);

}  // namespace gantry::desk
