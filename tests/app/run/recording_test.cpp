// What those who watch a job are told while it lasts, read from the memory that the publisher reads, cycle by cycle.
#include "app/run/recording.hpp"

#include <gtest/gtest.h>

#include "tests/app/record/snapshots.hpp"

namespace gantry::run {
namespace {

using cycle::State;

constexpr std::int64_t kCycle_ns = 1'000'000;

class RecordingTest : public ::testing::Test {
 protected:
  void pass(State state, double seconds, std::uint32_t block = 0, bool holds_next = false) {
    snapshot.state = state;
    snapshot.block = block;
    for (int i = 0; i < static_cast<int>(seconds * 1000); ++i) {
      snapshot.time_ns += kCycle_ns;
      recording.add(snapshot, holds_next, "dispensing", left_s);
    }
  }
  monitor::SharedJob seen() {
    monitor::SharedJob job;
    EXPECT_TRUE(reader->job(job));
    return job;
  }

  Result<monitor::SnapshotWriter> writer = monitor::SnapshotWriter::create({});
  Result<monitor::SnapshotReader> reader = monitor::SnapshotReader::open(writer->fd());
  record::JobResult result = [] {
    record::JobResult r;
    r.predicted_s = 100;
    return r;
  }();
  std::optional<double> left_s = 100;
  cycle::Snapshot snapshot = [] {
    cycle::Snapshot s;
    s.time_ns = 7'000 * kCycle_ns;
    return s;
  }();
  recipes::Recipe recipe{};
  Recording recording{record::three_axes(), recipe, result, snapshot.time_ns, "", &*writer};
};

TEST_F(RecordingTest, one_clock_goes_on_whatever_the_job_does) {
  recording.begin(left_s);
  EXPECT_EQ(seen().state.view(), "running");
  EXPECT_DOUBLE_EQ(seen().elapsed_s, 0);
  const struct {
    State state;
    std::uint32_t block;
    bool holds_next;
    const char* word;
  } phases[] = {{State::Enabling, 0, false, "running"}, {State::Homing, 0, false, "running"},
                {State::Running, 1, false, "running"},  {State::Holding, 1, false, "running"},
                {State::Held, 1, false, "held"},        {State::Running, 2, true, "held"},
                {State::Ready, 0, true, "held"},        {State::Ready, 0, false, "running"}};
  double elapsed_s = 0;
  for (const auto& phase : phases)
    for (int i = 0; i < 50; ++i) {
      pass(phase.state, 0.1, phase.block, phase.holds_next);
      EXPECT_EQ(seen().state.view(), phase.word) << name(phase.state);
      EXPECT_GT(seen().elapsed_s, elapsed_s);
      elapsed_s = seen().elapsed_s;
      EXPECT_NEAR(elapsed_s, recording.elapsed_s(), 0.0501);
    }
  EXPECT_NEAR(elapsed_s, 8 * 50 * 0.1, 0.06);
}

TEST_F(RecordingTest, a_latched_fault_has_stopped_the_job_until_it_is_reset) {
  pass(State::Running, 1, 1);
  snapshot.latched = Fault::DoorOpen;
  pass(State::Stopping, 0.002);
  EXPECT_EQ(seen().state.view(), "stopped") << "at once";
  pass(State::Stopped, 1);
  EXPECT_EQ(seen().state.view(), "stopped");
  snapshot.latched = Fault::None;
  pass(State::Ready, 0.002, 0, true);
  EXPECT_EQ(seen().state.view(), "held") << "it waits for its resume";
}

TEST_F(RecordingTest, what_is_left_is_told_at_the_override_of_now) {
  recording.begin(left_s);
  EXPECT_DOUBLE_EQ(seen().predicted_s, 100);
  EXPECT_DOUBLE_EQ(seen().remaining_s, 100) << "from the beginning";
  pass(State::Homing, 1);
  EXPECT_DOUBLE_EQ(seen().remaining_s, 100);
  left_s = 80;
  pass(State::Running, 1, 1);
  EXPECT_DOUBLE_EQ(seen().remaining_s, 80);
  snapshot.override_factor = 0.5;
  pass(State::Running, 1, 1);
  EXPECT_DOUBLE_EQ(seen().remaining_s, 160) << "at half the speed";
  snapshot.override_factor = 1.5;
  pass(State::Running, 1, 1);
  EXPECT_DOUBLE_EQ(seen().remaining_s, 80) << "nothing but a line that a set speed holds is faster";
  snapshot.override_factor = 0;
  pass(State::Running, 1, 1);
  EXPECT_LT(seen().remaining_s, 0) << "nobody knows";
}

TEST_F(RecordingTest, nobody_knows_what_is_left_of_a_job_that_was_not_proved) {
  Recording other(record::three_axes(), recipe, result, 0, "", &*writer);
  other.begin({});
  EXPECT_LT(seen().remaining_s, 0);
}

TEST_F(RecordingTest, the_end_has_its_word_and_says_why) {
  pass(State::Running, 5, 1);
  result.errors.push_back({Fault::Aborted, "the operator aborted it", ""});
  recording.over("aborted");
  EXPECT_EQ(seen().state.view(), "aborted");
  EXPECT_EQ(seen().message.view(), "the operator aborted it [G701]");
  EXPECT_DOUBLE_EQ(seen().remaining_s, 0);
  EXPECT_NEAR(seen().elapsed_s, 5, 1e-9);
}

}  // namespace
}  // namespace gantry::run
