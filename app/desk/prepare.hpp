// A recipe, loaded, compiled and proved for a machine: what a job needs before a machine is asked for.
//   auto prepared = prepare(machine, "board.yaml", {.only = {"dam"}});     // Checked<Prepared>: every mistake, with
//   its location
// A job that is to be one that a dry run has certified is compared with the certificate, and proved all the same.
#pragma once
#include <optional>
#include <string>

#include "app/job/prove.hpp"
#include "app/record/job_folder.hpp"
#include "config/machine.hpp"
#include "core/error.hpp"
#include "recipes/job.hpp"
#include "recipes/selection.hpp"

namespace gantry::desk {

struct Prepared {
  recipes::Recipe recipe;
  recipes::Job job;  ///< of what is selected
  recipes::Selection selection;
  Result<job::NominalProof> proof;  ///< its error: the job is not feasible, and nothing may move
};

/// What is looked at besides the proof.
struct Checks {
  std::optional<record::WantedFolder> folder{};  ///< for the results; looked at first
  std::string certificate{};  ///< a file that must match (app/record/certificate.hpp); "": none is demanded
  Breath breath{};            ///< of the proof
  Progress progress{};        ///< of the proof
  motion::Opinion opinion{};  ///< asked of each motion of the proof; empty: nobody is
};

/// Fault::Refused: the certificate does not match. FolderInUse and the like: there can be no results there.
Checked<Prepared> prepare(const config::Machine& machine, const std::string& recipe_file,
                          const recipes::Selection& selection = {}, const Checks& checks = {});

}  // namespace gantry::desk
