#include "app/run/recording.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <utility>

#include "app/record/outcome.hpp"
#include "core/utc_stamp.hpp"

namespace gantry::run {
namespace {

constexpr const char* kSetpoints = "setpoints.bin";
constexpr const char* kBeadSpeeds = "bead_speeds.csv";

}  // namespace

std::string_view job_word(const cycle::Snapshot& s, bool holds_next) {
  using cycle::State;
  if (s.latched != Fault::None) return "stopped";
  // What waits between two motions stands ready, and the needle that is lifted off what a hold has cut moves.
  const bool waits = holds_next && (s.state == State::Ready || s.state == State::Running);
  return waits || s.state == State::Held ? "held" : "running";
}

Recording::Recording(const config::Machine& machine, const recipes::Recipe& recipe, record::JobResult& result,
                     std::int64_t start_ns, const std::string& out, monitor::SnapshotWriter* watched,
                     record::FileWriter::Thread thread)
    : result_(result),
      watched_(watched),
      trace_(machine, start_ns),
      start_ns_(start_ns),
      now_ns_(start_ns),
      told_ns_(start_ns) {
  if (out.empty()) return;
  files_.setpoints.emplace(out + "/" + kSetpoints, thread);
  files_.bead_speeds.emplace(out + "/" + kBeadSpeeds, recipe, start_ns, thread);
  if (result.dry_run) files_.motions.emplace(out + "/" + record::kMotionFile, machine, thread);
}

void Recording::add(const cycle::Snapshot& s, bool holds_next, const std::string& doing, std::optional<double> left_s) {
  now_ns_ = s.time_ns;
  trace_.add(s);
  hash_.add(s);
  if (files_.setpoints) files_.setpoints->add(s);
  if (files_.bead_speeds) files_.bead_speeds->add(s);
  override_ = s.override_factor;
  left_s_ = left_s;
  if (watched_ == nullptr) return;
  const std::string_view state = job_word(s, holds_next);
  if (now_ns_ - told_ns_ >= kTellEvery_ns || state != told_state_) tell(state, doing);
}

void Recording::note(std::int64_t now_ns, const std::string& words) {
  result_.events.push_back(fmt::format("{:.3f} s  {}", static_cast<double>(now_ns - start_ns_) * 1e-9, words));
}

void Recording::action(std::string what) { result_.actions.push_back({utc_stamp(), elapsed_s(), std::move(what), ""}); }

void Recording::alarm(std::int64_t now_ns, const Error& error) {
  result_.alarms.push_back({utc_stamp(), static_cast<double>(now_ns - start_ns_) * 1e-9, to_text(error),
                            std::string(std::string_view(code(error.fault)))});
}

void Recording::over(std::string_view word) {
  over_ = true;
  tell(word, result_.errors.empty() ? "" : to_text(result_.errors.front()));
}

std::optional<double> Recording::remaining_s() const {
  if (over_) return 0;
  if (!left_s_ || override_ <= 0) return std::nullopt;
  return *left_s_ / std::min(override_, 1.0);  // above 1 a job is not shorter: docs/decisions/018
}

void Recording::tell(std::string_view state, std::string_view message) {
  if (watched_ == nullptr) return;
  told_ns_ = now_ns_;
  told_state_ = state;
  monitor::SharedJob job;
  job.job = result_.job;
  job.recipe = result_.recipe_name;
  job.state = state;
  job.blocks_done = static_cast<std::uint32_t>(result_.blocks_done);
  job.blocks_total = static_cast<std::uint32_t>(result_.blocks_total);
  job.features_done = static_cast<std::uint32_t>(result_.features_done);
  job.features_total = static_cast<std::uint32_t>(result_.features_total);
  job.elapsed_s = elapsed_s();
  job.predicted_s = result_.predicted_s;
  job.remaining_s = remaining_s().value_or(-1);
  job.message = message;
  watched_->push(job);
}

RecordedFiles Recording::finish(bool nothing_lost) {
  trace_.fill(result_);
  result_.setpoint_hash = hash_.value();
  result_.setpoint_ticks = hash_.ticks();
  result_.setpoint_stream_complete = hash_.complete() && nothing_lost;
  return std::exchange(files_, {});
}

void RecordedFiles::close(record::JobResult& result) {
  const auto close_one = [&](auto& file, const char* name) {
    if (!file) return;
    if (auto closed = file->close(); !closed) record::not_kept(result, name, closed.error());
    file.reset();
  };
  close_one(setpoints, kSetpoints);
  close_one(bead_speeds, kBeadSpeeds);
  if (!motions) return;
  if (auto listed = motions->close())
    result.motions_listed = *std::move(listed);
  else
    record::not_kept(result, record::kMotionFile, listed.error());
  motions.reset();
}

}  // namespace gantry::run
