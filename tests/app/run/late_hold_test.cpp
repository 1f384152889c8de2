// In real time an order is given by what the loop showed some cycles ago, and reaches it some cycles later. A hold that
// was answered holds all the same: the block that plays, or the one that comes next.
#include <deque>
#include <gtest/gtest.h>

#include "app/job/jog.hpp"
#include "app/job/walk.hpp"
#include "app/run/control.hpp"
#include "tests/app/job/reference.hpp"

namespace gantry::run {
namespace {

using cycle::CommandKind;
using cycle::EventKind;
using cycle::State;

/// Plays each block for some cycles, as the loop's table of states has it. What it shows comes `lag` cycles late, and
/// it begins a block `lag` cycles after it was asked to.
class LateLoop final : public Pump {
 public:
  explicit LateLoop(cycle::Channels& channels) : channels_(channels) {}
  void step() override {
    ++cycle;
    for (motion::Segment s; channels_.segments.pop(s);) continue;
    for (cycle::Command c; channels_.commands.pop(c);) asked_.push_back({cycle + lag, c});
    while (!asked_.empty() && asked_.front().due <= cycle) {
      take(asked_.front().command);
      asked_.pop_front();
    }
    if (state == State::Running) ++ran, --left_;
    if (state == State::Holding) state = State::Held;
    if (state == State::Running && left_ == 0) {
      state = State::Ready;
      told_.push_back({.kind = EventKind::BlockDone, .block = block_, .cycle = cycle});
      block_ = 0;
    }
    cycle::Snapshot now;
    now.cycle = cycle;
    now.state = state;
    now.block = block_;
    shown_.push_back(now);
    if (static_cast<CycleIndex>(shown_.size()) <= lag) return;
    const cycle::Snapshot s = shown_.front();
    shown_.pop_front();
    while (!told_.empty() && told_.front().cycle <= s.cycle) {
      EXPECT_TRUE(channels_.events.push(told_.front()));
      told_.pop_front();
    }
    EXPECT_TRUE(channels_.snapshots.push(s));
  }

  CycleIndex cycle = 0, lag = 0;
  State state = State::Ready;
  int ran = 0, length = 50;  ///< cycles in which a block has played, of one block
  int holds = 0;             ///< that it has taken

 private:
  void take(const cycle::Command& c) {
    const std::optional<cycle::Cause> cause = cycle::cause(c.kind);
    const std::optional<State> to = cause ? cycle::next(state, *cause) : state;
    told_.push_back({.kind = EventKind::CommandDone,
                     .fault = to ? Fault::None : Fault::Refused,
                     .id = c.id,
                     .block = block_,
                     .cycle = cycle});
    if (!to) return;
    state = *to;
    holds += c.kind == CommandKind::Hold;
    if (c.kind == CommandKind::StartBlock) block_ = c.block, left_ = length;
  }

  struct Asked {
    CycleIndex due;
    cycle::Command command;
  };
  cycle::Channels& channels_;
  std::deque<Asked> asked_;
  std::deque<cycle::Event> told_;
  std::deque<cycle::Snapshot> shown_;
  std::uint32_t block_ = 0;
  int left_ = 0;
};

struct LateHold : ::testing::Test {
  /// As an owner obeys it (owner_orders.cpp): by the state that it sees.
  void order_hold() {
    if (cycle::next(control.latest().state, cycle::Cause::Hold))
      control.hold(false);
    else
      control.hold_next(true);
  }
  bool order_resume() {
    if (control.hold_is_on_its_way()) return false;
    control.hold_next(false);
    if (cycle::next(control.latest().state, cycle::Cause::Resume)) control.post({.kind = CommandKind::Resume});
    return true;
  }
  static job::ProvenBlock a_block() {
    static const config::Machine machine = test::reference();
    const auto jog = job::read_jog(machine, {.by = {{"X", "5 mm"}}, .speed = ""});
    EXPECT_TRUE(jog);
    auto planned = job::plan_jog(machine, job::Surroundings(machine), test::parked(machine), *jog);
    EXPECT_TRUE(planned) << (planned ? "" : to_text(planned.error()));
    return *std::move(planned);
  }

