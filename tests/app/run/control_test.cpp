// The run thread's hand on the loop, against a loop of a few lines: what is in flight is polled, and no step runs in
// another one.
#include "app/run/control.hpp"

#include <deque>
#include <gtest/gtest.h>

namespace gantry::run {
namespace {

using cycle::CommandKind;
using cycle::EventKind;

constexpr std::size_t kTakes = 8;  // commands a cycle, as the loop does

/// Takes some commands in each cycle and answers them after `delay` cycles, unless it is mute.
class LoopOfAFewLines final : public Pump {
 public:
  explicit LoopOfAFewLines(cycle::Channels& channels) : channels_(channels) {}
  void step() override {
    ++steps;
    if (within_poll) ++nested;
    cycle::Snapshot now;
    now.cycle = ++cycle_;
    now.state = state;
    cycle::Command c;
    for (std::size_t i = 0; i < kTakes && takes && channels_.commands.pop(c); ++i) {
      taken.push_back(c);
      if (!mute) owed_.push_back({cycle_ + delay, c.id});
    }
    while (!owed_.empty() && owed_.front().due <= cycle_) {
      const bool refused = owed_.front().id == refuse;
      EXPECT_TRUE(channels_.events.push({.kind = EventKind::CommandDone,
                                         .fault = refused ? Fault::Refused : Fault::None,
                                         .id = owed_.front().id,
                                         .cycle = cycle_}));
      owed_.pop_front();
    }
    EXPECT_TRUE(channels_.snapshots.push(now));
  }

  int steps = 0, nested = 0;
  CycleIndex delay = 0;
  bool takes = true, mute = false, within_poll = false;
  cycle::State state = cycle::State::Ready;
  std::uint32_t refuse = 0;
  std::vector<cycle::Command> taken;

