// The runner on a whole machine in virtual time: it does what JobState says comes next, and its state says how far it
// came.
#include "app/run/runner.hpp"

#include <gtest/gtest.h>
#include <set>

#include "app/job/prove.hpp"
#include "tests/machine/deposits.hpp"
#include "tests/machine/rig.hpp"

namespace gantry {
namespace {

using test::Rig;

constexpr const char* kDemo = "recipes/demo-board.yaml";

/// Which tool each played block works with, from block 1 on, as the result keeps it for the report.
std::vector<std::string> tools_played(const config::Machine& machine, const record::JobResult& result) {
  std::vector<std::string> out;
  for (std::size_t i = 1; i < result.drawing.tip_of_block.size(); ++i)
    for (const char* name : {"camera", "probe", "needle"}) {
      const config::Tool& tool = *config::find_tool(machine, name);
      if (norm(result.drawing.tip_of_block[i] - (tool.tip - Vec3{0, 0, tool.lift_mm})) < 1e-9) out.emplace_back(name);
    }
  return out;
}

std::string tool_of(const job::Next& step) {
  if (std::holds_alternative<recipes::LookAtMark>(step)) return "camera";
  return std::holds_alternative<recipes::Touch>(step) || std::holds_alternative<job::Retract>(step) ? "probe"
                                                                                                    : "needle";
}

TEST(Runner, plays_the_blocks_that_the_prover_has_proved_in_their_order) {
  for (const char* file : {kDemo, "tests/cli/short-board.yaml"}) {
    SCOPED_TRACE(file);
    Rig rig({});
    const recipes::Recipe recipe = test::load_recipe(file);
    const auto job = recipes::compile(recipe, rig.machine());
    ASSERT_TRUE(job);
    const auto proof = job::prove_nominal(rig.machine(), recipe, *job);
    ASSERT_TRUE(proof);
    std::vector<std::string> expected;
    for (const job::Next& step : proof->steps)
      if (!std::holds_alternative<job::SettleOffset>(step) && !std::holds_alternative<job::SettleSurface>(step))
        expected.push_back(tool_of(step));
    const auto result = rig.run(recipe);
    test::expect_done(result);
    std::size_t again = 0;  // a mark that was looked at twice has two blocks
    for (const auto& mark : result.marks) again += static_cast<std::size_t>(mark.attempts - 1);
    ASSERT_EQ(again, 0u);
    EXPECT_EQ(tools_played(rig.machine(), result), expected);
    EXPECT_EQ(result.blocks_done, result.blocks_total);
    EXPECT_EQ(result.features_done, recipe.features.size());
    EXPECT_TRUE(result.interrupted.empty());
  }
}

/// The world counts a deposit when the valve has closed. Features that are done are never more than those, and at every
/// abort all that lies on the board is either done or interrupted.
TEST(Runner, features_done_are_those_that_lie_on_the_board_wherever_an_abort_comes) {
  const recipes::Recipe recipe = test::load_recipe(kDemo);
  int cut = 0, whole = 0;
  for (const bool while_open : {true, false})
    for (const int after : {1, 6, 40, 130}) {
      SCOPED_TRACE(testing::Message() << after << (while_open ? " cycles of an open valve" : " cycles"));
      Rig rig({});
      int cycles = 0;
      rig.on_step = [&](run::Owner& owner) {
        const bool open = (owner.latest().outputs & config::bit(config::Output::Valve)) != 0;
        if (owner.progress().features_done <= 2 || (while_open && !open)) return;
        if (++cycles == after) (void)owner.order({.kind = run::OrderKind::Abort});
      };
      const auto result = rig.run(recipe);
      EXPECT_NE(result.exit_code, ExitCode::Done);
      // A valve that was told to open and shut again before it had opened leaves its feature dry.
      const std::set<std::string> interrupted(result.interrupted.begin(), result.interrupted.end());
      std::size_t whole_ones = 0;
      for (const auto& d : result.deposits) whole_ones += interrupted.contains(d.id) ? 0 : 1;
      EXPECT_EQ(whole_ones, result.features_done);
      EXPECT_LE(interrupted.size(), 1u);
      cut += !result.interrupted.empty();
      whole += result.interrupted.empty();
    }
  EXPECT_GT(cut, 0);
  EXPECT_GT(whole, 0);
}

TEST(Runner, a_job_after_an_abort_rises_first_and_is_done) {
  Rig rig({});
  rig.on_step = [](run::Owner& owner) {
    if (owner.progress().features_done == 5) (void)owner.order({.kind = run::OrderKind::Abort});
  };
  const auto stopped = rig.run(kDemo);
  EXPECT_NE(stopped.exit_code, ExitCode::Done);
  const double z = rig.owner().latest().target[rig.machine().z.value];
  EXPECT_LT(z, rig.machine().safe_z_mm - 0.5);
  rig.on_step = {};
  const auto result = rig.run(kDemo);
  test::expect_done(result);
  ASSERT_FALSE(result.planned.empty());
  EXPECT_NEAR(result.planned.front().head.z, z, 1e-9);
  EXPECT_EQ(tools_played(rig.machine(), result).front(), "needle");
}

/// A probe that stood armed on hold would take whatever touches it for its touch. Armed, this one shows a latch at
/// once.
TEST(Runner, a_touch_on_hold_arms_the_probe_behind_the_resume) {
  Rig rig({.habits = {{"z", {.lies = {.probe = sim::ProbeLie::LatchedAtArming}}}}});
  const recipes::Recipe recipe = test::load_recipe(kDemo);
  bool looked = false, held = false;
  int stood = 0;
  rig.on_step = [&](run::Owner& owner) {
    const bool at_last_mark = owner.progress().doing == "mark " + recipe.marks.back().name;
    looked = looked || (at_last_mark && owner.latest().state == cycle::State::Running);
    if (looked && !held && owner.latest().state == cycle::State::Ready) {
      held = owner.order({.kind = run::OrderKind::Hold}).has_value();
      ASSERT_TRUE(held);
    }
    if (owner.progress().doing.starts_with("touch ") && ++stood == 300) {
      EXPECT_TRUE(owner.order({.kind = run::OrderKind::Resume}));
    }
  };
  const auto result = rig.run(recipe);
  EXPECT_GE(stood, 300) << "it waits, unarmed";
  ASSERT_FALSE(result.errors.empty());
  EXPECT_EQ(result.errors.front().fault, Fault::ProbeStale);
}

// A fast touch finds the surface, the slow one measures it: the same heights, and twice the probe's blocks.
TEST(Runner, a_touch_of_two_speeds_measures_what_the_slow_one_does) {
  std::vector<double> heights[2];
  std::size_t blocks[2] = {0, 0};
  for (const bool fast : {false, true}) {
    Rig rig({.change = [&](auto& m) {
      if (fast) m.probe.fast_mm_s = 10;  // what the virtual probe bears
    }});
    const auto result = rig.run(kDemo);
    test::expect_done(result);
    for (const auto& t : result.touches) heights[fast].push_back(t.height_mm);
    for (const std::string& tool : tools_played(rig.machine(), result)) blocks[fast] += tool == "probe";
  }
  ASSERT_EQ(heights[0].size(), heights[1].size());
  ASSERT_GE(heights[0].size(), 3u);
  EXPECT_EQ(blocks[1], 2 * blocks[0]) << "down, up, down, up";
  for (std::size_t i = 0; i < heights[0].size(); ++i)
    EXPECT_NEAR(heights[0][i], heights[1][i], 1.0 / 2000 + 5e-3) << "a count, and a cycle at 5 mm/s";
}

}  // namespace
}  // namespace gantry
