// Random pairs and plans against judges that share nothing with the planner (tests/motion/plan/plan_trial.hpp):
//   build/release/bin/plan_campaign --pairs 1000000 --plans 10000
// Ends with 0 when nothing was wrong, and at most one plan in a thousand undecided.
#include <CLI/CLI.hpp>
#include <cstdio>

#include "tests/motion/plan/plan_trial.hpp"

int main(int argc, char** argv) {
  using namespace gantry::test;
  CLI::App app{"Random pairs and plans against independent judges"};
  int pairs = 1000000, plans = 10000;
  std::uint64_t seed = 2;
  app.add_option("--pairs", pairs)->capture_default_str();
  app.add_option("--plans", plans)->capture_default_str();
  app.add_option("--seed", seed)->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  const PairTally p = try_pairs(pairs, seed);
  std::printf(
      "pairs: %d free, %d hits; %d false free, %d false hits, %d hits that had at most 1e-6 mm more than the "
      "margin, %d disagreements\n",
      p.free, p.hit, p.false_free, p.false_hits, p.close_calls, p.disagreements);
  const PlanTally t = try_plans(plans, seed);
  std::printf(
      "plans: %d paths, %d no path, %d undecided, %d ends collide; %d collide, %d collide in the world, %d ends that "
      "the "
      "world finds free, %d refused, %d disproved, %d longer than lift-over, %d not repeated\n",
      t.ok, t.no_path, t.budget, t.taken, t.colliding, t.in_world, t.unseen, t.refused, t.disproved, t.longer,
      t.different);
  const bool wrong = p.false_free + p.false_hits + p.disagreements + t.colliding + t.in_world + t.unseen + t.refused +
                         t.disproved + t.longer + t.different !=
                     0;
  return wrong || t.budget > plans / 1000 ? 1 : 0;
}
