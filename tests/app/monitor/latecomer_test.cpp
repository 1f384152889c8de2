// What a reader knows that comes late, or that nobody wrote to for long: alarms, history, and a job's clock. The judge
// is a DDS reader of its own, or what the monitor writes; the machine is in another process.
#include <algorithm>
#include <chrono>
#include <cstring>
#include <dds/dds.h>
#include <gtest/gtest.h>

#include "app/monitor/topics.hpp"
#include "tests/app/monitor/over_dds.hpp"

namespace gantry::monitor {
namespace {

struct Listener {
  dds::Participant participant =
      std::move(*dds::Participant::open({.domain = own_domain(), .interface = "", .peers = {}}));
  dds::Entity to(const dds_topic_descriptor_t& type, const char* topic, int depth) {
    return std::move(
        *dds::reader(participant, type, topic, dds::Qos().reliable().keep_last(depth).for_latecomers(depth)));
  }
};

template <class Condition>
bool in_time(Condition condition) {
  for (int i = 0; i < 3000 && !condition(); ++i) std::this_thread::sleep_for(milliseconds(10));
  return condition();
}

TEST(Latecomer, a_thousand_notes_displace_no_alarm) {
  Owner owner;
  owner.door_open = true;
  owner.notes = 1000;
  ASSERT_TRUE(in_time([&] { return owner.notes == 0 && owner.starts > 0; }));
  std::this_thread::sleep_for(milliseconds(500));
  const auto lines = heard(listening(3));
  ASSERT_EQ(lines.size(), 3u);
  const auto& first = lines.front();
  EXPECT_TRUE(first.at("complete").get<bool>());
  for (const auto& e : first.at("events")) EXPECT_NE(e.at("text"), "somebody opened the door") << "long displaced";
  ASSERT_EQ(first.at("alarms").size(), 1u) << first;
  const auto& alarm = first.at("alarms")[0];
  EXPECT_EQ(alarm.at("code"), "G704");
  EXPECT_EQ(alarm.at("text"), "the door of the pretended machine is open");
  EXPECT_EQ(alarm.at("where"), "station 9 'io'");
  EXPECT_NE(alarm.at("remedy").get<std::string>().find("close the door"), std::string::npos);
  const double since_s = static_cast<double>(alarm.at("since_ns").get<std::int64_t>()) * 1e-9;
  const auto now = std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count();
  EXPECT_GT(now, since_s);
  EXPECT_LT(now - since_s, 3600);
}

TEST(Latecomer, an_alarm_that_is_gone_is_gone_for_who_was_there_and_for_who_comes_later) {
  Owner owner;
  owner.door_open = true;
  Listener listener;
  const auto reader = listener.to(gantry_msg_Alarm_desc, kAlarmTopic, 16);
  std::vector<bool> active;
  bool disposed = false;
  const auto look = [&] {
    dds::take_changes<gantry_msg_Alarm>(reader, [&](const gantry_msg_Alarm& a, const dds_sample_info_t& info) {
      EXPECT_STREQ(a.machine, "bench");
      EXPECT_STREQ(a.code, "G704");
      if (info.valid_data) active.push_back(a.active);
      disposed = info.instance_state == DDS_IST_NOT_ALIVE_DISPOSED;
    });
  };
  EXPECT_TRUE(in_time([&] { return look(), !active.empty(); }));
  EXPECT_FALSE(disposed);
  owner.door_open = false;
  EXPECT_TRUE(in_time([&] { return look(), disposed; }));
  EXPECT_EQ(active, (std::vector<bool>{true, false})) << "written when it came and when it went";
  const auto lines = heard(listening(2));
  ASSERT_EQ(lines.size(), 2u);
  EXPECT_TRUE(lines[0].at("complete").get<bool>());
  EXPECT_TRUE(lines[0].at("alarms").empty());
}

TEST(Latecomer, the_alarms_of_an_owner_that_has_ended_have_no_writer) {
  std::optional<Owner> owner(std::in_place);
  owner->door_open = true;
  Listener listener;
  const auto reader = listener.to(gantry_msg_Alarm_desc, kAlarmTopic, 16);
  std::optional<dds_instance_state_t> last;
  const auto look = [&] {
    dds::take_changes<gantry_msg_Alarm>(reader, [&](const auto&, const auto& info) { last = info.instance_state; });
    return last;
  };
  EXPECT_TRUE(in_time([&] { return look() == DDS_IST_ALIVE; }));
  owner.reset();
  EXPECT_TRUE(in_time([&] { return look() == DDS_IST_NOT_ALIVE_NO_WRITERS; }));
}

TEST(Latecomer, an_alarm_outlives_its_publisher) {
  Owner owner;
  owner.door_open = true;
  heard(listening(2));
  owner.kill_children = 1;
  ASSERT_TRUE(in_time([&] { return owner.kill_children == 0 && owner.starts > 1; }));
  const auto lines = heard(listening(100));
  ASSERT_EQ(lines.size(), 100u);
  EXPECT_EQ(lines.back().at("alarms").size(), 1u);
}

TEST(Latecomer, the_first_line_has_the_whole_history) {
  Owner owner;
  owner.notes = 100;
  ASSERT_TRUE(in_time([&] { return owner.notes == 0 && owner.starts > 0; }));
  std::this_thread::sleep_for(milliseconds(500));
  for (int round = 0; round < 3; ++round) {
    const auto lines = heard(listening(1));
    ASSERT_EQ(lines.size(), 1u);
    EXPECT_TRUE(lines[0].at("complete").get<bool>());
    ASSERT_EQ(lines[0].at("events").size(), 101u);
    for (std::size_t i = 0; i <= 100; ++i) EXPECT_EQ(lines[0].at("events")[i].at("seq"), i);
    EXPECT_FALSE(lines[0].at("job").is_null());
  }
}

/// A peer that writes what it likes.
struct Peer {
  Listener listener;
  dds::Entity to(const dds_topic_descriptor_t& type, const char* topic) {
    return std::move(
        *dds::writer(listener.participant, type, topic, dds::Qos().reliable().keep_last(16).for_latecomers(16)));
  }
};

TEST(Latecomer, a_history_that_does_not_come_is_said_to_be_incomplete) {
  Peer peer;
  const auto states = peer.to(gantry_msg_MachineState_desc, kStateTopic);
  gantry_msg_MachineState state{};
  std::strcpy(state.machine, "liar");
  state.session = 1, state.events_next = 5;
  std::atomic<bool> quit{false};
  std::thread writes([&] {
    while (!quit) {
      ++state.seq, ++state.cycle;
      dds_write(states.id(), &state);
      std::this_thread::sleep_for(milliseconds(10));
    }
  });
  const auto lines = heard(listening(2));
  quit = true;
  writes.join();
  ASSERT_EQ(lines.size(), 2u);
  EXPECT_FALSE(lines[0].at("complete").get<bool>());
  EXPECT_EQ(lines[0].at("machine"), "liar");
}

TEST(Latecomer, a_job_of_which_nothing_changes_still_has_its_clock_twice_a_second) {
  Owner owner;
  owner.job_stands = true;
  Listener listener;
  const auto reader = listener.to(gantry_msg_JobStatus_desc, kJobTopic, 16);
  std::vector<double> clock_s;
  EXPECT_TRUE(in_time([&] {
    dds::take_all<gantry_msg_JobStatus>(
        reader, [&](const gantry_msg_JobStatus& j, const auto&) { clock_s.push_back(j.elapsed_s); });
    return clock_s.size() >= 16;
  }));
  std::vector<double> steps_s;
  for (std::size_t i = 1; i < clock_s.size(); ++i) steps_s.push_back(clock_s[i] - clock_s[i - 1]);
  std::sort(steps_s.begin(), steps_s.end());
  ASSERT_GE(steps_s.size(), 15u);
  EXPECT_GT(steps_s.front(), 0) << "it never stands";
  const double median_s = steps_s[steps_s.size() / 2];
  EXPECT_LE(median_s, 0.551) << "and is at most 50 ms old when it is written";
  EXPECT_GE(median_s, 0.4);
}

}  // namespace
}  // namespace gantry::monitor
