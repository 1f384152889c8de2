// Planning that is given up, and how long it goes without asking.
#include "core/breath.hpp"

#include <ctime>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <numeric>
#include <thread>

#include "app/job/block_plan.hpp"
#include "app/job/prove.hpp"
#include "tests/app/job/reference.hpp"

namespace gantry::job {
namespace {

double cpu_s() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

TEST(Breath, is_asked_at_least_once_a_feature) {
  const config::Machine machine = test::reference();
  for (const std::size_t rows : {1, 4, 10}) {
    const recipes::Recipe recipe = test::dots(rows, 10);
    const auto job = recipes::compile(recipe, machine);
    ASSERT_TRUE(job);
    std::size_t asked = 0;
    ASSERT_TRUE(prove_nominal(machine, recipe, *job, [&] { return ++asked, true; }));
    EXPECT_GE(asked, recipe.features.size());
  }
}

TEST(Breath, giving_up_at_any_moment_is_told_as_an_abort_and_leaves_nothing_behind) {
  const config::Machine machine = test::reference();
  const recipes::Recipe recipe = test::dots(2, 3);
  BlockPlanner undisturbed(machine, recipe);
  const auto whole = undisturbed.dispense(1, test::parked(machine), {0, 1, 2, 3, 4, 5});
  ASSERT_TRUE(whole);
  int asked = 0, last = -1;
  BlockPlanner planner(machine, recipe, [&] { return asked++ != last; });
  for (last = 0;; ++last) {
    asked = 0;
    const auto block = planner.dispense(1, test::parked(machine), {0, 1, 2, 3, 4, 5});
    if (block) {
      EXPECT_EQ(block->segments().size(), whole->segments().size());
      EXPECT_EQ(block->end(), whole->end());
      EXPECT_EQ(block->duration_s(), whole->duration_s());
      break;
    }
    EXPECT_EQ(block.error().fault, Fault::Aborted);
    EXPECT_EQ(block.error().where, "") << "the recipe is not to blame";
    EXPECT_EQ(asked, last + 1) << "nothing is begun after the no";
  }
  EXPECT_GE(last, 6);
}

TEST(Breath, what_was_begun_is_freed_in_pieces_when_it_is_given_up) {
  const config::Machine machine = test::reference();
  const recipes::Recipe recipe = test::dots(20, 30);
  std::vector<std::size_t> all(recipe.features.size());
  std::iota(all.begin(), all.end(), 0u);
  std::size_t asked = 0, no_at = 0;
  BlockPlanner planner(machine, recipe, [&] { return ++asked, no_at == 0 || asked < no_at; });
  const auto whole = planner.dispense(1, test::parked(machine), all);
  ASSERT_TRUE(whole);
  no_at = asked - 1, asked = 0;
  EXPECT_FALSE(planner.dispense(1, test::parked(machine), all));
  EXPECT_GE(asked - no_at, whole->segments().size() / 300) << "a breath of at most 256 segments";
}

TEST(Breath, two_planners_on_two_threads_do_not_disturb_each_other) {
  const config::Machine machine = test::reference();
  const recipes::Recipe recipe = test::dots(5, 10);
  const auto job = recipes::compile(recipe, machine);
  ASSERT_TRUE(job);
  const auto alone = prove_nominal(machine, recipe, *job);
  ASSERT_TRUE(alone);
  Result<NominalProof> other;
  std::thread worker([&] { other = prove_nominal(machine, recipe, *job); });
  const auto here = prove_nominal(machine, recipe, *job);
  worker.join();
  for (const auto* proof : {&here, &std::as_const(other)}) {
    ASSERT_TRUE(*proof);
    EXPECT_EQ((*proof)->forecast.s, alone->forecast.s);
    EXPECT_EQ((*proof)->motions, alone->motions);
  }
}

/// The figure (5 ms of CPU are wanted) is printed; what is judged does not depend on how fast the host is: the part of
/// the whole that is done between two breaths. With touches the surface is in doubt, and the whole block is looked
/// through for it once more.
TEST(Breath, no_stretch_of_planning_many_dots_is_long) {
  const config::Machine machine = test::reference();
  const std::string touched =
      "touches: {a: {at: [5 mm, 5 mm]}, b: {at: [75 mm, 5 mm]}, c: {at: [5 mm, 50 mm]}}\n"
      "touch_rules: {window: 1 mm}\n";
  for (const auto& [columns, more] : {std::pair{500, std::string()}, {100, touched}}) {
    const double parsing = cpu_s();
    const recipes::Recipe recipe = test::dots(200, static_cast<std::size_t>(columns), more);
    const double compiling = cpu_s();
    const auto job = recipes::compile(recipe, machine);
    ASSERT_TRUE(job);
    fmt::print("parsed in {:.1f} ms of CPU, compiled in {:.1f} ms\n", (compiling - parsing) * 1e3,
               (cpu_s() - compiling) * 1e3);
    double last = cpu_s(), longest = 0;
    const double begin = last;
    std::size_t asked = 0, longest_at = 0;
    const auto proof = prove_nominal(machine, recipe, *job, [&] {
      const double now = cpu_s();
      if (++asked, now - last > longest) longest = now - last, longest_at = asked;
      last = now;
      return true;
    });
    ASSERT_TRUE(proof) << to_text(proof.error());
    const double end = cpu_s(), whole = end - begin;
    fmt::print(
        "{} dots: {:.2f} s of CPU, {} breaths, longest stretch {:.3f} ms before breath {}, after the last {:.3f} ms\n",
        recipe.features.size(), whole, asked, longest * 1e3, longest_at, (end - last) * 1e3);
    EXPECT_GE(asked, recipe.features.size());
    EXPECT_LT(longest, whole / 100);
  }
}

}  // namespace
}  // namespace gantry::job
