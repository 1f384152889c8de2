#include "app/monitor/heard.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <utility>

#include "core/clean_text.hpp"
#include "core/units.hpp"

namespace gantry::monitor {
namespace {

using Json = nlohmann::ordered_json;
constexpr std::size_t kEventsShown = 5, kEventsHeld = 512, kPastSessionsHeld = 64, kAlarmsHeld = 64;

std::vector<std::string> names(const dds_sequence_gantry_msg_Name& list) {
  std::vector<std::string> result;
  for (std::uint32_t i = 0; i < list._length; ++i) result.push_back(clean_text(list._buffer[i]));
  return result;
}

Json number(double v) { return std::isfinite(v) ? Json(v) : Json(nullptr); }

std::string session_text(std::uint64_t session) { return fmt::format("{:016x}", session); }

Json event_json(const HeardEvent& e) {
  Json j{{"seq", e.seq}, {"time_ns", e.time_ns}, {"cycle", e.cycle}, {"kind", e.kind}, {"severity", e.severity}};
  j["fault"] = e.code.empty() ? Json(nullptr) : Json{{"code", e.code}, {"name", e.fault_name}, {"remedy", e.remedy}};
  j["axis"] = e.axis;
  j["detail"] = e.detail;
  j["value"] = number(e.value);
  j["block"] = e.block;
  j["count"] = e.count;
  j["text"] = e.text;
  return j;
}

Json alarm_json(const HeardAlarm& a) {
  return {{"code", a.code},   {"name", a.fault_name}, {"severity", a.severity}, {"since_ns", a.since_ns},
          {"where", a.where}, {"text", a.text},       {"remedy", a.remedy}};
}

Json job_json(const HeardJob& s) {
  return {{"time_ns", s.time_ns},
          {"job", s.job},
          {"recipe", s.recipe},
          {"state", s.state},
          {"blocks_done", s.blocks_done},
          {"blocks_total", s.blocks_total},
          {"features_done", s.features_done},
          {"features_total", s.features_total},
          {"elapsed_s", number(s.elapsed_s)},
          {"predicted_s", number(s.predicted_s)},
          {"remaining_s", s.remaining_known ? number(s.remaining_s) : Json(nullptr)},
          {"message", s.message}};
}

}  // namespace

/// False when the sample is of a session that has ended: its owner is gone and cannot have sent it now.
bool Heard::current(std::uint64_t session) {
  if (session_ == session) return true;
  if (std::find(past_sessions_.begin(), past_sessions_.end(), session) != past_sessions_.end()) {
    ++replayed_;
    return false;
  }
  if (session_ != 0) {
    past_sessions_.push_back(session_);
    if (past_sessions_.size() > kPastSessionsHeld) past_sessions_.pop_front();
    ++restarts_;
  }
  session_ = session;
  state_.seq = 0;
  next_event_ = 0;
  first_event_ = true;
  alarms_.clear();
  has_job_ = complete_ = false;
  return true;
}

bool Heard::state(const gantry_msg_MachineState& s) {
  if (!current(s.session)) return false;
  // A number that falls is another publisher of the same session, whose count begins anew; a cycle that falls is old.
  if (state_.seq != 0 && s.cycle < state_.cycle) {
    ++replayed_;
    return false;
  }
  if (state_.seq != 0 && s.seq > state_.seq + 1) missed_ += s.seq - state_.seq - 1;
  HeardState h;
  h.machine = clean_text(s.machine), h.state = clean_text(s.state), h.latched_text = clean_text(s.latched_text);
  h.session = s.session, h.seq = s.seq, h.events_lost = s.events_lost;
  h.time_ns = s.time_ns, h.cycle = s.cycle, h.age_s = s.age_s;
  h.override_factor = s.override_factor, h.path_speed = s.path_speed;
  h.block = s.block, h.tick = s.tick, h.feature = s.feature, h.latched_fault = s.latched_fault;
  for (std::uint32_t i = 0; i < s.axes._length; ++i) {
    const auto& a = s.axes._buffer[i];
    h.axes.push_back(
        {clean_text(a.name), a.rotary, a.following_known, a.enabled, a.referenced, a.target, a.actual, a.following});
  }
  h.outputs_on = names(s.outputs_on);
  h.inputs_on = names(s.inputs_on);
  state_ = std::move(h);
  events_next_ = s.events_next, alarms_active_ = s.alarms_active, job_known_ = s.job_known;
  look_if_complete();
  return true;
}

/// Events arrive in their order, so that with the last one all have.
void Heard::look_if_complete() {
  complete_ = complete_ || (has_state() && next_event_ >= events_next_ && alarms_.size() >= alarms_active_ &&
                            (has_job_ || !job_known_));
}

bool Heard::event(const gantry_msg_Event& e) {
  if (!current(e.session)) return false;
  if (!first_event_ && e.seq < next_event_) return false;
  if (!first_event_ && e.seq > next_event_) events_missed_ += e.seq - next_event_;
  first_event_ = false;
  next_event_ = e.seq + 1;
  events_.push_back({.seq = e.seq,
                     .time_ns = e.time_ns,
                     .cycle = e.cycle,
                     .kind = clean_text(e.kind),
                     .code = clean_text(e.code),
                     .fault_name = clean_text(e.fault_name),
                     .severity = clean_text(e.severity),
                     .axis = clean_text(e.axis),
                     .text = clean_text(e.text),
                     .remedy = clean_text(e.remedy),
                     .detail = e.detail,
                     .value = e.value,
                     .block = e.block,
                     .count = e.count});
  ++untold_;
  if (events_.size() > kEventsHeld) events_.pop_front();
  return true;
}

void Heard::alarm(const gantry_msg_Alarm& a, bool active) {
  const std::string code = clean_text(a.code);
  if (!active) {
    if (a.session == session_ || a.session == 0) alarms_.erase(code);
  } else if (current(a.session) && (alarms_.contains(code) || alarms_.size() < kAlarmsHeld)) {
    alarms_[code] = {.code = code,
                     .fault_name = clean_text(a.fault_name),
                     .severity = clean_text(a.severity),
                     .where = clean_text(a.where),
                     .text = clean_text(a.text),
                     .remedy = clean_text(a.remedy),
                     .since_ns = a.since_ns};
  }
}

bool Heard::job(const gantry_msg_JobStatus& s) {
  if (!current(s.session)) return false;
  job_ = {.job = clean_text(s.job),
          .recipe = clean_text(s.recipe),
          .state = clean_text(s.state),
          .message = clean_text(s.message),
          .time_ns = s.time_ns,
          .blocks_done = s.blocks_done,
          .blocks_total = s.blocks_total,
          .features_done = s.features_done,
          .features_total = s.features_total,
          .elapsed_s = s.elapsed_s,
          .predicted_s = s.predicted_s,
          .remaining_known = s.remaining_known,
          .remaining_s = s.remaining_s};
  has_job_ = true;
  return true;
}

Json Heard::to_json(double silent_s) {
  const auto& s = state_;
  Json axes = Json::array();
  for (const auto& a : s.axes)
    axes.push_back({{"name", a.name},
                    {"unit", a.rotary ? "rad" : "mm"},
                    {"target", number(a.target)},
                    {"actual", number(a.actual)},
                    {"following", a.following_known ? number(a.following) : Json("n/a")},
                    {"enabled", a.enabled},
                    {"referenced", a.referenced}});
  Json j{{"machine", s.machine},
         {"session", session_text(s.session)},
         {"complete", complete_},
         {"seq", s.seq},
         {"missed", missed_},
         {"replayed", replayed_},
         {"time_ns", s.time_ns},
         {"cycle", s.cycle},
         {"age_s", number(std::max(s.age_s, silent_s))},
         {"stale", std::max(s.age_s, silent_s) > kStale_s},
         {"state", s.state},
         {"block", s.block},
         {"tick", s.tick}};
  j["feature"] = s.feature < 0 ? Json(nullptr) : Json(s.feature);
  j["override"] = number(s.override_factor);
  j["path_speed_mm_s"] = number(s.path_speed);
  j["axes"] = std::move(axes);
  j["outputs_on"] = s.outputs_on;
  j["inputs_on"] = s.inputs_on;
  j["latched"] = s.latched_fault == 0
                     ? Json(nullptr)
                     : Json{{"code", fmt::format("G{:03}", s.latched_fault)}, {"text", s.latched_text}};
  Json alarms = Json::array();
  for (const auto& [code, alarm] : alarms_) alarms.push_back(alarm_json(alarm));
  j["alarms"] = std::move(alarms);
  j["job"] = has_job_ ? job_json(job_) : Json(nullptr);
  Json told = Json::array();
  for (std::size_t i = events_.size() - std::min(untold_, events_.size()); i < events_.size(); ++i)
    told.push_back(event_json(events_[i]));
  untold_ = 0;
  j["events"] = std::move(told);
  j["events_missed"] = events_missed_ + s.events_lost;
  return j;
}

std::string live_view(const Heard& heard, double silent_s, bool colour) {
  const auto& s = heard.state();
  const auto paint = [&](const char* code, const std::string& text) {
    return colour ? fmt::format("\x1b[{}m{}\x1b[0m", code, text) : text;
  };
  const bool stale = silent_s > Heard::kStale_s || s.age_s > Heard::kStale_s;
  const char* state_colour = s.latched_fault != 0 ? "1;31" : s.state == "running" ? "1;32" : "1";

  std::string out = paint("1", s.machine) + "   " + paint(state_colour, s.state);
  // Between two blocks the loop is ready, but the machine is not free.
  if (heard.has_job() && heard.job().goes_on() && (s.state == "ready" || s.state == "disabled")) out += ", in a job";
  if (s.block != 0) out += fmt::format("   block {} tick {}", s.block, s.tick);
  if (s.feature >= 0) out += fmt::format("   feature {}", s.feature);
  out += fmt::format("   override {:.0f} %   {:.1f} mm/s", s.override_factor * 100, s.path_speed);
  if (stale) out += "   " + paint("1;33", fmt::format("STALE: nothing new for {:.1f} s", std::max(silent_s, s.age_s)));
  out += "\n\n" + paint("2", fmt::format("  {:<8}{:>13}{:>13}{:>12}", "axis", "target", "actual", "following")) + "\n";
  for (const auto& a : s.axes) {
    const double k = a.rotary ? units::deg(1) : 1;
    const auto following = a.following_known ? fmt::format("{:.4f}", a.following * k) : std::string("n/a");
    out += fmt::format("  {:<8}{:>13.4f}{:>13.4f}{:>12}  {:<4}{}{}\n", a.name, a.target * k, a.actual * k, following,
                       a.rotary ? "deg" : "mm", a.enabled ? "" : paint("33", "  off"),
                       a.referenced ? "" : paint("33", "  not referenced"));
  }
  out += fmt::format("\n  outputs  {}\n", fmt::join(s.outputs_on, " "));
  out += fmt::format("  inputs   {}\n", fmt::join(s.inputs_on, " "));
  if (s.latched_fault != 0)
    out += "  " + paint("1;31", fmt::format("latched  G{:03} {}", s.latched_fault, s.latched_text)) + "\n";
  for (const auto& [code, a] : heard.alarms())
    out += "  " +
           paint("1;31", fmt::format("alarm    {} {}{}{}, for {:.0f} s", code, a.where, a.where.empty() ? "" : ": ",
                                     a.text, static_cast<double>(s.time_ns - a.since_ns) * 1e-9)) +
           fmt::format("\n           remedy: {}\n", a.remedy);
  if (heard.has_job()) {
    const auto& j = heard.job();
    out += fmt::format("  job      {} {}: {} of {} features, {} of {} blocks, {:.1f} s{}  {}\n", j.job, j.state,
                       j.features_done, j.features_total, j.blocks_done, j.blocks_total, j.elapsed_s,
                       j.remaining_known ? fmt::format(", about {:.0f} s left", j.remaining_s) : "", j.message);
  }
  const auto& events = heard.events();
  if (!events.empty()) out += "\n";
  for (std::size_t i = events.size() - std::min(kEventsShown, events.size()); i < events.size(); ++i) {
    const auto& e = events[i];
    out += fmt::format("  {:<13}{:<6}{:<4}{}{}\n", e.kind, e.code, e.axis, e.text,
                       e.count > 1 ? fmt::format(" ({} x)", e.count) : "");
  }
  out +=
      paint("2", fmt::format("\n  session {}  sample {}  missed {}", session_text(s.session), s.seq, heard.missed()));
  if (heard.restarts() > 0)
    out += paint("33", fmt::format("  the machine's program was started anew {} x", heard.restarts()));
  if (heard.replayed() > 0) out += paint("33", fmt::format("  {} old samples were played again", heard.replayed()));
  return out + "\n";
}

}  // namespace gantry::monitor
