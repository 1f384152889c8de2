// What is kept of the job that runs: trace, hash, setpoint file, and its news for those who watch. One for each job,
// fed by the one reader of snapshots; which features are done stands in the result, where the runner keeps it.
//   Recording recording(machine, recipe, result, now_ns, folder, watched);
//   recording.add(snapshot, holds_next, doing, left_s); ...
//   RecordedFiles files = recording.finish(nothing_lost);   files.close(result);
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "app/monitor/snapshot_shm.hpp"
#include "app/record/bead_speed_file.hpp"
#include "app/record/job_result.hpp"
#include "app/record/motion_file.hpp"
#include "app/record/setpoint_file.hpp"
#include "app/record/setpoint_hash.hpp"
#include "app/record/trace.hpp"

namespace gantry::run {

/// A job as those who watch are told of it while it lasts: "running", "held", or "stopped" by a fault that is latched.
/// `holds_next`: its next motion waits for a resume.
std::string_view job_word(const cycle::Snapshot& snapshot, bool holds_next);

/// The files that grew with a job.
struct RecordedFiles {
  std::optional<record::SetpointFile> setpoints;
  std::optional<record::BeadSpeedFile> bead_speeds;
  std::optional<record::MotionFile> motions;  ///< of a dry run

  /// Waits for the disk. What could not be kept is told in the result.
  void close(record::JobResult& result);
};

class Recording {
 public:
  /// `recipe` outlives it. `out` is the folder for setpoints.bin, bead_speeds.csv and, of a dry run, motions.csv; ""
  /// keeps none; `thread` writes them. `watched` may be null.
  Recording(const config::Machine& machine, const recipes::Recipe& recipe, record::JobResult& result,
            std::int64_t start_ns, const std::string& out, monitor::SnapshotWriter* watched,
            record::FileWriter::Thread thread = record::FileWriter::Thread::Callers);

  /// Those who watch hear of it at least every kTellEvery_ns of machine time, whatever the job does. `doing` in words;
  /// `left_s` is the time that the job will still take at an override of 100 %.
  void add(const cycle::Snapshot& snapshot, bool holds_next, const std::string& doing, std::optional<double> left_s);
  /// Something that belongs into the job's list of events.
  void note(std::int64_t now_ns, const std::string& words);
  /// What somebody did to the machine, "hold", "override 50 %".
  void action(std::string what);
  /// What latched.
  void alarm(std::int64_t now_ns, const Error& error);
  /// Those who watch are told where it is: "running" as long as it has shown no cycle.
  void begin(std::optional<double> left_s) { left_s_ = left_s, tell("running", "begins"); }
  /// The job is over; `word` as record::result_word() has it. Those who watch are told why, too.
  void over(std::string_view word);
  /// Where the motions that are played are listed; null: nowhere.
  [[nodiscard]] record::MotionFile* motions() { return files_.motions ? &*files_.motions : nullptr; }
  /// What the job came to: everything but the world's part. Nothing is recorded any more; the files are for whoever may
  /// wait for a disk to close.
  RecordedFiles finish(bool nothing_lost);

  [[nodiscard]] std::size_t features_done() const { return result_.features_done; }
  [[nodiscard]] std::size_t features_total() const { return result_.features_total; }
  [[nodiscard]] double elapsed_s() const { return static_cast<double>(now_ns_ - start_ns_) * 1e-9; }
  /// About how long the job will still take at the override of now. Nothing where that is not known, 0 where the job
  /// is over.
  [[nodiscard]] std::optional<double> remaining_s() const;

  static constexpr std::int64_t kTellEvery_ns = 50'000'000;

 private:
  void tell(std::string_view state, std::string_view message);

  record::JobResult& result_;
  monitor::SnapshotWriter* watched_;
  record::Trace trace_;
  record::SetpointHash hash_;
  RecordedFiles files_;
  std::int64_t start_ns_, now_ns_;
  std::int64_t told_ns_;  ///< when the watchers were told last
  std::string told_state_;
  std::optional<double> left_s_;
  double override_ = 1;
  bool over_ = false;
};

}  // namespace gantry::run
