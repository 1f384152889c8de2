// What is kept of the job that runs: trace, hash, setpoint file, and its news for those who watch. One for each job,
// fed by the one reader of snapshots; which features are done stands in the result, where the runner keeps it.
//   Recording recording(machine, result, now_ns, options.out, shared);   recording.add(snapshot); ...
//   recording.finish(nothing_lost);
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "app/monitor/snapshot_shm.hpp"
#include "app/record/job_result.hpp"
#include "app/record/setpoint_file.hpp"
#include "app/record/setpoint_hash.hpp"
#include "app/record/trace.hpp"

namespace gantry::run {

class Recording {
 public:
  /// `out` is the folder for setpoints.bin, "" keeps none; `watched` may be null.
  Recording(const config::Machine& machine, record::JobResult& result, std::int64_t start_ns, const std::string& out,
            monitor::SnapshotWriter* watched);

  void add(const cycle::Snapshot& snapshot);
  /// Something that belongs into the job's list of events.
  void note(std::int64_t now_ns, const std::string& words);
  /// What somebody did to the machine, "hold", "override 50 %".
  void action(std::string what);
  /// What latched.
  void alarm(std::int64_t now_ns, const Error& error);
  /// Tells those who watch where the job is.
  void tell(std::string_view state);
  /// What the job came to: everything but the world's part. Closes the file.
  void finish(bool nothing_lost);

  [[nodiscard]] std::size_t features_done() const { return result_.features_done; }
  [[nodiscard]] std::size_t features_total() const { return result_.features_total; }
  [[nodiscard]] double elapsed_s() const { return static_cast<double>(now_ns_ - start_ns_) * 1e-9; }

 private:
  record::JobResult& result_;
  monitor::SnapshotWriter* watched_;
  record::Trace trace_;
  record::SetpointHash hash_;
  std::optional<record::SetpointFile> setpoints_;
  std::size_t features_shown_ = 0;  ///< of those done, that the watchers know
  std::int64_t start_ns_, now_ns_;
};

}  // namespace gantry::run
