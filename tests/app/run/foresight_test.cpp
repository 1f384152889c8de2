// A foreseen block is the very block that a planner makes at the moment, or none; whichever thread has planned it.
#include "app/run/foresight.hpp"

#include <atomic>
#include <gtest/gtest.h>
#include <thread>

#include "app/job/settle.hpp"
#include "motion/path/chords.hpp"
#include "motion/profile/speed_profile.hpp"
#include "tests/app/job/reference.hpp"

namespace gantry::run {
namespace {

using job::BlockWanted;

/// What would be played, to the last bit.
std::vector<double> played(const job::ProvenBlock& block) {
  std::vector<double> all{static_cast<double>(block.number()), block.duration_s()};
  for (const motion::Segment& s : block.segments()) {
    for (const AxisVec& q : motion::chords(std::span(&s, 1))) all.insert(all.end(), q.begin(), q.end());
    all.insert(all.end(), {motion::duration(s.nominal), s.v_cap, static_cast<double>(s.feature)});
    for (const motion::OutputEvent& e : s.events) all.push_back(e.at_s);
  }
  return all;
}

struct ForesightTest : testing::TestWithParam<Foresight::Thread> {
  config::Machine machine = test::reference();
  recipes::Recipe recipe = test::dots(
      6, 6, "touches:\n  t0: {at: [10 mm, 10 mm]}\n  t1: {at: [70 mm, 10 mm]}\n  t2: {at: [40 mm, 45 mm]}\n");
  AxisVec park = test::parked(machine);

