#include "app/monitor/child.hpp"

#include <csignal>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <thread>
#include <unistd.h>

#include "app/monitor/snapshot_shm.hpp"

namespace gantry::monitor {
namespace {

/// Waits (without a poll of the child) until the process has ended, as a zombie that poll() then reaps.
void wait_for_end(pid_t pid) {
  siginfo_t info{};
  waitid(P_PID, static_cast<id_t>(pid), &info, WEXITED | WNOWAIT);
}

/// A child that stays: sh waits for a signal. `publish --shm PATH` are its ignored arguments.
struct Fixture : ::testing::Test {
  Result<SnapshotWriter> writer = SnapshotWriter::create(MachineInfo{});
  ChildOptions sleeper() {
    ChildOptions o;
    o.program = GANTRY_SOURCE_DIR "/tests/app/monitor/sleeper.sh";
    o.back_off_first = milliseconds(200);
    o.back_off_most = milliseconds(800);
    return o;
  }
};
using PublishChildTest = Fixture;

TEST_F(PublishChildTest, is_started_by_the_first_poll_and_only_once) {
  PublishChild child(writer->fd(), sleeper());
  EXPECT_FALSE(child.alive());
  child.poll(Time{0});
  ASSERT_TRUE(child.alive());
  const auto pid = child.pid();
  for (int i = 1; i < 100; ++i) child.poll(milliseconds(i));
  EXPECT_EQ(child.pid(), pid);
  EXPECT_EQ(child.starts(), 1);
  EXPECT_NE(getpgid(pid), getpgrp()) << "Ctrl-C in the terminal must not end the publisher before the owner";
}

TEST_F(PublishChildTest, is_started_again_after_a_back_off_that_grows) {
  PublishChild child(writer->fd(), sleeper());
  Time now{0};
  child.poll(now);
  for (const auto back_off : {200, 400, 800, 800}) {
    const int starts = child.starts();
    kill(child.pid(), SIGKILL);
    wait_for_end(child.pid());
    child.poll(now);
    EXPECT_FALSE(child.alive());
    child.poll(now + milliseconds(back_off - 1));
    EXPECT_FALSE(child.alive());
    now += milliseconds(back_off);
    child.poll(now);
    ASSERT_TRUE(child.alive());
    EXPECT_EQ(child.starts(), starts + 1);
  }
  // A long life earns a quick restart.
  now += std::chrono::minutes(1);
  kill(child.pid(), SIGKILL);
  wait_for_end(child.pid());
  child.poll(now);
  child.poll(now + milliseconds(200));
  EXPECT_TRUE(child.alive());
}

TEST_F(PublishChildTest, ends_with_its_owner) {
  pid_t pid = 0;
  {
    PublishChild child(writer->fd(), sleeper());
    child.poll(Time{0});
    pid = child.pid();
  }
  EXPECT_NE(kill(pid, 0), 0);
}

TEST_F(PublishChildTest, one_that_cannot_be_started_is_tried_again_later_and_harms_nobody) {
  ChildOptions o = sleeper();
  o.program = "/no/such/program";
  PublishChild child(writer->fd(), o);
  child.poll(Time{0});
  EXPECT_FALSE(child.alive());
  child.poll(milliseconds(10));
  EXPECT_EQ(child.starts(), 1);
  child.poll(milliseconds(5000));
  EXPECT_EQ(child.starts(), 2);
}

TEST_F(PublishChildTest, gets_the_memory_as_descriptor_3_and_nothing_else_of_the_owner) {
  ChildOptions o = sleeper();
  o.program = GANTRY_SOURCE_DIR "/tests/app/monitor/list_files.sh";
  std::string name = "/tmp/gantry-child-XXXXXX";
  const int fd = mkstemp(name.data());
  ASSERT_GE(fd, 0);  // inheritable, as a socket of a library may be
  o.arguments = {name};
  PublishChild child(writer->fd(), o);
  child.poll(Time{0});
  ASSERT_TRUE(child.alive());
  wait_for_end(child.pid());
  std::string listing(4096, '\0');
  listing.resize(static_cast<std::size_t>(std::max<ssize_t>(0, pread(fd, listing.data(), listing.size(), 0))));
  close(fd), unlink(name.c_str());
  EXPECT_NE(listing.find("3 /memfd:gantry-snapshots"), std::string::npos) << listing;
  EXPECT_NE(listing.find("1 /dev/null"), std::string::npos) << listing;
  EXPECT_EQ(listing.find(name), std::string::npos) << listing;
}

}  // namespace
}  // namespace gantry::monitor
