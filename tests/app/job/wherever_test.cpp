// What the nominal placement's proof says of other placements: judged by planning each feature where the board then
// lies.
#include "app/job/wherever.hpp"

#include <cmath>
#include <numbers>
#include <random>
#include <set>

#include "app/job/block_plan.hpp"
#include "app/job/prove.hpp"
#include "tests/app/job/random_board.hpp"
#include "tests/app/job/reference.hpp"

namespace gantry::job {
namespace {

std::set<std::string> named(const config::Machine& machine, const recipes::Recipe& recipe) {
  const auto job = recipes::compile(recipe, machine);
  if (!job) return {};
  const auto found = only_when_placed(machine, recipe, *job);
  EXPECT_TRUE(found) << (found ? "" : to_text(found.error()));
  std::set<std::string> names;
  if (found)
    for (const OnlyWhenPlaced& each : *found) names.insert(each.feature);
  return names;
}

/// The first point of a feature, on the board.
Vec2 begin_of(const recipes::Feature& feature) {
  if (const auto* dot = std::get_if<recipes::Dot>(&feature)) return dot->at;
  return flat(std::get<recipes::Bead>(feature).points.front());
}

// Whatever is refused at a placement within the rules has been named before.
TEST(Wherever, no_feature_is_refused_at_a_placement_that_was_not_named) {
  const config::Machine machine = test::reference();
  std::mt19937_64 random(11);
  const auto some = [&](double most) { return std::uniform_real_distribution<double>(-most, most)(random); };
  std::size_t free = 0, refused = 0, needless = 0, boards = 0;
  for (std::uint64_t number = 0; number < 250; ++number) {
    const test::RandomBoard board = test::random_board(machine, number);
    const recipes::Recipe& recipe = board.recipe;
    if (recipe.marks.empty() || !recipes::compile(recipe, board.machine)) continue;
    ++boards;
    const std::set<std::string> names = named(board.machine, recipe);
    std::set<std::string> met;
    for (int place = 0; place < 12; ++place) {
      const double heading = some(std::numbers::pi), far = place % 2 == 0 ? 1 : std::abs(some(1));
      const double shift = recipe.mark_rules.max_shift_mm * far * (1 - 1e-9);
      const double turn = recipe.mark_rules.max_rotation_rad * (place % 3 == 0 ? std::copysign(1, some(1)) : some(1));
      const double up = recipe.touches.empty() ? 0 : some(recipe.touch_rules.window_mm);
      BlockPlanner planner(board.machine, recipe);
      const recipes::WorkOffset offset{{shift * std::cos(heading), shift * std::sin(heading)}, turn};
      Knowledge known;
      known.offset = offset, known.surface = recipes::Surface{up, {}};
      planner.know(known);
      for (std::size_t f = 0; f < recipe.features.size(); ++f) {
        AxisVec over = recipes::tool_at(
            board.machine, *config::find_tool(board.machine, "needle"),
            recipes::to_machine(recipe, board.machine, offset, {}, begin_of(recipe.features[f]), 0), turn);
        over[board.machine.z.value] = board.machine.safe_z_mm;
        const auto planned = planner.dispense(1, over, {f});
        if (planned || planned.error().fault != Fault::Collision) {
          ++free;
          continue;
        }
        ++refused;
        met.insert(recipes::id_of(recipe.features[f]));
        EXPECT_TRUE(names.contains(recipes::id_of(recipe.features[f])))
            << "board " << number << ": " << to_text(planned.error());
      }
    }
    for (const std::string& name : names) needless += !name.starts_with("touch ") && !met.contains(name);
  }
  std::printf("%zu boards: %zu features free, %zu refused; named and never refused: %zu\n", boards, free, refused,
              needless);
  EXPECT_GT(boards, 35u);
  EXPECT_GT(refused, 20u);
  EXPECT_GT(free, 500u);
}

TEST(Wherever, no_touch_is_refused_at_a_placement_that_was_not_named) {
  const config::Machine machine = test::reference();
  std::mt19937_64 random(12);
  const auto some = [&](double most) { return std::uniform_real_distribution<double>(-most, most)(random); };
  std::size_t free = 0, refused = 0;
  for (std::uint64_t number = 0; number < 250; ++number) {
    const test::RandomBoard board = test::random_board(machine, number);
    const recipes::Recipe& recipe = board.recipe;
    if (recipe.marks.empty() || recipe.touches.empty() || !recipes::compile(recipe, board.machine)) continue;
    const std::set<std::string> names = named(board.machine, recipe);
    for (int place = 0; place < 12; ++place) {
      const double heading = some(std::numbers::pi), shift = recipe.mark_rules.max_shift_mm * (1 - 1e-9);
      const double turn = std::copysign(recipe.mark_rules.max_rotation_rad, some(1));
      Knowledge known;
      known.offset = recipes::WorkOffset{{shift * std::cos(heading), shift * std::sin(heading)}, turn};
      BlockPlanner planner(board.machine, recipe);
      planner.know(known);
      for (std::size_t t = 0; t < recipe.touches.size(); ++t) {
        AxisVec over =
            recipes::tool_at(board.machine, *config::find_tool(board.machine, "probe"),
                             recipes::to_machine(recipe, board.machine, *known.offset, {}, recipe.touches[t].at, 0), 0);
        over[board.machine.z.value] = board.machine.safe_z_mm;
        const auto planned = planner.touch(1, over, t);
        const bool hits = !planned && planned.error().fault == Fault::Collision;
        ++(hits ? refused : free);
        if (!hits) continue;
        EXPECT_TRUE(names.contains("touch " + recipe.touches[t].name))
            << "board " << number << ": " << to_text(planned.error());
      }
    }
  }
  std::printf("%zu touches free, %zu refused\n", free, refused);
  EXPECT_GT(refused, 5u);
  EXPECT_GT(free, 200u);
}

// A clip stands 4 mm beside a dot: free at the nominal placement, not where the board lies 3 mm nearer.
TEST(Wherever, a_clip_within_the_shift_names_the_dots_beside_it_alone) {
  const config::Machine machine = test::reference();
  const auto with_shift = [](const std::string& shift) {
    return test::dots(2, 3,
                      "marks:\n  m0: {at: [5 mm, 6 mm], diameter: 1.5 mm}\n  m1: {at: [70 mm, 45 mm], diameter: 1.5 "
                      "mm}\nmark_rules: {max_shift: " +
                          shift +
                          ", max_rotation: 0.1 deg}\nfixtures:\n  clip: {at: [3 mm, 10 mm], size: [2 mm, 4 mm, "
                          "12 mm]}\n");
  };
  EXPECT_EQ(named(machine, with_shift("4 mm")), (std::set<std::string>{"d[0][0]"}));
  EXPECT_EQ(named(machine, with_shift("0.05 mm")), std::set<std::string>{});
}

TEST(Wherever, where_nothing_measures_the_place_there_is_one_place) {
  const config::Machine machine = test::reference();
  EXPECT_TRUE(named(machine, test::dots(2, 3)).empty());
}

}  // namespace
}  // namespace gantry::job
