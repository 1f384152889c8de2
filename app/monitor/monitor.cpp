#include "app/monitor/monitor.hpp"

#include <algorithm>
#include <chrono>
#include <fmt/format.h>
#include <map>
#include <ostream>
#include <unistd.h>

#include "app/monitor/heard.hpp"
#include "app/monitor/line_limit.hpp"
#include "app/monitor/namesake_watch.hpp"
#include "app/monitor/topics.hpp"
#include "core/clean_text.hpp"
#include "core/log.hpp"
#include "core/status_line.hpp"
#include "core/units.hpp"

namespace gantry::monitor {
namespace {

using SteadyClock = std::chrono::steady_clock;
constexpr auto kRedraw = std::chrono::milliseconds(100);
constexpr double kHistory_s = 1;            // for which a first line waits for what was published before
constexpr std::size_t kMostMachines = 256;  // names come from the network: who invents more is not listened to
constexpr std::size_t kMostHosts = 64;

double since(SteadyClock::time_point t) { return std::chrono::duration<double>(SteadyClock::now() - t).count(); }

struct Machine {
  Heard heard;
  SteadyClock::time_point at = SteadyClock::now(), since = at;
  bool shown = false;         // a line of it was written
  bool told_silence = false;  // for the lines without redraw
  Namesakes namesakes;
  std::map<std::uint64_t, std::string> hosts;  // of the sessions that were heard
  std::string namesakes_told;                  // two machines of this name, in words
};

class Monitor {
 public:
  Monitor(const MonitorOptions& options, std::ostream& out) : options_(options), out_(out) {}

  Result<void> open() {
    using dds::Qos;
    auto participant = dds::Participant::open(options_.network);
    if (!participant) return tl::unexpected(participant.error());
    dds_ = std::move(*participant);
    // Best effort, so that a slow terminal never makes the publisher wait.
    auto r = dds::reader(dds_, gantry_msg_MachineState_desc, kStateTopic, Qos().best_effort().keep_last(16));
    if (!r) return tl::unexpected(r.error());
    states_ = std::move(*r);
    r = dds::reader(dds_, gantry_msg_Event_desc, kEventTopic,
                    Qos().reliable().keep_last(kEventsKept).for_latecomers(kEventsKept));
    if (!r) return tl::unexpected(r.error());
    events_ = std::move(*r);
    r = dds::reader(dds_, gantry_msg_Alarm_desc, kAlarmTopic, Qos().reliable().keep_last(1).for_latecomers(1));
    if (!r) return tl::unexpected(r.error());
    alarms_ = std::move(*r);
    r = dds::reader(dds_, gantry_msg_JobStatus_desc, kJobTopic, Qos().reliable().keep_last(1).for_latecomers(1));
    if (!r) return tl::unexpected(r.error());
    jobs_ = std::move(*r);
    waitset_ = dds::Entity(dds_create_waitset(dds_.id()));
    condition_ = dds::Entity(dds_create_readcondition(states_.id(), DDS_ANY_STATE));
    const auto attached = dds_waitset_attach(waitset_.id(), condition_.id(), 1);
    if (attached < 0) return fail(Fault::DdsUnusable, dds_strretcode(attached));
    return {};
  }

  Result<void> run(const std::atomic<bool>& stop) {
    const auto begin = SteadyClock::now();
    while (!stop.load() && !enough_) {
      if (options_.for_s > 0 && since(begin) >= options_.for_s) break;
      dds_attach_t woken[1];
      dds_waitset_wait(waitset_.id(), woken, 1, DDS_MSECS(50));
      dds::take_all<gantry_msg_Event>(events_, [&](const auto& s, const auto&) {
        if (Machine* m = machine(s.machine)) m->heard.event(s);
      });
      dds::take_changes<gantry_msg_Alarm>(alarms_, [&](const auto& s, const auto& info) {
        const bool active = info.valid_data && info.instance_state == DDS_IST_ALIVE && s.active;
        if (Machine* m = machine(s.machine)) m->heard.alarm(s, active);
      });
      dds::take_all<gantry_msg_JobStatus>(jobs_, [&](const auto& s, const auto&) {
        if (Machine* m = machine(s.machine)) m->heard.job(s);
      });
      dds::take_all<gantry_msg_MachineState>(states_, [&](const auto& s, const auto& info) {
        if (Machine* m = machine(s.machine)) take(*m, s, info.publication_handle);
      });
      if (!options_.json) draw(begin);
      silences(begin);
      if (!out_) break;  // nobody reads any more
    }
    for (auto& [name, m] : machines_)
      if (options_.json && !enough_ && m.heard.has_state() && !m.shown) show(m);
    if (samples_ == 0 && !stop.load()) return fail(Fault::NoMachineHeard, not_heard(since(begin)));
    return {};
  }

 private:
  /// Null for one that is not listened to.
  Machine* machine(const char* name) {
    if (!options_.machine.empty() && options_.machine != name) return nullptr;
    if (machines_.size() >= kMostMachines && !machines_.contains(name)) return nullptr;
    return &machines_[name];
  }

  void take(Machine& m, const gantry_msg_MachineState& sample, dds_instance_handle_t writer) {
    if (enough_) return;
    tell_namesakes(m, sample, writer);
    if (!m.heard.state(sample)) return;
    m.at = SteadyClock::now();
    if (m.told_silence) tell(fmt::format("machine '{}' is heard again", sample.machine));
    m.told_silence = false;
    if (options_.json && !m.shown && !m.heard.complete() && since(m.since) < kHistory_s) return;
    show(m);
  }

