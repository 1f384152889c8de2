#include <gtest/gtest.h>

#include "recipes/job.hpp"

namespace gantry::recipes {
namespace {

config::Machine dispenser() {
  auto m = config::load_machine("config/machines/dispenser.yaml");
  if (!m)
    for (const Error& e : m.error()) ADD_FAILURE() << to_text(e);
  return *m;
}
Recipe demo() { return *load("recipes/demo-board.yaml"); }

TEST(Compile, the_demo_board_is_a_job_on_the_reference_machine) {
  const auto job = compile(demo(), dispenser());
  if (!job)
    for (const Error& e : job.error()) ADD_FAILURE() << to_text(e);
  ASSERT_TRUE(job);
  EXPECT_EQ(job->blocks.size(), 4u + 3u + 1u + 1u);
  EXPECT_EQ(job->blocks.front().number, 1u);
}

}  // namespace
}  // namespace gantry::recipes