 private:
  struct Owed {
    CycleIndex due;
    std::uint32_t id;
  };
  cycle::Channels& channels_;
  CycleIndex cycle_ = 0;
  std::deque<Owed> owed_;
};

class Controls : public ::testing::Test {
 protected:
  std::unique_ptr<cycle::Channels> channels_ = std::make_unique<cycle::Channels>();
  LoopOfAFewLines loop_{*channels_};
  Feed feed_{*channels_};
  Control control_{*channels_, feed_, loop_, milliseconds(1), [](const cycle::Event& e) {
                     return Error{e.fault, "in words", ""};
                   }};
};

TEST_F(Controls, orders_from_within_a_step_take_none_and_reach_the_loop_in_their_order) {
  constexpr int kMany = 300;
  ASSERT_GT(kMany, static_cast<int>(decltype(channels_->commands)::capacity()));
  int polls = 0;
  control_.on_step([&] {
    loop_.within_poll = true;
    if (polls++ == 0)
      for (int i = 1; i <= kMany; ++i) control_.post({.kind = CommandKind::Override, .value = i / 1000.0});
    loop_.within_poll = false;
  });
  control_.step();
  EXPECT_EQ(loop_.steps, 1);
  EXPECT_EQ(loop_.nested, 0);
  EXPECT_EQ(polls, 1);
  for (int i = 0; i < 2 + kMany / static_cast<int>(kTakes); ++i) control_.step();
  EXPECT_EQ(loop_.nested, 0);
  ASSERT_EQ(loop_.taken.size(), static_cast<std::size_t>(kMany));
  for (int i = 0; i < kMany; ++i) EXPECT_EQ(loop_.taken[static_cast<std::size_t>(i)].value, (i + 1) / 1000.0);
}

/// Before, an order that found the ring full stepped until there was room, and never came back from a loop that hangs.
TEST_F(Controls, orders_to_a_loop_that_takes_none_return_at_once_and_those_that_can_wait_are_refused) {
  loop_.takes = false;
  int posted = 0;
  while (control_.not_crowded() && posted < 10'000) control_.post({.kind = CommandKind::Resume}), ++posted;
  EXPECT_EQ(posted, static_cast<int>(decltype(channels_->commands)::capacity() + InFlight::kCrowd));
  EXPECT_EQ(loop_.steps, 0);
  EXPECT_EQ(control_.not_crowded().error().fault, Fault::Refused);
  loop_.takes = true;
  for (int i = 0; i < 20; ++i) control_.step();
  EXPECT_TRUE(control_.not_crowded());
  EXPECT_EQ(loop_.taken.size(), static_cast<std::size_t>(posted));
}

TEST_F(Controls, an_answer_is_polled_and_told_once) {
  loop_.delay = 3;
  const Request first = control_.request({.kind = CommandKind::Reset});
  const Request second = control_.request({.kind = CommandKind::Reset});
  loop_.refuse = second.id;
  for (int i = 0; i < 3; ++i) {
    control_.step();
    EXPECT_FALSE(control_.answer(first));
  }
  control_.step();
  const auto refused = control_.answer(second);
  ASSERT_TRUE(refused);
  EXPECT_EQ(refused->error().fault, Fault::Refused);
  const auto done = control_.answer(first);
  ASSERT_TRUE(done);
  EXPECT_TRUE(*done);
  EXPECT_FALSE(control_.answer(first)) << "it was told already";
}

TEST_F(Controls, an_answer_that_nobody_wants_any_more_is_not_kept) {
  InFlight asked(*channels_);
  const Request wanted = asked.ask({.kind = CommandKind::Reset}), unwanted = asked.ask({.kind = CommandKind::Reset});
  asked.forget(unwanted);
  for (const Request r : {unwanted, wanted}) asked.see({.kind = EventKind::CommandDone, .id = r.id});
  EXPECT_TRUE(asked.answer(wanted));
  EXPECT_FALSE(asked.answer(unwanted));
}

TEST_F(Controls, a_command_behind_a_crowd_hears_its_own_answer) {
  for (int i = 0; i < 200; ++i) control_.post({.kind = CommandKind::Override, .value = 1});
  EXPECT_TRUE(control_.command({.kind = CommandKind::Enable}, 1));
  EXPECT_EQ(loop_.taken.back().kind, CommandKind::Enable);
  EXPECT_EQ(loop_.steps, 201 / static_cast<int>(kTakes) + 1);
}

TEST_F(Controls, a_command_that_is_not_answered_ends_at_its_time_of_the_machine) {
  loop_.mute = true;
  const auto late = control_.command({.kind = CommandKind::Enable}, 0.5);
  ASSERT_FALSE(late);
  EXPECT_EQ(late.error().fault, Fault::TransitionTimeout);
  EXPECT_NEAR(loop_.steps, 500, 2);
}

/// Whoever waited is told, and axes that nobody waits for go nowhere.
TEST_F(Controls, motion_that_is_waited_for_in_vain_is_aborted_and_at_rest_before_that_is_told) {
  using cycle::State;
  for (const State moves : {State::Homing, State::Running, State::Holding, State::Ready, State::Enabling}) {
    loop_.taken.clear();
    loop_.state = moves;
    loop_.mute = true;
    int rests_at = 0;
    control_.on_step([&] {
      loop_.mute = loop_.taken.empty();  // the order to home alone has no answer
      if (loop_.taken.empty() || loop_.taken.back().kind != CommandKind::Abort) return;
      if (rests_at == 0) rests_at = loop_.steps + 40;
      if (loop_.steps == rests_at) loop_.state = State::Ready;
    });
    const auto late = control_.command({.kind = CommandKind::Home}, 0.5);
    EXPECT_EQ(late.error().fault, Fault::TransitionTimeout);
    const bool moved = moves == State::Homing || moves == State::Running || moves == State::Holding;
    EXPECT_EQ(loop_.taken.size(), moved ? 2u : 1u) << cycle::name(moves);
    if (moved) {
      EXPECT_EQ(loop_.state, State::Ready) << cycle::name(moves);
    }
    control_.on_step({});
  }
}

TEST_F(Controls, an_abort_from_within_a_step_is_behind_what_was_sent_and_ends_the_wait_when_the_loop_has_taken_it) {
  bool aborted = false;
  control_.on_step([&] {
    if (loop_.steps != 5) return;
    for (int i = 0; i < 100; ++i) control_.post({.kind = CommandKind::Override, .value = 1});
    control_.abort({Fault::Aborted, "somebody", ""});
    aborted = true;
  });
  const auto ended = control_.pass(10);
  ASSERT_TRUE(aborted);
  EXPECT_EQ(ended.error().message, "somebody");
  ASSERT_EQ(loop_.taken.size(), 101u);
  EXPECT_EQ(loop_.taken.back().kind, CommandKind::Abort);
  EXPECT_TRUE(channels_->stop_now.load());
}

}  // namespace
}  // namespace gantry::run
