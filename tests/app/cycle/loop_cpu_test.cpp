// Who may run where, as the system itself tells it.
#include "app/cycle/loop_cpu.hpp"

#include <gtest/gtest.h>
#include <thread>
#include <vector>

namespace gantry::cycle {
namespace {

std::vector<int> mine() {
  cpu_set_t set;
  EXPECT_EQ(sched_getaffinity(0, sizeof set, &set), 0);
  std::vector<int> out;
  for (int i = 0; i < CPU_SETSIZE; ++i)
    if (CPU_ISSET(i, &set)) out.push_back(i);
  return out;
}

void only(int cpu) {
  cpu_set_t set;
  CPU_ZERO(&set);
  CPU_SET(cpu, &set);
  ASSERT_EQ(sched_setaffinity(0, sizeof set, &set), 0);
}

TEST(LoopCpu, keeps_this_thread_and_what_it_starts_off_one_cpu_and_gives_it_back) {
  const auto before = mine();
  if (before.size() < 2) GTEST_SKIP() << "one CPU only: there is none to spare";
  {
    const auto taken = LoopCpu::take({});
    ASSERT_TRUE(taken);
    EXPECT_EQ((*taken)->number(), before.back());
    const std::vector<int> others(before.begin(), before.end() - 1);
    EXPECT_EQ(mine(), others);
    std::vector<int> of_a_child;
    std::thread([&] { of_a_child = mine(); }).join();
    EXPECT_EQ(of_a_child, others);
  }
  EXPECT_EQ(mine(), before);
}

TEST(LoopCpu, a_cpu_that_is_named_is_taken) {
  const auto before = mine();
  if (before.size() < 2) GTEST_SKIP() << "one CPU only: there is none to spare";
  const auto taken = LoopCpu::take(before.front());
  ASSERT_TRUE(taken);
  EXPECT_EQ((*taken)->number(), before.front());
  EXPECT_EQ(mine().front(), before[1]);
}

TEST(LoopCpu, a_program_with_one_cpu_shares_it) {
  std::thread([] {
    const int cpu = mine().front();
    only(cpu);
    const auto taken = LoopCpu::take({});
    ASSERT_TRUE(taken);
    EXPECT_EQ((*taken)->number(), LoopCpu::kAny);
    EXPECT_EQ(mine(), std::vector<int>{cpu});
  }).join();
}

TEST(LoopCpu, one_that_may_not_be_used_is_an_error_with_those_that_may) {
  const auto before = mine();
  for (const int wanted : {-1, 1000, 1 << 20}) {
    const auto taken = LoopCpu::take(wanted);
    ASSERT_FALSE(taken) << wanted;
    EXPECT_EQ(taken.error().fault, Fault::Usage);
    EXPECT_NE(taken.error().message.find(std::to_string(before.front())), std::string::npos) << taken.error().message;
    EXPECT_EQ(mine(), before);
  }
}

}  // namespace
}  // namespace gantry::cycle
