#include "app/monitor/heard.hpp"

#include <gtest/gtest.h>

#include "app/monitor/topics.hpp"
#include "tests/app/monitor/samples.hpp"

namespace gantry::monitor {
namespace {

struct HeardTest : ::testing::Test {
  Heard heard;
  StateSample s;
  void hear_state(std::uint64_t session, std::uint64_t seq, double age_s = 0) {
    s.set(bench_machine(), session, running_snapshot());
    s.sample.seq = seq;
    s.sample.age_s = age_s;
    heard.state(s.sample);
  }
  bool hear_event(std::uint64_t session, std::uint64_t number) {
    SharedEvent e;
    e.event.kind = cycle::EventKind::Fault;
    e.event.fault = Fault::DoorOpen;
    return heard.event(event_sample(bench_machine(), session, number, e));
  }
};

TEST_F(HeardTest, becomes_json_with_na_where_nothing_is_measured) {
  hear_state(0xabc, 1);
  const nlohmann::json j = heard.to_json();
  EXPECT_EQ(j.at("machine"), "bench");
  EXPECT_EQ(j.at("session"), "0000000000000abc");
  EXPECT_EQ(j.at("state"), "running");
  EXPECT_EQ(j.at("feature"), 3);
  EXPECT_DOUBLE_EQ(j.at("axes")[0].at("following"), 0.25);
  EXPECT_EQ(j.at("axes")[1].at("following"), "n/a");
  EXPECT_EQ(j.at("axes")[1].at("unit"), "rad");
  EXPECT_EQ(j.at("outputs_on"), nlohmann::json({"valve", "stack_green"}));
  EXPECT_TRUE(j.at("latched").is_null());
  EXPECT_TRUE(j.at("job").is_null());
  EXPECT_FALSE(j.at("stale").get<bool>());
}

TEST_F(HeardTest, counts_missed_samples_but_not_a_publisher_that_starts_anew) {
  hear_state(1, 10);
  hear_state(1, 11);
  hear_state(1, 15);
  EXPECT_EQ(heard.missed(), 3u);
  hear_state(1, 1);
  hear_state(1, 2);
  EXPECT_EQ(heard.missed(), 3u);
  EXPECT_EQ(heard.restarts(), 0);
  hear_state(2, 7);
  EXPECT_EQ(heard.missed(), 3u);
  EXPECT_EQ(heard.restarts(), 1);
}

// R91: an old sample is played again.
TEST_F(HeardTest, samples_that_are_played_again_are_counted_and_not_shown) {
  s.set(bench_machine(), 1, running_snapshot());
  s.sample.seq = 10, s.sample.cycle = 5000;
  EXPECT_TRUE(heard.state(s.sample));
  s.sample.seq = 9, s.sample.cycle = 4990;
  EXPECT_FALSE(heard.state(s.sample)) << "older than what is known";
  s.sample.session = 2, s.sample.seq = 1, s.sample.cycle = 3;
  EXPECT_TRUE(heard.state(s.sample)) << "the owner was started anew";
  s.sample.session = 1, s.sample.seq = 11, s.sample.cycle = 5010;
  EXPECT_FALSE(heard.state(s.sample)) << "the session before has ended";
  EXPECT_FALSE(hear_event(1, 50));
  EXPECT_EQ(heard.replayed(), 3u);
  EXPECT_EQ(heard.state().session, 2u);
  EXPECT_EQ(heard.state().cycle, 3);
  EXPECT_EQ(heard.restarts(), 1);
  EXPECT_NE(live_view(heard, 0, false).find("3 old samples"), std::string::npos);
}

TEST_F(HeardTest, events_are_told_once_even_when_a_new_publisher_repeats_them) {
  EXPECT_TRUE(hear_event(1, 0));
  EXPECT_TRUE(hear_event(1, 1));
  hear_state(1, 1);
  EXPECT_EQ(heard.to_json().at("events").size(), 2u);
  EXPECT_FALSE(hear_event(1, 0));
  EXPECT_FALSE(hear_event(1, 1));
  EXPECT_TRUE(hear_event(1, 4));
  const nlohmann::json j = heard.to_json();
  ASSERT_EQ(j.at("events").size(), 1u);
  EXPECT_EQ(j.at("events")[0].at("fault").at("code"), "G704");
  EXPECT_EQ(j.at("events_missed"), 2);
  EXPECT_TRUE(heard.to_json().at("events").empty());
  EXPECT_TRUE(hear_event(2, 0)) << "another session counts anew";
}

TEST_F(HeardTest, a_loop_that_stands_still_makes_the_state_stale) {
  hear_state(1, 1, 2.5);
  EXPECT_TRUE(heard.to_json().at("stale").get<bool>());
  EXPECT_NE(live_view(heard, 0.02, false).find("STALE: nothing new for 2.5 s"), std::string::npos);
  hear_state(1, 2, 0.001);
  EXPECT_EQ(live_view(heard, 0.02, false).find("STALE"), std::string::npos);
  EXPECT_NE(live_view(heard, 3.0, false).find("STALE"), std::string::npos);
}

TEST_F(HeardTest, the_live_view_shows_axes_latch_job_and_events) {
  auto shared = running_snapshot();
  shared.snapshot.latched = Fault::DoorOpen;
  s.set(bench_machine(), 1, shared);
  heard.state(s.sample);
  hear_event(1, 0);
  SharedJob job;
  job.job = "demo-board", job.state = "running", job.features_done = 3, job.features_total = 30;
  heard.job(job_sample(bench_machine(), 1, 0, job));
  const auto view = live_view(heard, 0, false);
  for (const char* part :
       {"bench", "running", "block 7", "123.5000", "0.2500", "n/a", "85.9437", "deg", "not referenced",
        "valve stack_green", "G704", "the door is open", "demo-board", "3 of 30 features"})
    EXPECT_NE(view.find(part), std::string::npos) << part << " in\n" << view;
}

TEST_F(HeardTest, names_from_another_process_cannot_steer_the_terminal) {
  auto info = bench_machine();
  info.name = "evil\x1b[2J";
  info.axis[0].name = "X\x1b]0;t\x07";
  s.set(info, 1, running_snapshot());
  heard.state(s.sample);
  SharedEvent e;
  e.text = "\x1b[31mred\r\n";
  heard.event(event_sample(info, 1, 0, e));
  SharedJob job;
  job.job = "\x1b[5m", job.message = "\x07";
  heard.job(job_sample(info, 1, 0, job));
  const auto view = live_view(heard, 0, false);
  for (const char c : view) EXPECT_TRUE(c == '\n' || static_cast<unsigned char>(c) >= 0x20) << view;
}

}  // namespace
}  // namespace gantry::monitor