  job::Knowledge known(double z_mm = 0) const {
    job::Knowledge k;
    k.offset = recipes::WorkOffset{}, k.surface = recipes::Surface{z_mm, {}};
    return k;
  }
  BlockWanted dispense(double z_mm = 0) const {
    std::vector<std::size_t> all(recipe.features.size());
    for (std::size_t i = 0; i < all.size(); ++i) all[i] = i;
    return {recipes::Dispense{all}, 5, park, known(z_mm)};
  }
  Result<job::ProvenBlock> at_the_moment(const BlockWanted& wanted) const {
    job::BlockPlanner planner(machine, recipe);
    planner.know(wanted.known);
    return job::plan(planner, wanted);
  }
  Foresight make() const { return {machine, recipe, {.thread = GetParam()}}; }
  static bool serve() {
    std::this_thread::yield();
    return true;
  }
};

TEST_P(ForesightTest, hands_over_what_would_be_planned_at_the_moment) {
  Foresight ahead = make();
  for (const BlockWanted& wanted :
       {dispense(), BlockWanted{recipes::Park{}, 6, AxisVec{50, 60, -20}, known()},
        BlockWanted{recipes::Touch{1}, 2, park, {}}, BlockWanted{job::Retract{1}, 3, AxisVec{260, 160, -70}, {}}}) {
    ahead.begin(wanted);
    const auto foreseen = ahead.take(wanted, serve);
    ASSERT_TRUE(foreseen);
    const auto now = at_the_moment(wanted);
    ASSERT_EQ(foreseen->has_value(), now.has_value()) << to_text((now ? *foreseen : now).error());
    if (now)
      EXPECT_EQ(played(**foreseen), played(*now));
    else
      EXPECT_EQ(to_text(foreseen->error()), to_text(now.error()));
    EXPECT_FALSE(ahead.take(wanted, serve)) << "handed over once";
  }
}

TEST_P(ForesightTest, what_differs_in_anything_is_thrown_away) {
  const BlockWanted right = dispense();
  std::vector<BlockWanted> others(6, right);
  others[0].number = 6;
  others[1].from[0] = std::nextafter(right.from[0], 1e9);
  others[2].known = known(1e-9);
  others[3].known.heights.push_back({0, 0.1});
  others[4].laid.push_back({0, 0.5});
  std::get<recipes::Dispense>(others[5].step).features.pop_back();
  Foresight ahead = make();
  for (const BlockWanted& other : others) {
    do ahead.begin(right);  // one that was given up may still have to end
    while (GetParam() == Foresight::Thread::Own && !ahead.take(right, serve));
    ahead.begin(right);
    EXPECT_FALSE(ahead.take(other, serve)) << &other - others.data();
    EXPECT_FALSE(ahead.take(right, serve)) << "what is not asked for is gone";
  }
}

TEST_P(ForesightTest, nothing_is_foreseen_of_nothing) {
  Foresight ahead = make();
  EXPECT_FALSE(ahead.take(dispense(), serve));
  ahead.begin(dispense());
  ahead.begin(std::nullopt);
  EXPECT_FALSE(ahead.take(dispense(), serve));
}

/// Whoever waits may leave at any moment; the proof that is left behind ends by itself, and then the next one begins.
TEST(ForesightThread, an_order_ends_the_wait_at_once) {
  const config::Machine machine = test::reference();
  const recipes::Recipe recipe = test::dots(4, 4);
  std::atomic<bool> goes_on{false};
  const motion::Opinion slow = [&](const auto&, const auto&, const auto&) -> Result<std::size_t> {
    while (!goes_on) std::this_thread::yield();
    return std::size_t{0};
  };
  const BlockWanted wanted{recipes::Dispense{{0, 1, 2, 3}}, 1, test::parked(machine), {}};
  Foresight ahead(machine, recipe, {.thread = Foresight::Thread::Own, .opinion = slow});
  ahead.begin(wanted);
  int served = 0;
  EXPECT_FALSE(ahead.take(wanted, [&] { return ++served < 3; }));
  EXPECT_EQ(served, 3);
  ahead.begin(wanted);
  EXPECT_FALSE(ahead.take(wanted, [] { return true; })) << "the worker is still at the first one";
  goes_on = true;
  std::optional<Result<job::ProvenBlock>> foreseen;
  while (!foreseen) {
    ahead.begin(wanted);
    foreseen = ahead.take(wanted, [] { return true; });
  }
  EXPECT_TRUE(foreseen->has_value());
}

/// A job from its first mark to its parking, as the runner goes through it: while one block is played the next is
/// proved on a thread of its own, and what is played is what would be planned at the moment. Where the axes end
/// otherwise than foreseen the block is planned anew.
TEST(ForesightThread, a_job_with_marks_and_touches_is_proved_ahead_of_it) {
  const config::Machine machine = test::reference();
  const recipes::Recipe recipe = *recipes::load("recipes/demo-board.yaml");
  const recipes::Job job = *recipes::compile(recipe, machine);
  Foresight ahead(machine, recipe, {.thread = Foresight::Thread::Own});
  job::BlockPlanner planner(machine, recipe);
  std::size_t wrong_ones = 0;
  bool wrong = false;
  std::uint32_t number = 0;  // of the block
  AxisVec at = test::parked(machine);
  job::JobState state = job::begin_state(recipe, job);
  const auto serve = [&] {  // the run thread goes on reading
    EXPECT_TRUE(job::wanted_next(recipe, job, state, false, number, at));
    std::this_thread::yield();
    return true;
  };
  while (const auto wanted = job::wanted_next(recipe, job, state, false, ++number, at)) {
    planner.know(wanted->known);
    auto now = job::plan(planner, *wanted);
    ASSERT_TRUE(now) << to_text(now.error());
    auto block = ahead.take(*wanted, serve);
    EXPECT_EQ(block.has_value(), number > 1 && !wrong) << "block " << number;
    while (wrong && !block) {  // the worker may still end the wrong one
      ahead.begin(*wanted);
      block = ahead.take(*wanted, serve);
    }
    if (block) {
      ASSERT_TRUE(*block) << to_text(block->error());
      EXPECT_EQ(played(**block), played(*now)) << "block " << number;
      planner.share(ahead.planner());
    }
    at = now->end();
    state.known = wanted->known;
    if (const auto* mark = std::get_if<recipes::LookAtMark>(&wanted->step)) {
      state = job::after_mark(recipe, state, mark->mark, recipe.marks[mark->mark].at + Vec2{0.3, -0.2});
    } else if (const auto* touch = std::get_if<recipes::Touch>(&wanted->step)) {
      if (wanted->known.offset) state = job::after_offset(state, *wanted->known.offset);
      state = job::after_touch(state, touch->touch, 0.05);
      at[machine.z.value] += 1.5;  // the touch ends where the board is
    } else if (std::holds_alternative<job::Retract>(wanted->step)) {
      state = job::after_retract(state);
    } else if (std::holds_alternative<recipes::Dispense>(wanted->step)) {
      state = job::after_surface(state, *wanted->known.surface);
      state = job::after_block(state);
    } else {
      ASSERT_TRUE(std::holds_alternative<recipes::Park>(wanted->step));
      state = job::after_block(state);
    }
    wrong = number % 4 == 0;
    wrong_ones += wrong;
    AxisVec expected = at;
    if (wrong) expected[machine.x.value] += 1e-9;
    ahead.begin(job::wanted_next(recipe, job, state, false, number + 1, expected));
  }
  EXPECT_GE(wrong_ones, 2U);
}

/// A copy of the machine is planned with: its owner may write to his.
TEST_P(ForesightTest, the_owner_s_machine_may_change_meanwhile) {
  const BlockWanted wanted = dispense();
  const auto before = at_the_moment(wanted);
  ASSERT_TRUE(before);
  Foresight ahead = make();
  ahead.begin(wanted);
  machine.axes[0].v_max /= 2;
  machine.name = "changed while it is planned";
  const auto foreseen = ahead.take(wanted, serve);
  ASSERT_TRUE(foreseen && *foreseen);
  EXPECT_EQ(played(**foreseen), played(*before));
}

INSTANTIATE_TEST_SUITE_P(Foresight, ForesightTest, testing::Values(Foresight::Thread::Callers, Foresight::Thread::Own),
                         [](const auto& of) { return of.param == Foresight::Thread::Own ? "own" : "callers"; });

// ---- what comes next ----

TEST(WantedNext, goes_through_what_needs_no_motion_and_ends_at_what_the_world_must_answer) {
  const config::Machine machine = test::reference();
  const recipes::Recipe recipe = *recipes::load("recipes/demo-board.yaml");
  const recipes::Job job = *recipes::compile(recipe, machine);
  const AxisVec at = test::parked(machine);
  const auto next = [&](const job::JobState& state) { return job::wanted_next(recipe, job, state, false, 9, at); };
  job::JobState state = job::begin_state(recipe, job);
  for (std::size_t mark = 0; mark < recipe.marks.size(); ++mark) {
    const auto wanted = next(state);
    ASSERT_TRUE(wanted);
    EXPECT_EQ(wanted->step, job::BlockStep(recipes::LookAtMark{mark}));
    EXPECT_EQ(wanted->number, 9u);
    EXPECT_EQ(wanted->known, state.known);
    state = job::after_mark(recipe, state, mark, recipe.marks[mark].at + Vec2{1, 0.5});
  }
  const auto touch = next(state);
  ASSERT_TRUE(touch);
  EXPECT_EQ(touch->step, job::BlockStep(recipes::Touch{0}));
  ASSERT_TRUE(touch->known.offset) << "the offset is settled on the way";
  EXPECT_NEAR(touch->known.offset->shift.x, 1, 1e-9);
  state = job::after_offset(state, *touch->known.offset);
  for (std::size_t t = 0; t < recipe.touches.size(); ++t) {
    state = job::after_touch(state, t, 0.25);
    EXPECT_EQ(next(state)->step, job::BlockStep(job::Retract{t}));
    state = job::after_retract(state);
  }
  const auto dispense = next(state);
  ASSERT_TRUE(dispense);
  EXPECT_TRUE(std::holds_alternative<recipes::Dispense>(dispense->step));
  EXPECT_NEAR(dispense->known.surface->z0, 0.25, 1e-9);
  state = job::after_surface(state, *dispense->known.surface);
  state = job::after_block(state);
  EXPECT_EQ(next(state)->step, job::BlockStep(recipes::Park{}));
  EXPECT_FALSE(next(job::after_block(state))) << "the end";
}

TEST(WantedNext, nothing_follows_marks_that_contradict_each_other) {
  const config::Machine machine = test::reference();
  const recipes::Recipe recipe = *recipes::load("recipes/demo-board.yaml");
  const recipes::Job job = *recipes::compile(recipe, machine);
  job::JobState state = job::begin_state(recipe, job);
  for (std::size_t mark = 0; mark < recipe.marks.size(); ++mark)
    state = job::after_mark(recipe, state, mark, recipe.marks[mark].at + Vec2{mark == 1 ? 2.0 : 0.0, 0});
  ASSERT_FALSE(job::settle_offset(recipe, state.known.marks));
  EXPECT_FALSE(job::wanted_next(recipe, job, state, false, 9, {}));
}

}  // namespace
}  // namespace gantry::run
