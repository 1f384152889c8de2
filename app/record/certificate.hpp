// certificate.json: what a dry run has proved and what the proof rests on, so that a run can demand that nothing of it
// has changed since.
//   write_certificate(folder, result, {machine, recipe, selection, proof});          // of a dry run that ended "done"
//   auto certificate = read_certificate(path);   auto same = demand(*certificate, machine, recipe, chosen);
// docs/motion/certificate.md tells its keys.
#pragma once
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "app/job/proof_inputs.hpp"
#include "app/job/prove.hpp"
#include "app/record/job_result.hpp"
#include "config/machine.hpp"
#include "core/error.hpp"
#include "recipes/job.hpp"
#include "recipes/selection.hpp"

namespace gantry::record {

inline constexpr const char* kCertificateFile = "certificate.json";

/// A job as it was loaded and proved.
struct ProvedJob {
  const config::Machine& machine;
  const recipes::Recipe& recipe;
  const recipes::Selection& selection;
  const job::NominalProof& proof;
};

nlohmann::ordered_json certificate_json(const JobResult& result, const ProvedJob& proved);
/// Nothing is written of a result that is no dry run's or not "done". Fault::FileUnwritable.
Result<void> write_certificate(const std::string& folder, const JobResult& result, const ProvedJob& proved);

/// What a run demands of a certificate.
struct Certificate {
  std::string file;
  job::ProofInputs inputs;
  recipes::Selection selection;
};

/// Every mistake with file:line:col; at most 1 MiB. Fault 4xx.
Checked<Certificate> read_certificate(const std::string& path);

/// Fault::Refused: a hash is another one (each is named), or a feature of `chosen` (indices in Recipe::features) was
/// not part of the certified job.
Result<void> demand(const Certificate& certificate, const config::Machine& machine, const recipes::Recipe& recipe,
                    const std::vector<std::size_t>& chosen);

}  // namespace gantry::record
