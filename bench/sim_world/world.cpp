// What the virtual world costs: a sync while a bead is dispensed, a picture, the judgement of a job's deposits.
//   build/release/bin/bench_sim_world        (in the source folder: it reads the shipped machine and recipe)
#include "sim/world/world.hpp"

#include <benchmark/benchmark.h>
#include <cstdlib>

#include "config/machine.hpp"
#include "recipes/recipe.hpp"

namespace gantry::sim {
namespace {

const config::Machine& machine() {
  static const config::Machine m = config::load_machine("config/machines/dispenser.yaml").value();
  return m;
}
const recipes::Recipe& recipe() {
  static const recipes::Recipe r = recipes::load("recipes/demo-board.yaml").value();
  return r;
}

/// Every feature of the recipe at 20 mm/s, with a lift between them; calls `visit(moment)` once a cycle.
template <class Visit>
void play(const BoardTruth& board, Visit visit) {
  const config::Tool& needle = *config::find_tool(machine(), "needle");
  const auto at = [&](Vec2 p, double gap) {
    const Vec3 tip = board.to_machine(p, gap);
    Moment m;
    m.axes[machine().x.value] = tip.x - needle.tip.x;
    m.axes[machine().y.value] = tip.y - needle.tip.y;
    m.axes[machine().z.value] = tip.z - needle.tip.z + needle.lift_mm;
    if (machine().u) m.axes[machine().u->value] = needle.lift_mm;
    return m;
  };
  for (const BoardPlan::Feature& f : board.plan.features) {
    for (int k = 0; k < 30; ++k) visit(at(flat(f.points.front()), 24.0 - 0.8 * k));
    for (std::size_t i = 0; i < f.points.size(); ++i) {
      const Vec2 a = flat(f.points[i]), b = flat(f.points[std::min(i + 1, f.points.size() - 1)]);
      const int ticks = std::max(40, static_cast<int>(norm(b - a) / 0.02));
      for (int k = 0; k < ticks; ++k) {
        Moment m = at(a + (b - a) * (static_cast<double>(k) / ticks), f.gap_mm);
        m.outputs = config::bit(config::Output::Valve);
        visit(m);
      }
    }
    for (int k = 0; k < 30; ++k) visit(at(flat(f.points.back()), 0.8 * (k + 1)));
  }
}

void one_sync_of_a_job(benchmark::State& state) {
  VirtualClock clock;
  World world(machine(), clock, 1, parse_placement("dx=0 mm").value());
  if (!world.load_board(board_plan(recipe()))) std::abort();
  const BoardTruth board(board_plan(recipe()), config::find_frame(machine(), "pallet")->origin, {});
  std::vector<Moment> job;
  play(board, [&](const Moment& m) { job.push_back(m); });
  Time now = milliseconds(1000);
  std::uint64_t cycle = 0;
  std::size_t i = 0;
  for (auto _ : state) {
    now += milliseconds(1);
    benchmark::DoNotOptimize(world.step(++cycle, now, job[i]));
    if (++i == job.size()) i = 0;
  }
}
BENCHMARK(one_sync_of_a_job);

void one_picture(benchmark::State& state) {
  const BoardTruth board(board_plan(recipe()), config::find_frame(machine(), "pallet")->origin, {});
  View view;
  view.focus = board.to_machine(recipe().marks.front().at, 0);
  view.width_px = 1280, view.height_px = 1024;
  view.mm_per_px = machine().camera.mm_per_px;
  std::uint64_t seed = 0;
  for (auto _ : state) benchmark::DoNotOptimize(render(view, &board, ++seed));
}
BENCHMARK(one_picture)->Unit(benchmark::kMillisecond);

void judgement_of_a_job(benchmark::State& state) {
  VirtualClock clock;
  World world(machine(), clock, 1, parse_placement("dx=0 mm").value());
  if (!world.load_board(board_plan(recipe()))) std::abort();
  const BoardTruth board(board_plan(recipe()), config::find_frame(machine(), "pallet")->origin, {});
  Time now = milliseconds(1000);
  std::uint64_t cycle = 0;
  play(board, [&](const Moment& m) { world.step(++cycle, now += milliseconds(1), m); });
  for (auto _ : state) benchmark::DoNotOptimize(world.deposits());
}
BENCHMARK(judgement_of_a_job)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace gantry::sim