  /// One more sample for whoever reads.
  void show(Machine& m) {
    m.shown = true;
    enough_ = ++samples_ == options_.count && options_.count != 0;
    if (options_.json)
      print(m);
    else if (!options_.live)
      out_ << line(m.heard) << std::endl;
  }

  void print(Machine& m) {
    out_ << escape_steering(
                m.heard.to_json(since(m.at)).dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace))
         << std::endl;
  }

  void tell_namesakes(Machine& m, const gantry_msg_MachineState& sample, dds_instance_handle_t writer) {
    if (!m.hosts.contains(sample.session)) {
      const auto speaker = speaker_of(states_, writer);
      if (m.hosts.size() >= kMostHosts) m.hosts.clear();
      m.hosts[sample.session] = speaker && speaker->session == sample.session ? speaker->host : "";
    }
    const auto other = m.namesakes.heard(sample.session);
    if (!other) return;
    m.namesakes_told = namesake_words({sample.machine, sample.session, m.hosts[sample.session]},
                                      {sample.machine, *other, m.hosts[*other]});
    if (!options_.live) tell(m.namesakes_told);
  }

  /// Without a terminal to redraw: one line a sample.
  static std::string line(const Heard& heard) {
    const auto& s = heard.state();
    auto text = fmt::format("{} {} block {} tick {}", s.machine, s.state, s.block, s.tick);
    for (const auto& a : s.axes)
      text += a.rotary ? fmt::format("  {} {:.4f} deg", a.name, units::deg(a.actual))
                       : fmt::format("  {} {:.4f} mm", a.name, a.actual);
    if (s.latched_fault != 0) text += fmt::format("  latched G{:03}", s.latched_fault);
    return text;
  }

  void draw(SteadyClock::time_point begin) {
    if (!options_.live || (since(drawn_at_) < std::chrono::duration<double>(kRedraw).count() && !enough_)) return;
    drawn_at_ = SteadyClock::now();
    std::string text;
    for (const auto& [name, m] : machines_)
      if (m.heard.has_state()) {
        text += live_view(m.heard, since(m.at), colour_);
        if (!m.namesakes_told.empty())
          text += (colour_ ? "  \x1b[1;31m" : "  ") + printable(m.namesakes_told) + (colour_ ? "\x1b[0m\n" : "\n");
        text += "\n";
      }
    if (text.empty()) text = since(begin) > options_.silence_s ? not_heard(since(begin)) + "\n" : "listening ...\n";
    // Back to where the last picture began, then over it; what was longer is erased to the end.
    if (lines_ > 0) out_ << fmt::format("\x1b[{}F", lines_);
    std::string picture;
    // A line that is too long is cut, not wrapped: the next picture counts lines.
    for (std::string_view left = text; !left.empty();) {
      const std::size_t end = std::min(left.find('\n'), left.size());
      picture += cut_to(left.substr(0, end), columns_of(STDOUT_FILENO)) + "\x1b[K\n";
      left.remove_prefix(std::min(end + 1, left.size()));
    }
    out_ << picture << "\x1b[J" << std::flush;
    lines_ = std::count(text.begin(), text.end(), '\n');
  }

  void silences(SteadyClock::time_point begin) {
    if (options_.live) return;  // the picture says it
    if (samples_ == 0 && !told_nothing_ && since(begin) > options_.silence_s) {
      told_nothing_ = true;
      tell(not_heard(since(begin)));
    }
    for (auto& [name, m] : machines_) {
      if (m.told_silence || !m.heard.has_state() || since(m.at) <= options_.silence_s) continue;
      m.told_silence = true;
      if (options_.json) print(m);  // once more what was heard last, as stale
      tell(fmt::format("machine '{}' has been silent for {:.1f} s: what was heard of it is stale", name, since(m.at)));
    }
  }

  std::string not_heard(double s) const {
    const auto who = options_.machine.empty() ? std::string("no machine") : "machine '" + options_.machine + "' not";
    const auto where = options_.network.interface.empty() ? "on this computer" : "on " + options_.network.interface;
    return fmt::format("{} heard for {:.0f} s {} (DDS domain {}); is `gantry up` or `gantry run` running?", who, s,
                       where, options_.network.domain);
  }

  void tell(const std::string& words) {
    if (!limit_.admit(SteadyClock::now().time_since_epoch())) return;
    const std::string text = printable(words) + limit_.left_out_words();
    if (options_.notice)
      options_.notice(text);
    else
      log::warn("{}", text);
  }

  MonitorOptions options_;
  std::ostream& out_;
  dds::Participant dds_;
  dds::Entity states_, events_, alarms_, jobs_, waitset_, condition_;
  std::map<std::string, Machine> machines_;
  std::uint64_t samples_ = 0;
  LineLimit limit_;
  bool enough_ = false, told_nothing_ = false;
  SteadyClock::time_point drawn_at_{};
  std::ptrdiff_t lines_ = 0;
  const bool colour_ = !no_color();
};

}  // namespace

Result<void> monitor(const MonitorOptions& options, std::ostream& out, const std::atomic<bool>& stop) {
  Monitor m(options, out);
  if (auto opened = m.open(); !opened) return opened;
  return m.run(stop);
}

}  // namespace gantry::monitor
