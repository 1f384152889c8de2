// An owner in real time hears of orders however long others let it wait: here the camera, which gives no picture for a
// second at each mark. The clock is the wall's.
#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <unistd.h>

#include "app/run/owner.hpp"
#include "config/machine.hpp"
#include "recipes/job.hpp"
#include "tests/machine/rig.hpp"

namespace gantry {
namespace {

using std::chrono::steady_clock;

TEST(Listening, a_camera_that_gives_no_picture_keeps_nobody_waiting) {
  const auto script = std::filesystem::temp_directory_path() / ("gantry-listening-" + std::to_string(getpid()));
  std::ofstream(script) << "- {at: job start, do: camera_dead}\n";
  auto machine = config::load_machine("config/machines/dispenser.yaml");
  ASSERT_TRUE(machine);
  machine->bus.stop_after_missed_sim = 1000;  // what is judged is the run thread, not the host
  run::OwnerOptions options;
  options.sim.script_file = script;
  auto owner = run::Owner::open(*machine, options);
  ASSERT_TRUE(owner) << to_text(owner.error());
  ASSERT_TRUE((*owner)->bring_up());
  const recipes::Recipe recipe = test::load_recipe("tests/cli/short-board.yaml");
  const auto job = recipes::compile(recipe, *machine);
  ASSERT_TRUE(job);
  steady_clock::time_point last = steady_clock::now();
  steady_clock::duration longest{};
  (*owner)->on_step([&] {
    const auto now = steady_clock::now();
    if ((*owner)->progress().doing.starts_with("mark")) longest = std::max(longest, now - last);
    last = now;
  });
  const auto result = (*owner)->run(recipe, *job, {});
  ASSERT_FALSE(result.errors.empty());
  EXPECT_EQ(result.errors.front().fault, Fault::CameraTimeout) << to_text(result.errors.front());
  EXPECT_LT(longest, std::chrono::milliseconds(500)) << "the camera is waited for during 1 s";
  (*owner)->on_step({});
  owner->reset();
  std::filesystem::remove(script);
}

}  // namespace
}  // namespace gantry