  std::unique_ptr<cycle::Channels> channels = std::make_unique<cycle::Channels>();
  LateLoop loop{*channels};
  Feed feed{*channels};
  Control control{*channels, feed, loop, milliseconds(1), [](const cycle::Event& e) {
                    return Error{e.fault, "in words", ""};
                  }};
};

/// Whenever the hold comes while two blocks play one after the other, from the first step of the first on, fewer cycles
/// play after it than its way to the loop is long, until the resume; with it both come to their end.
TEST_F(LateHold, whenever_it_comes_it_holds_until_the_resume) {
  const job::ProvenBlock block = a_block();
  int held = 0;
  for (const CycleIndex lag : {0, 1, 3, 8})
    for (int at = 0; at < 130; ++at) {
      SCOPED_TRACE(testing::Message() << "in step " << at << ", heard " << lag << " cycles late");
      loop.lag = lag;
      loop.ran = 0;
      control.begin();
      int step = 0, ran_at = 0;
      bool ordered = false, resumed = false;
      control.on_step([&] {
        if (step++ < at || resumed) return;
        if (!ordered) {
          ordered = true;
          ran_at = loop.ran;
          order_hold();
        } else if (step > at + 60) {
          EXPECT_LE(loop.ran - ran_at, 2 * static_cast<int>(lag) + 2) << "on its way to the loop";
          EXPECT_NE(loop.state, State::Running);
          EXPECT_TRUE(order_resume());
          resumed = true;
        }
      });
      bool both = true;
      for (int i = 0; i < 2; ++i) both = both && control.play(block).has_value();
      control.on_step({});
      EXPECT_TRUE(both);
      EXPECT_EQ(loop.ran, 2 * loop.length);
      held += resumed;
      control.end();
      for (int i = 0; i < 20; ++i) control.step();
    }
  EXPECT_GT(held, 4 * 100);
}

/// A resume that came before the hold is seen would find nothing to go on with.
TEST_F(LateHold, a_resume_is_refused_until_the_hold_is_seen) {
  const job::ProvenBlock block = a_block();
  loop.lag = 5;
  int step = 0, refused = 0;
  bool ordered = false, resumed = false;
  control.on_step([&] {
    ++step;
    if (!ordered && control.latest().state == State::Running) {
      order_hold();
      ordered = true;
    } else if (ordered && !resumed) {
      resumed = order_resume();
      refused += !resumed;
      EXPECT_TRUE(!resumed || control.latest().state == State::Held);
    }
  });
  EXPECT_TRUE(control.play(block));
  EXPECT_TRUE(resumed);
  EXPECT_GE(refused, 10) << "there and back";
  EXPECT_EQ(loop.holds, 1);
}

TEST_F(LateHold, what_is_played_on_hold_is_not_held_by_it) {
  const job::ProvenBlock block = a_block();
  control.hold_next(true);
  EXPECT_TRUE(control.play_on_hold(block));
  EXPECT_EQ(loop.holds, 0);
  EXPECT_TRUE(control.holds_next());
}

/// A walk of a machine that nobody has homed has no proof; its length is bounded by the loop, which must be told.
TEST_F(LateHold, a_motion_that_nothing_proves_is_played_as_a_walk_alone) {
  static const config::Machine machine = test::reference();
  for (const bool all_referenced : {false, true}) {
    const auto walk =
        job::plan_walk(machine, job::Surroundings(machine), test::parked(machine), machine.axes[0], all_referenced);
    ASSERT_TRUE(walk) << to_text(walk.error());
    EXPECT_EQ(walk->proved(), all_referenced);
    for (const auto purpose :
         {cycle::Purpose::Job, cycle::Purpose::Park, cycle::Purpose::Jog, cycle::Purpose::SlowJog}) {
      const auto played = control.play(*walk, purpose);
      EXPECT_EQ(played.has_value(), all_referenced);
      EXPECT_TRUE(played || played.error().fault == Fault::Internal);
    }
    EXPECT_EQ(loop.ran > 0, all_referenced);
    EXPECT_TRUE(control.play(*walk, cycle::Purpose::Walk));
    EXPECT_GT(loop.ran, 0);
    loop.ran = 0;
  }
}

}  // namespace
}  // namespace gantry::run
