#include "app/monitor/publish.hpp"

#include <chrono>
#include <map>
#include <optional>
#include <thread>
#include <tuple>
#include <unistd.h>
#include <utility>

#include "app/monitor/namesake_watch.hpp"
#include "app/monitor/snapshot_shm.hpp"
#include "app/monitor/topics.hpp"
#include "core/log.hpp"

namespace gantry::monitor {
namespace {

using SteadyClock = std::chrono::steady_clock;

constexpr auto kPoll = std::chrono::milliseconds(4);
constexpr auto kFastest = std::chrono::milliseconds(5);        // a signal that flutters is thinned to this
constexpr auto kStateAnyway = std::chrono::milliseconds(500);  // sent although the loop stands still: age_s tells it
constexpr auto kLook = std::chrono::milliseconds(100);         // how often the owner's life is checked
constexpr auto kJobFastest = std::chrono::milliseconds(100);
constexpr auto kJobAnyway = std::chrono::milliseconds(490);  // and one look more: twice a second

/// What is told at once when it changes.
auto watched(const cycle::Snapshot& s) {
  return std::tuple(s.state, s.latched, s.block, s.feature, s.outputs & ~config::bit(config::Output::Healthy), s.inputs,
                    s.enabled, s.referenced, s.override_factor);
}

class Publisher {
 public:
  Publisher(SnapshotReader in, dds::Participant participant) : in_(std::move(in)), dds_(std::move(participant)) {}

  Result<void> open() {
    using dds::Qos;
    // Keep last: a subscriber that is slow, dead or greedy loses samples and holds nobody up (R94).
    const Speaker self{std::string(in_.info().name.view()), in_.session(), host_name()};
    auto w = dds::writer(dds_, gantry_msg_MachineState_desc, kStateTopic,
                         Qos().reliable().keep_last(1).user_data(announcement(self)));
    if (!w) return tl::unexpected(w.error());
    state_writer_ = std::move(*w);
    w = dds::writer(dds_, gantry_msg_Event_desc, kEventTopic,
                    Qos().reliable().keep_last(kEventsKept).for_latecomers(kEventsKept));
    if (!w) return tl::unexpected(w.error());
    event_writer_ = std::move(*w);
    w = dds::writer(dds_, gantry_msg_Alarm_desc, kAlarmTopic,
                    Qos().reliable().keep_last(1).for_latecomers(1).disposed_by_hand());
    if (!w) return tl::unexpected(w.error());
    alarm_writer_ = std::move(*w);
    w = dds::writer(dds_, gantry_msg_JobStatus_desc, kJobTopic, Qos().reliable().keep_last(1).for_latecomers(1));
    if (!w) return tl::unexpected(w.error());
    job_writer_ = std::move(*w);
    w = dds::writer(dds_, sensor_msgs_msg_dds__JointState__desc, kJointTopic,
                    Qos().reliable().keep_last(1).user_data(kJointStateHash));
    if (!w) return tl::unexpected(w.error());
    joint_writer_ = std::move(*w);
    return namesakes_.open(dds_, self);
  }

  Result<void> run(const PublishOptions& options, const std::atomic<bool>& stop) {
    const auto period =
        std::chrono::duration_cast<SteadyClock::duration>(std::chrono::duration<double>(1 / options.rate_hz));
    for (auto look_at = SteadyClock::now(); !stop.load();) {
      const auto now = SteadyClock::now();
      if (now >= look_at) {
        look_at = now + kLook;
        if (in_.writer_gone() || in_.silence_s() > options.owner_silent_s) break;
        namesakes_.poll(now.time_since_epoch());
      }
      events();
      alarms();
      job(now);
      state(now, period);
      if (failed_ < 0) return fail(Fault::DdsUnusable, std::string("DDS took no sample: ") + dds_strretcode(failed_));
      std::this_thread::sleep_for(kPoll);
    }
    events();  // the last words
    alarms();
    job_at_ = {};
    job(SteadyClock::now());
    dds_wait_for_acks(event_writer_.id(), DDS_MSECS(200));
    return {};
  }

 private:
  void events() {
    SharedEvent event;
    std::uint64_t number = 0;
    while (in_.next(event, number)) {
      const auto sample = event_sample(in_.info(), in_.session(), number, event);
      check(dds_write(event_writer_.id(), &sample));
    }
  }

