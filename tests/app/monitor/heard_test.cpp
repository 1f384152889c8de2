#include "app/monitor/heard.hpp"

#include <algorithm>
#include <gtest/gtest.h>
#include <iterator>

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

TEST_F(HeardTest, the_live_view_says_that_a_machine_that_is_ready_between_two_blocks_is_not_free) {
  auto shared = running_snapshot();
  shared.snapshot.state = cycle::State::Ready;
  s.set(bench_machine(), 1, shared);
  heard.state(s.sample);
  for (const auto& [word, going] :
       {std::pair{"running", true}, {"held", true}, {"stopped", true}, {"done", false}, {"failed", false}}) {
    SharedJob job;
    job.job = "demo-board", job.state = std::string_view(word);
    heard.job(job_sample(bench_machine(), 1, 0, job));
    EXPECT_EQ(live_view(heard, 0, false).find("ready, in a job") != std::string::npos, going) << word;
  }
}

TEST_F(HeardTest, the_live_view_shows_alarms_with_remedy_and_age_and_what_is_left_of_the_job) {
  hear_state(1, 1);
  SharedAlarm alarm{
      Fault::DoorOpen, running_snapshot().wall_ns - 12'000'000'000, {}, std::string_view("the door is open")};
  heard.alarm(alarm_sample(bench_machine(), 1, alarm), true);
  SharedJob job;
  job.job = "demo-board", job.state = "held", job.elapsed_s = 7, job.remaining_s = 31.8;
  job.message = "on hold, on 'bead 7'";
  heard.job(job_sample(bench_machine(), 1, 0, job));
  const auto view = live_view(heard, 0, false);
  for (const char* part : {"alarm    G704 the door is open, for 12 s", "remedy: close the door", "demo-board held",
                           "7.0 s, about 32 s left", "on hold, on 'bead 7'"})
    EXPECT_NE(view.find(part), std::string::npos) << part << " in\n" << view;
  heard.alarm(alarm_sample(bench_machine(), 1, alarm), false);
  EXPECT_EQ(live_view(heard, 0, false).find("alarm"), std::string::npos);
}

TEST_F(HeardTest, history_is_complete_when_all_has_come_that_the_state_speaks_of) {
  const auto complete = [&](std::uint64_t events_next, std::uint32_t alarms, bool job) {
    hear_state(1, 1);
    s.sample.events_next = events_next, s.sample.alarms_active = alarms, s.sample.job_known = job;
    heard.state(s.sample);
    return heard.to_json().at("complete").get<bool>();
  };
  hear_event(1, 3);
  EXPECT_FALSE(heard.complete()) << "no state yet";
  s.set(bench_machine(), 1, running_snapshot());
  s.sample.events_next = 6, s.sample.alarms_active = 1, s.sample.job_known = true;
  heard.state(s.sample);
  EXPECT_FALSE(heard.complete());
  hear_event(1, 4), hear_event(1, 5);
  heard.state(s.sample);
  EXPECT_FALSE(heard.complete());
  SharedAlarm alarm;
  alarm.fault = Fault::DoorOpen;
  heard.alarm(alarm_sample(bench_machine(), 1, alarm), true);
  heard.state(s.sample);
  EXPECT_FALSE(heard.complete());
  heard.job(job_sample(bench_machine(), 1, 0, {}));
  heard.state(s.sample);
  EXPECT_TRUE(heard.complete());
  EXPECT_TRUE(complete(9, 0, true)) << "once it was, what is new is no history";
  s.set(bench_machine(), 2, running_snapshot());
  s.sample.events_next = 1;
  heard.state(s.sample);
  EXPECT_FALSE(heard.complete()) << "another session has a history of its own";
  EXPECT_TRUE(heard.alarms().empty());
  EXPECT_FALSE(heard.has_job());
}

// Unicode 15, 23.1 and UAX #9: control codes of both sets, and what turns the direction of writing.
constexpr const char* kSteering[] = {"\x1b[2J",
                                     "\x07",
                                     "\r",
                                     "\x7f",
                                     "\xc2\x85",
                                     "\xc2\x9b"
                                     "31m",
                                     "\xd8\x9c",
                                     "\xe2\x80\x8e",
                                     "\xe2\x80\x8f",
                                     "\xe2\x80\xa8",
                                     "\xe2\x80\xae",
                                     "\xe2\x81\xa6",
                                     "\xe2\x81\xa9",
                                     "\x9b",
                                     "\xff"};

bool steers(std::string_view text) {
  for (std::size_t i = 0; i < text.size(); ++i) {
    const auto at = [&](std::size_t n) { return i + n < text.size() ? static_cast<unsigned char>(text[i + n]) : 0u; };
    const bool c0 = at(0) < 0x20 || at(0) == 0x7F, c1 = at(0) == 0xC2 && at(1) >= 0x80 && at(1) <= 0x9F;
    const bool turns =
        (at(0) == 0xD8 && at(1) == 0x9C) ||
        (at(0) == 0xE2 && at(1) == 0x80 && (at(2) == 0x8E || at(2) == 0x8F || (at(2) >= 0xA8 && at(2) <= 0xAE))) ||
        (at(0) == 0xE2 && at(1) == 0x81 && at(2) >= 0xA6 && at(2) <= 0xA9);
    if (c0 || c1 || turns || at(0) == 0xFF) return true;
  }
  return false;
}

/// Every text in it, decoded, and every key.
void expect_clean(const nlohmann::json& j) {
  if (j.is_string()) {
    EXPECT_FALSE(steers(j.get<std::string>())) << j;
  }
  if (j.is_object())
    for (const auto& [key, value] : j.items()) expect_clean(value);
  if (j.is_array())
    for (const auto& value : j) expect_clean(value);
}

template <std::size_t N>
void put(char (&out)[N], std::string_view text) {
  const Text<N> bounded(text);
  std::copy(std::begin(bounded.chars), std::end(bounded.chars), out);
}

TEST_F(HeardTest, text_from_another_process_steers_neither_terminal_nor_reader) {
  for (const char* bad : kSteering) {
    ASSERT_TRUE(steers(bad) || std::string_view(bad) == "\x9b");
    Heard hears;
    auto info = bench_machine();
    info.name = std::string("evil") + bad;
    info.axis[0].name = std::string("X") + bad;
    s.set(info, 1, running_snapshot());
    put(s.sample.state, bad), put(s.sample.latched_text, bad);
    s.sample.latched_fault = 704;
    put(s.sample.outputs_on._buffer[0], bad), put(s.sample.inputs_on._buffer[0], bad);
    hears.state(s.sample);
    auto e = event_sample(info, 1, 0, {});
    put(e.kind, bad), put(e.code, bad), put(e.fault_name, bad), put(e.severity, bad), put(e.axis, bad);
    put(e.text, std::string(bad) + "red"), put(e.remedy, bad);
    e.fault = 704;
    hears.event(e);
    auto a = alarm_sample(info, 1, {});
    put(a.code, bad), put(a.fault_name, bad), put(a.severity, bad), put(a.where, bad), put(a.text, bad);
    put(a.remedy, bad);
    hears.alarm(a, true);
    auto j = job_sample(info, 1, 0, {});
    put(j.job, bad), put(j.recipe, bad), put(j.state, bad), put(j.message, bad);
    hears.job(j);
    std::string view = live_view(hears, 0, false);
    std::erase(view, '\n');
    EXPECT_FALSE(steers(view)) << view;
    const auto json = hears.to_json();
    EXPECT_EQ(json.at("events").size(), 1u);
    EXPECT_EQ(json.at("alarms").size(), 1u);
    expect_clean(json);
    const std::string line = json.dump();  // throws where something is no UTF-8
    EXPECT_EQ(line.find("\uFFFD") == std::string::npos, std::string_view(bad) == "\r") << "that one is a blank";
  }
}

}  // namespace
}  // namespace gantry::monitor
