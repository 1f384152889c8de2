#include "app/run/recording.hpp"

#include <fmt/format.h>

#include "app/record/program.hpp"
#include "core/log.hpp"

namespace gantry::run {

Recording::Recording(const config::Machine& machine, record::JobResult& result, std::int64_t start_ns,
                     const std::string& out, monitor::SnapshotWriter* watched)
    : result_(result), watched_(watched), trace_(machine, start_ns), start_ns_(start_ns), now_ns_(start_ns) {
  if (out.empty()) return;
  if (auto file = record::SetpointFile::create(out + "/setpoints.bin"))
    setpoints_.emplace(std::move(*file));
  else
    log::report(file.error());
}

void Recording::add(const cycle::Snapshot& s) {
  now_ns_ = s.time_ns;
  trace_.add(s);
  hash_.add(s);
  if (setpoints_) setpoints_->add(s);
  if (result_.features_done == features_shown_) return;
  features_shown_ = result_.features_done;
  tell("running");
}

void Recording::note(std::int64_t now_ns, const std::string& words) {
  result_.events.push_back(fmt::format("{:.3f} s  {}", static_cast<double>(now_ns - start_ns_) * 1e-9, words));
}

void Recording::action(std::string what) {
  result_.actions.push_back({record::utc_stamp(), elapsed_s(), std::move(what), ""});
}

void Recording::alarm(std::int64_t now_ns, const Error& error) {
  result_.alarms.push_back({record::utc_stamp(), static_cast<double>(now_ns - start_ns_) * 1e-9, to_text(error),
                            std::string(std::string_view(code(error.fault)))});
}

void Recording::tell(std::string_view state) {
  if (watched_ == nullptr) return;
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
  watched_->push(job);
}

void Recording::finish(bool nothing_lost) {
  trace_.fill(result_);
  result_.setpoint_hash = hash_.value();
  result_.setpoint_ticks = hash_.ticks();
  result_.setpoint_stream_complete = hash_.complete() && nothing_lost;
  if (!setpoints_) return;
  if (auto closed = setpoints_->close(); !closed) log::report(closed.error());
  setpoints_.reset();
}

}  // namespace gantry::run