  void alarms() {
    SharedAlarms now;
    if (!in_.alarms(now) || now.version == alarms_version_) return;
    alarms_version_ = now.version;
    std::map<Fault, gantry_msg_Alarm> gone = std::exchange(alarms_, {});
    for (std::uint32_t i = 0; i < now.count; ++i) {
      const auto sample = alarm_sample(in_.info(), in_.session(), now.alarms[i]);
      check(dds_write(alarm_writer_.id(), &sample));
      alarms_[now.alarms[i].fault] = sample;
      gone.erase(now.alarms[i].fault);
    }
    for (auto& [fault, sample] : gone) {
      sample.active = false;
      check(dds_writedispose(alarm_writer_.id(), &sample));
    }
  }

  void state(SteadyClock::time_point now, SteadyClock::duration period) {
    SharedSnapshot shared;
    if (!in_.newest(shared)) return;
    const bool fresh = !last_ || shared.snapshot.cycle != last_->cycle;
    const bool changed = !last_ || watched(shared.snapshot) != watched(*last_);
    const auto since = now - sent_at_;
    if (last_ && since < (changed ? SteadyClock::duration(kFastest)
                          : fresh ? period
                                  : SteadyClock::duration(kStateAnyway)))
      return;
    last_ = shared.snapshot;
    sent_at_ = now;
    state_.set(in_.info(), in_.session(), shared);
    state_.sample.seq = ++sequence_;
    state_.sample.age_s = age_s(shared);
    state_.sample.events_lost = in_.events_lost();
    state_.sample.events_next = in_.events_next();
    state_.sample.alarms_active = static_cast<std::uint32_t>(alarms_.size());
    state_.sample.job_known = job_known_;
    check(dds_write(state_writer_.id(), &state_.sample));
    joints_.set(in_.info(), shared);
    check(dds_write(joint_writer_.id(), &joints_.sample));
  }

  void job(SteadyClock::time_point now) {
    SharedJob shared;
    if (now - job_at_ < kJobFastest || !in_.job(shared)) return;
    const auto told = std::tuple(shared.state.view(), shared.job.view(), shared.blocks_done, shared.features_done,
                                 shared.message.view());
    const auto before =
        std::tuple(job_.state.view(), job_.job.view(), job_.blocks_done, job_.features_done, job_.message.view());
    if (told == before && now - job_at_ < kJobAnyway) return;
    job_ = shared;
    job_at_ = now;
    job_known_ = true;
    const auto wall = std::chrono::system_clock::now().time_since_epoch();
    const auto sample = job_sample(in_.info(), in_.session(),
                                   std::chrono::duration_cast<std::chrono::nanoseconds>(wall).count(), shared);
    check(dds_write(job_writer_.id(), &sample));
  }

  /// A reader that does not keep up is the reader's trouble; anything else is ours.
  void check(dds_return_t code) {
    if (code < 0 && code != DDS_RETCODE_TIMEOUT) failed_ = code;
  }

  SnapshotReader in_;
  dds::Participant dds_;
  dds::Entity state_writer_, event_writer_, alarm_writer_, job_writer_, joint_writer_;
  NamesakeWatch namesakes_;
  StateSample state_;
  JointSample joints_;
  std::optional<cycle::Snapshot> last_;
  std::map<Fault, gantry_msg_Alarm> alarms_;  ///< that are active, as last written
  std::uint64_t alarms_version_ = 0;
  SharedJob job_;
  bool job_known_ = false;
  SteadyClock::time_point sent_at_{}, job_at_{};
  std::uint64_t sequence_ = 0;
  dds_return_t failed_ = 0;
};

}  // namespace

Result<void> publish(int shm_fd, const PublishOptions& options, const std::atomic<bool>& stop) {
  if (!(options.rate_hz >= 0.1 && options.rate_hz <= 200))
    return fail(Fault::Usage, "the rate of publishing must be between 0.1 and 200 Hz");
  auto in = SnapshotReader::open(shm_fd);
  close(shm_fd);
  if (!in) return tl::unexpected(in.error());
  auto participant = dds::Participant::open(options.network);
  if (!participant) return tl::unexpected(participant.error());
  Publisher publisher(std::move(*in), std::move(*participant));
  if (auto opened = publisher.open(); !opened) return opened;
  return publisher.run(options, stop);
}

}  // namespace gantry::monitor
