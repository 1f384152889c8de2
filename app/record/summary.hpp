// summary.json: a job's result for programs. Always valid JSON: what is not known is null or "n/a", never NaN, and text
// that is no UTF-8 is repaired.
//   write_summary("out/job", result);      // out/job/summary.json, whole or not at all
#pragma once
#include <nlohmann/json.hpp>
#include <span>
#include <string>

#include "app/record/job_result.hpp"
#include "core/error.hpp"

namespace gantry::record {

/// "done", "done_with_defects", "interrupted", "aborted" or "failed".
std::string result_word(const JobResult& result);

/// "VIRTUAL", the interface ("ethercat:eth0"), or "none" of a job that was refused before it had one.
std::string bus_in_words(const JobResult& result);

/// Keys in a fixed order, the verdict first. docs/monitoring.md lists them.
nlohmann::ordered_json to_json(const JobResult& result);
nlohmann::ordered_json to_json(const devices::CyclicCounts& counts);
/// {by_design, others}: {distance_mm, pair, motion, where, at_mm, machine_mm} of each, or null.
nlohmann::ordered_json to_json(const job::Clearances& clearances);
/// {feature, kind, message} of each.
nlohmann::ordered_json to_json(std::span<const Defect> defects);

/// The whole document. `files`: what else the job has left beside it.
std::string summary_text(const JobResult& result, std::span<const std::string> files = {});

/// Fault::FileUnwritable.
Result<void> write_summary(const std::string& dir, const JobResult& result, std::span<const std::string> files = {});

}  // namespace gantry::record
