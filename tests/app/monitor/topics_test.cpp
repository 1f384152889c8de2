#include "app/monitor/topics.hpp"

#include <gtest/gtest.h>

#include "tests/app/monitor/samples.hpp"

namespace gantry::monitor {
namespace {

TEST(Topics, the_state_tells_the_snapshot_with_names) {
  StateSample s;
  s.set(bench_machine(), 99, running_snapshot());
  const auto& t = s.sample;
  EXPECT_STREQ(t.machine, "bench");
  EXPECT_EQ(t.session, 99u);
  EXPECT_EQ(t.cycle, 4711);
  EXPECT_STREQ(t.state, "running");
  EXPECT_EQ(t.block, 7u);
  EXPECT_EQ(t.feature, 3);
  ASSERT_EQ(t.axes._length, 2u);
  EXPECT_STREQ(t.axes._buffer[1].name, "C");
  EXPECT_DOUBLE_EQ(t.axes._buffer[0].following, 0.25);
  EXPECT_TRUE(t.axes._buffer[0].following_known);
  EXPECT_FALSE(t.axes._buffer[1].following_known) << "an open-loop axis has no following error";
  EXPECT_TRUE(t.axes._buffer[1].enabled);
  EXPECT_FALSE(t.axes._buffer[1].referenced);
  ASSERT_EQ(t.outputs_on._length, 2u);
  EXPECT_STREQ(t.outputs_on._buffer[0], "valve");
  EXPECT_STREQ(t.outputs_on._buffer[1], "stack_green");
  ASSERT_EQ(t.inputs_on._length, 2u);
  EXPECT_STREQ(t.inputs_on._buffer[0], "air_ok");
  EXPECT_STREQ(t.inputs_on._buffer[1], "tray_full");
  EXPECT_EQ(t.latched_fault, 0);
}

TEST(Topics, travel_is_no_feature_and_a_latch_has_its_text) {
  auto shared = running_snapshot();
  shared.snapshot.feature = motion::kTravel;
  shared.snapshot.latched = Fault::FollowingError;
  StateSample s;
  s.set(bench_machine(), 1, shared);
  EXPECT_EQ(s.sample.feature, -1);
  EXPECT_EQ(s.sample.latched_fault, 207);
  EXPECT_EQ(std::string(s.sample.latched_text), info(Fault::FollowingError).text);
}

TEST(Topics, joint_states_are_in_metres_and_radians_as_ros_has_them) {
  JointSample j;
  j.set(bench_machine(), running_snapshot());
  const auto& s = j.sample;
  ASSERT_EQ(s.position._length, 2u);
  EXPECT_DOUBLE_EQ(s.position._buffer[0], 0.12325);
  EXPECT_DOUBLE_EQ(s.position._buffer[1], 1.5);
  EXPECT_STREQ(s.name._buffer[0], "X");
  EXPECT_EQ(s.header.stamp.sec, 1'700'000'000);
  EXPECT_EQ(s.header.stamp.nanosec, 123'456'789u);
  EXPECT_STREQ(s.header.frame_id, "");
  EXPECT_EQ(s.velocity._length, 0u);
}

TEST(Topics, the_ros_type_has_the_name_that_ros_looks_for) {
  EXPECT_STREQ(sensor_msgs_msg_dds__JointState__desc.m_typename, "sensor_msgs::msg::dds_::JointState_");
}

TEST(Topics, an_event_carries_code_text_and_remedy_and_the_owners_words_come_first) {
  SharedEvent shared;
  shared.event.kind = cycle::EventKind::Fault;
  shared.event.fault = Fault::DriveFault;
  shared.event.axis = AxisId{1};
  shared.event.detail = 0x3210;
  auto e = event_sample(bench_machine(), 5, 17, shared);
  EXPECT_STREQ(e.kind, "fault");
  EXPECT_STREQ(e.code, "G200");
  EXPECT_STREQ(e.fault_name, "DriveFault");
  EXPECT_STREQ(e.severity, "error");
  EXPECT_STREQ(e.axis, "C");
  EXPECT_EQ(e.seq, 17u);
  EXPECT_EQ(std::string(e.text), info(Fault::DriveFault).text);
  EXPECT_EQ(std::string(e.remedy), info(Fault::DriveFault).remedy);
  shared.text = "DC bus overvoltage (3210h)";
  e = event_sample(bench_machine(), 5, 17, shared);
  EXPECT_STREQ(e.text, "DC bus overvoltage (3210h)");
}

TEST(Topics, actions_and_parts_are_kinds_of_their_own) {
  SharedEvent shared;
  shared.text = "hold";
  shared.told = Told::Action;
  EXPECT_STREQ(event_sample(bench_machine(), 5, 17, shared).kind, "action");
  EXPECT_STREQ(event_sample(bench_machine(), 5, 17, shared).text, "hold");
  EXPECT_STREQ(event_sample(bench_machine(), 5, 17, shared).code, "");
  shared.told = Told::Part;
  EXPECT_STREQ(event_sample(bench_machine(), 5, 17, shared).kind, "part");
  EXPECT_EQ(event_sample(bench_machine(), 5, 17, shared).count, 1u);
  shared.count = 33;
  EXPECT_EQ(event_sample(bench_machine(), 5, 17, shared).count, 33u);
}

TEST(Topics, an_alarm_says_what_since_when_and_what_to_do) {
  SharedAlarm shared{Fault::DriveFault, 1'700'000'000'000'000'000, std::string_view("axis C"),
                     std::string_view("DC bus overvoltage")};
  const auto a = alarm_sample(bench_machine(), 5, shared);
  EXPECT_STREQ(a.machine, "bench");
  EXPECT_STREQ(a.code, "G200");
  EXPECT_EQ(a.session, 5u);
  EXPECT_TRUE(a.active);
  EXPECT_STREQ(a.severity, "error");
  EXPECT_STREQ(a.where, "axis C");
  EXPECT_STREQ(a.text, "DC bus overvoltage");
  EXPECT_EQ(std::string(a.remedy), info(Fault::DriveFault).remedy);
  EXPECT_EQ(a.since_ns, 1'700'000'000'000'000'000);
}

TEST(Topics, what_is_left_of_a_job_is_known_or_said_to_be_unknown) {
  SharedJob job;
  EXPECT_FALSE(job_sample(bench_machine(), 1, 0, job).remaining_known);
  EXPECT_DOUBLE_EQ(job_sample(bench_machine(), 1, 0, job).remaining_s, 0);
  job.remaining_s = 12.5;
  EXPECT_TRUE(job_sample(bench_machine(), 1, 0, job).remaining_known);
  EXPECT_DOUBLE_EQ(job_sample(bench_machine(), 1, 0, job).remaining_s, 12.5);
}

TEST(Topics, every_remedy_and_text_of_the_catalogue_fits) {
  for (const auto& row : catalogue()) {
    EXPECT_LT(row.text.size(), sizeof gantry_msg_MachineState::latched_text) << row.name;
    EXPECT_LT(row.text.size(), sizeof gantry_msg_Event::text) << row.name;
    EXPECT_LT(row.remedy.size(), sizeof gantry_msg_Event::remedy) << row.name;
    EXPECT_LT(row.name.size(), sizeof gantry_msg_Event::fault_name) << row.name;
    EXPECT_LT(row.remedy.size(), sizeof gantry_msg_Alarm::remedy) << row.name;
    EXPECT_LT(row.text.size(), sizeof gantry_msg_Alarm::text) << row.name;
  }
}

}  // namespace
}  // namespace gantry::monitor
