// What the tests over DDS share: the owner of a pretended machine, whose child is publish_tool, and a monitor that
// collects what it hears.
//   Owner owner;   for (const auto& j : heard(listening(60))) ...
#pragma once
#include <atomic>
#include <csignal>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <optional>
#include <sstream>
#include <thread>
#include <unistd.h>
#include <vector>

#include "app/monitor/child.hpp"
#include "app/monitor/monitor.hpp"
#include "app/monitor/snapshot_shm.hpp"
#include "tests/app/monitor/samples.hpp"

namespace gantry::monitor {

inline constexpr double kPatience_s = 30;

/// A domain of this process's own: other tests may run beside it.
inline int own_domain() {
  static const int domain = 1 + static_cast<int>(getpid() % 200);
  return domain;
}

/// The owner of a pretended machine: pushes snapshots, polls its child.
class Owner {
 public:
  Owner() {
    ChildOptions options;
    options.program = PUBLISH_TOOL;
    options.arguments = {"--domain", std::to_string(own_domain())};
    options.back_off_first = milliseconds(50);
    child_.emplace(writer_->fd(), options);
    thread_ = std::thread([this] { run(); });
  }
  ~Owner() {
    quit_ = true;
    thread_.join();
  }
  std::atomic<int> kill_children{0};  ///< set by the test; counted down when one was killed
  std::atomic<std::int64_t> cycle{0};
  std::atomic<int> starts{0};
  std::atomic<pid_t> publisher{-1};
  std::atomic<int> notes{0};            ///< set by the test; counted down as notes are pushed
  std::atomic<bool> door_open{false};   ///< an alarm
  std::atomic<bool> job_stands{false};  ///< nothing of it changes but its clock

 private:
  void run() {
    MonotonicClock clock;
    pid_t killed = 0;
    auto shared = running_snapshot();
    SharedEvent e;
    e.event.kind = cycle::EventKind::Fault;
    e.event.fault = Fault::DoorOpen;
    writer_->push(e.event, "somebody opened the door");
    SharedJob job;
    job.job = "demo", job.state = "running";
    const Error alarm{Fault::DoorOpen, "the door of the pretended machine is open", "station 9 'io'"};
    for (auto due = clock.now(); !quit_; due += milliseconds(1)) {
      shared.snapshot.cycle = ++cycle;
      writer_->push(shared.snapshot);
      if (cycle % 100 == 0 && !job_stands) ++job.features_done;
      job.elapsed_s = static_cast<double>(cycle) * 1e-3;
      if (cycle % 50 == 0) writer_->push(job);
      for (int i = 0; i < 4 && notes > 0; ++i, --notes) {
        e.event.fault = Fault::LateCycle;
        writer_->push(e.event, "a note", 1);
      }
      if (cycle % 10 == 0) writer_->alarms(door_open ? std::vector{alarm} : std::vector<Error>{});
      child_->poll(clock.now());
      starts = child_->starts();
      publisher = child_->pid();
      if (kill_children > 0 && child_->alive() && child_->pid() != killed) {
        killed = child_->pid();
        kill(killed, SIGKILL);
        --kill_children;
      }
      clock.sleep_until(due);
    }
  }
  Result<SnapshotWriter> writer_ = SnapshotWriter::create(bench_machine());
  std::optional<PublishChild> child_;
  std::atomic<bool> quit_{false};
  std::thread thread_;
};

inline MonitorOptions listening(std::uint64_t count) {
  MonitorOptions o;
  o.network.domain = own_domain();
  o.json = true;
  o.count = count;
  o.for_s = kPatience_s;
  o.notice = [](const std::string&) {};
  return o;
}

inline std::vector<nlohmann::json> heard(const MonitorOptions& options) {
  std::ostringstream out;
  const std::atomic<bool> stop{false};
  const auto done = monitor(options, out, stop);
  EXPECT_TRUE(done) << done.error().message;
  std::vector<nlohmann::json> lines;
  std::istringstream in(out.str());
  for (std::string line; std::getline(in, line);) lines.push_back(nlohmann::json::parse(line));
  return lines;
}

}  // namespace gantry::monitor
