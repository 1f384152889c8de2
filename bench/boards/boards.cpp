// Random boards with clips, low parts, ledges and shelves: is what the planner certifies free, and is what it refuses
// not? (tests/app/job/board_trial.hpp says who judges.)
//   boards 10000 [FIRST [alike]]   // exit 1 when a figure is not met; alike: axes of one response_delay
#include <chrono>
#include <cstdlib>
#include <fmt/format.h>
#include <string_view>

#include "tests/app/job/board_trial.hpp"

int main(int argc, char** argv) {
  using namespace gantry;
  const std::uint64_t boards = argc > 1 ? std::strtoull(argv[1], nullptr, 10) : 10'000;
  const std::uint64_t first = argc > 2 ? std::strtoull(argv[2], nullptr, 10) : 0;
  auto machine = config::load_machine("config/machines/dispenser.yaml");
  if (!machine) return fmt::print(stderr, "{}\n", to_text(machine.error().front())), 3;
  if (argc > 3 && std::string_view(argv[3]) == "alike")
    for (config::Axis& axis : machine->axes) axis.response_delay_s = 0.004;
  const auto begin = std::chrono::steady_clock::now();
  test::Verdict v;
  for (std::uint64_t i = first; i < first + boards; ++i) test::try_board(test::random_board(*machine, i), i, v);
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin;
  fmt::print(
      "{} boards from number {} in {:.0f} s: {} steps, {} motions certified, {} touches, {} rises, {} homings, {} "
      "pieces of blended travel\n",
      v.boards, first, took.count(), v.steps, v.motions, v.touched, v.rises, v.homings, v.blended);
  fmt::print("  certified: {} world collisions, {} touches of something else, {} nearer than the clearance\n",
             v.collisions, v.misread, v.too_near);
  fmt::print(
      "  refused:   {} ({} because a tilt was not measured, {} by another rule), {} without both bodies and the line, "
      "{} falsely\n",
      v.refused, v.in_doubt, v.by_rules, v.unnamed, v.false_refusals);
  for (const std::string& told : v.told) fmt::print("  {}\n", told);
  const bool met = v.collisions + v.misread + v.too_near + v.unnamed == 0 &&
                   static_cast<double>(v.false_refusals) <= 1e-3 * static_cast<double>(v.refused);
  return met ? 0 : 1;
}
