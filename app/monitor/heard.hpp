// What a monitor has heard of a machine, and how it is shown: as JSON for programs, as a few lines for people.
//   Heard heard;   heard.state(sample);   heard.event(sample);   heard.alarm(sample, active);   heard.job(sample);
//   heard.to_json()   one sample            live_view(heard, 0.02, true)   text for a terminal
// Knows nothing of DDS but its sample types, so that it can be tested without a network. All text is cleaned where it
// comes in: nothing that was heard steers a terminal.
#pragma once
#include <cstdint>
#include <deque>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "gantry_topics.h"

namespace gantry::monitor {

/// A sample of MachineState that owns what it holds.
struct HeardState {
  struct Axis {
    std::string name;
    bool rotary = false, following_known = false, enabled = false, referenced = false;
    double target = 0, actual = 0, following = 0;
  };
  std::string machine, state, latched_text;
  std::uint64_t session = 0, seq = 0, events_lost = 0;
  std::int64_t time_ns = 0, cycle = 0;
  double age_s = 0, override_factor = 1, path_speed = 0;
  std::uint32_t block = 0, tick = 0;
  std::int32_t feature = -1;
  std::vector<Axis> axes;
  std::vector<std::string> outputs_on, inputs_on;
  std::uint16_t latched_fault = 0;
};

struct HeardEvent {
  std::uint64_t seq = 0;
  std::int64_t time_ns = 0, cycle = 0;
  std::string kind, code, fault_name, severity, axis, text, remedy;  ///< code, fault_name, remedy: "" of no fault
  std::int32_t detail = 0;
  double value = 0;
  std::uint32_t block = 0, count = 1;
};

struct HeardAlarm {
  std::string code, fault_name, severity, where, text, remedy;
  std::int64_t since_ns = 0;
};

struct HeardJob {
  std::string job, recipe, state, message;
  std::int64_t time_ns = 0;
  std::uint32_t blocks_done = 0, blocks_total = 0, features_done = 0, features_total = 0;
  double elapsed_s = 0, predicted_s = 0;
  bool remaining_known = false;
  double remaining_s = 0;
  /// It has not come to its result.
  [[nodiscard]] bool goes_on() const { return state == "running" || state == "held" || state == "stopped"; }
};

class Heard {
 public:
  static constexpr double kStale_s = 1.0;  ///< a machine that is silent for longer is shown as stale

  /// False for a sample that is older than what is known: somebody plays it again (R91). It is counted, not shown.
  bool state(const gantry_msg_MachineState& sample);
  /// False also for an event that was heard before (a publisher that was started again repeats what it still knows).
  bool event(const gantry_msg_Event& sample);
  /// `active`: false for one that is gone; then the sample's key is enough.
  void alarm(const gantry_msg_Alarm& sample, bool active);
  bool job(const gantry_msg_JobStatus& sample);

  [[nodiscard]] bool has_state() const { return !state_.machine.empty(); }
  [[nodiscard]] const HeardState& state() const { return state_; }
  /// Samples of the state that did not arrive, and how often the machine's program was started anew meanwhile.
  [[nodiscard]] std::uint64_t missed() const { return missed_; }
  [[nodiscard]] int restarts() const { return restarts_; }
  [[nodiscard]] std::uint64_t replayed() const { return replayed_; }
  /// The newest events, oldest first.
  [[nodiscard]] const std::deque<HeardEvent>& events() const { return events_; }
  /// The active ones, by code.
  [[nodiscard]] const std::map<std::string, HeardAlarm>& alarms() const { return alarms_; }
  [[nodiscard]] bool has_job() const { return has_job_; }
  [[nodiscard]] const HeardJob& job() const { return job_; }
  /// All that was published in this session before, and is kept for who comes late, has been heard.
  [[nodiscard]] bool complete() const { return complete_; }

  /// The newest state with alarms and job, and the events that were not told yet; they then count as told.
  nlohmann::ordered_json to_json(double silent_s = 0);

 private:
  bool current(std::uint64_t session);
  void look_if_complete();

  HeardState state_;
  std::uint64_t events_next_ = 0;  ///< the last three as the newest state tells them
  std::uint32_t alarms_active_ = 0;
  bool job_known_ = false, complete_ = false;
  HeardJob job_;
  bool has_job_ = false;
  std::map<std::string, HeardAlarm> alarms_;
  std::deque<HeardEvent> events_;
  std::size_t untold_ = 0;
  std::uint64_t session_ = 0, next_event_ = 0, events_missed_ = 0, missed_ = 0, replayed_ = 0;
  bool first_event_ = true;
  std::deque<std::uint64_t> past_sessions_;  // the newest 64
  int restarts_ = 0;
};

/// A few lines, each ended by a newline. `silent_s`: since the last state was heard. `colour`: terminal colours.
std::string live_view(const Heard& heard, double silent_s, bool colour);

}  // namespace gantry::monitor
