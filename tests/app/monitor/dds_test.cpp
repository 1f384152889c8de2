// Publisher and monitor in two processes over loopback, as `gantry publish` and `gantry monitor` are. What is waited
// for has generous limits; nothing depends on how fast it comes.
#include <atomic>
#include <csignal>
#include <dds/dds.h>
#include <fstream>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <sstream>
#include <sys/wait.h>
#include <thread>
#include <unistd.h>

#include "app/monitor/child.hpp"
#include "app/monitor/snapshot_shm.hpp"
#include "app/monitor/topics.hpp"
#include "tests/app/monitor/over_dds.hpp"
#include "tests/app/monitor/samples.hpp"

namespace gantry::monitor {
namespace {

TEST(MonitorOverDds, hears_state_event_and_job_of_a_machine_in_another_process) {
  Owner owner;
  const auto lines = heard(listening(60));
  ASSERT_EQ(lines.size(), 60u);
  std::size_t events = 0;
  bool job = false;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const auto& j = lines[i];
    EXPECT_EQ(j.at("machine"), "bench");
    EXPECT_EQ(j.at("session"), lines[0].at("session"));
    EXPECT_EQ(j.at("axes").size(), 2u);
    EXPECT_EQ(j.at("axes")[1].at("following"), "n/a");
    if (i > 0) {
      EXPECT_GT(j.at("cycle").get<std::int64_t>(), lines[i - 1].at("cycle").get<std::int64_t>());
    }
    for (const auto& e : j.at("events")) {
      ++events;
      EXPECT_EQ(e.at("text"), "somebody opened the door");
      EXPECT_EQ(e.at("fault").at("code"), "G704");
    }
    job = job || (!j.at("job").is_null() && j.at("job").at("job") == "demo");
  }
  EXPECT_EQ(events, 1u) << "an event from before the monitor came is told, once";
  EXPECT_TRUE(job);
}

TEST(MonitorOverDds, a_killed_publisher_is_started_again_and_the_owner_does_not_notice) {
  Owner owner;
  auto before = heard(listening(5));
  const auto cycle = owner.cycle.load();
  owner.kill_children = 3;
  for (int i = 0; i < 3000 && (owner.kill_children > 0 || owner.starts < 4); ++i)
    std::this_thread::sleep_for(milliseconds(10));
  EXPECT_GE(owner.starts, 4);
  EXPECT_GT(owner.cycle, cycle);
  const auto after = heard(listening(5));
  ASSERT_EQ(after.size(), 5u);
  EXPECT_EQ(after[0].at("session"), before[0].at("session"));
  EXPECT_GT(after[0].at("cycle").get<std::int64_t>(), cycle);
}

TEST(MonitorOverDds, the_publisher_ends_when_its_owner_dies_without_a_word) {
  int channel[2];
  ASSERT_EQ(pipe(channel), 0);
  own_domain();  // this process's, before there are two
  const pid_t owner = fork();
  ASSERT_GE(owner, 0);
  if (owner == 0) {
    auto writer = SnapshotWriter::create(bench_machine());
    ChildOptions options;
    options.program = PUBLISH_TOOL;
    options.arguments = {"--domain", std::to_string(own_domain())};
    PublishChild child(writer->fd(), options);
    child.poll(Time{0});
    const pid_t pid = child.pid();
    if (write(channel[1], &pid, sizeof pid) != sizeof pid) _exit(1);
    for (;;) {
      writer->push(running_snapshot().snapshot);
      usleep(1000);
    }
  }
  pid_t publisher = 0;
  ASSERT_EQ(read(channel[0], &publisher, sizeof publisher), static_cast<ssize_t>(sizeof publisher));
  ASSERT_GT(publisher, 0);
  heard(listening(2));  // it lives and tells
  kill(owner, SIGKILL);
  waitpid(owner, nullptr, 0);
  bool gone = false;
  for (int i = 0; i < 3000 && !gone; ++i) {
    // Nobody may be there to reap it: a zombie counts as ended.
    std::ifstream stat("/proc/" + std::to_string(publisher) + "/stat");
    std::string number, name, state;
    gone = !(stat >> number >> name >> state) || state == "Z";
    if (!gone) std::this_thread::sleep_for(milliseconds(10));
  }
  EXPECT_TRUE(gone);
  if (!gone) kill(publisher, SIGKILL);
}

// R94: a slow or dead subscriber.
TEST(MonitorOverDds, a_subscriber_that_never_reads_holds_nobody_up) {
  Owner owner;
  int channel[2];
  ASSERT_EQ(pipe(channel), 0);
  const auto domain = std::to_string(own_domain());
  const pid_t greedy = fork();
  ASSERT_GE(greedy, 0);
  if (greedy == 0) {
    dup2(channel[1], STDOUT_FILENO);
    execl(PUBLISH_TOOL, "publish_tool", "hold", "--domain", domain.c_str(), nullptr);
    _exit(1);
  }
  close(channel[1]);
  char matched = 0;
  EXPECT_EQ(read(channel[0], &matched, 1), 1) << "the greedy subscriber was not matched";
  close(channel[0]);
  const auto lines = heard(listening(60));
  ASSERT_EQ(lines.size(), 60u);
  // Not one sample waited for the other reader: a wait would be 100 ms of cycles.
  const auto first = lines.front().at("cycle").get<std::int64_t>(), last = lines.back().at("cycle").get<std::int64_t>();
  EXPECT_LT(last - first, 60 * 100);
  kill(greedy, SIGKILL);
  waitpid(greedy, nullptr, 0);
}

TEST(MonitorOverDds, says_when_no_machine_is_heard) {
  auto options = listening(1);
  options.network.domain = own_domain() + 1;
  options.for_s = 0.5;
  options.silence_s = 0.2;
  std::vector<std::string> notices;
  options.notice = [&](const std::string& text) { notices.push_back(text); };
  std::ostringstream out;
  const std::atomic<bool> stop{false};
  const auto done = monitor(options, out, stop);
  ASSERT_FALSE(done);
  EXPECT_EQ(done.error().fault, Fault::NoMachineHeard);
  ASSERT_EQ(notices.size(), 1u);
  EXPECT_NE(notices[0].find("no machine heard"), std::string::npos);
  EXPECT_TRUE(out.str().empty());
}

TEST(MonitorOverDds, joint_states_are_there_for_ros_tools) {
  Owner owner;
  auto participant = dds::Participant::open({.domain = own_domain(), .interface = "", .peers = {}});
  ASSERT_TRUE(participant);
  auto reader = dds::reader(*participant, sensor_msgs_msg_dds__JointState__desc, kJointTopic,
                            dds::Qos().reliable().keep_last(10));
  ASSERT_TRUE(reader);
  int taken = 0;
  for (int i = 0; i < 3000 && taken == 0; ++i) {
    taken += dds::take_all<sensor_msgs_msg_dds__JointState_>(*reader, [&](const auto& s, const auto&) {
      ASSERT_EQ(s.name._length, 2u);
      EXPECT_STREQ(s.name._buffer[1], "C");
      EXPECT_DOUBLE_EQ(s.position._buffer[0], 0.12325);
    });
    std::this_thread::sleep_for(milliseconds(10));
  }
  EXPECT_GT(taken, 0);
  // The writer announces the hash of its type, by which ROS 2 (Iron and later) knows it.
  dds_instance_handle_t writers[4];
  const auto matched = dds_get_matched_publications(reader->id(), writers, 4);
  ASSERT_GE(matched, 1);
  auto* endpoint = dds_get_matched_publication_data(reader->id(), writers[0]);
  ASSERT_NE(endpoint, nullptr);
  void* data = nullptr;
  std::size_t size = 0;
  EXPECT_TRUE(dds_qget_userdata(endpoint->qos, &data, &size));
  EXPECT_EQ(std::string(static_cast<char*>(data), size), kJointStateHash);
  EXPECT_STREQ(endpoint->type_name, "sensor_msgs::msg::dds_::JointState_");
  dds_free(data);
  dds_builtintopic_free_endpoint(endpoint);
}

TEST(MonitorOverDds, nonsense_is_refused_before_anything_is_opened) {
  EXPECT_EQ(dds::Participant::open({.domain = 500, .interface = "", .peers = {}}).error().fault, Fault::Usage);
  EXPECT_EQ(dds::Participant::open({.domain = 0, .interface = "eth0\"/><x", .peers = {}}).error().fault, Fault::Usage);
}

}  // namespace
}  // namespace gantry::monitor
