#include "core/background.hpp"

#include <algorithm>
#include <gtest/gtest.h>
#include <memory>
#include <sys/resource.h>
#include <unistd.h>

namespace gantry {
namespace {

int niceness() { return ::getpriority(PRIO_PROCESS, static_cast<id_t>(::gettid())); }

TEST(Background, works_behind_its_caller_and_leaves_that_where_it_was) {
  const int before = niceness();
  EXPECT_EQ(in_background([] { return niceness(); }).get(), std::min(before + 10, 19));
  EXPECT_EQ(niceness(), before);
}

TEST(Background, gives_what_the_work_gives_and_throws) {
  EXPECT_EQ(*in_background([own = std::make_unique<int>(7)]() mutable { return std::move(own); }).get(), 7);
  EXPECT_THROW(in_background([] { throw 7; }).get(), int);
}

}  // namespace
}  // namespace gantry
