#include "devices/deadline_timer.hpp"

#include <cerrno>
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/socket.h>
#include <thread>
#include <unistd.h>

namespace gantry::devices {
namespace {

/// A socket on which nothing ever comes, and whose receive gives up by itself only when a test has long failed.
class Silence {
 public:
  Silence() {
    EXPECT_EQ(::socketpair(AF_UNIX, SOCK_DGRAM, 0, ends_), 0);
    const timeval patience{.tv_sec = 100, .tv_usec = 0};
    EXPECT_EQ(::setsockopt(ends_[0], SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience), 0);
  }
  ~Silence() {
    for (const int end : ends_) ::close(end);
  }
  /// Until the deadline; false: longer than that.
  [[nodiscard]] bool listen(DeadlineTimer& timer, Time deadline) const {
    const MonotonicClock clock;
    const DeadlineTimer::Wait wait(timer, deadline);
    while (clock.now() < deadline) {
      timer.aim(deadline);
      char byte = 0;
      if (::recv(ends_[0], &byte, 1, 0) >= 0 || errno != EINTR) return false;
    }
    return true;
  }

 private:
  int ends_[2]{};
};

/// ThreadSanitizer of g++ 12 keeps signals to itself while recv() waits (its interceptor does not count as blocking).
class DeadlineTimerWaits : public ::testing::Test {
 protected:
  void SetUp() override {
#ifdef __SANITIZE_THREAD__
    GTEST_SKIP() << "signals do not interrupt recv() under ThreadSanitizer";
#endif
  }
};

TEST_F(DeadlineTimerWaits, end_at_the_deadline) {
  MonotonicClock clock;
  const Silence silence;
  DeadlineTimer timer;
  ASSERT_TRUE(timer.valid());
  for (const int step_us : {50, 700, 25'000, 30, 3000, 3000, 1000, 17}) {
    const Time deadline = clock.now() + microseconds(step_us);
    timer.aim(deadline);
    EXPECT_TRUE(silence.listen(timer, deadline)) << step_us;
  }
  timer.aim(clock.now() + std::chrono::hours(1));  // an earlier one takes the place of a later one
  const Time deadline = clock.now() + milliseconds(1);
  timer.aim(deadline);
  EXPECT_TRUE(silence.listen(timer, deadline));
}

// The signal then comes before the call, in it, and at every instant between: none may be waited out.
TEST_F(DeadlineTimerWaits, end_although_they_begin_when_it_has_rung) {
  MonotonicClock clock;
  const Silence silence;
  DeadlineTimer timer;
  for (int i = 0; i < 3000; ++i) {
    const Time deadline = clock.now() + Time{1 + 7 * i};
    timer.aim(deadline);
    ASSERT_TRUE(silence.listen(timer, deadline)) << i;
  }
}

TEST_F(DeadlineTimerWaits, end_in_the_thread_that_aims_it) {
  MonotonicClock clock;
  const Silence silence;
  DeadlineTimer timer;
  for (int i = 0; i < 20; ++i) {  // one after the other: a new thread may lie where the last one did
    std::thread([&] {
      const Time deadline = clock.now() + milliseconds(1);
      EXPECT_TRUE(silence.listen(timer, deadline));
    }).join();
    const Time deadline = clock.now() + milliseconds(1);
    timer.aim(deadline);
    EXPECT_TRUE(silence.listen(timer, deadline));
  }
}

TEST(DeadlineTimer, that_nobody_waits_for_rings_once) {
  MonotonicClock clock;
  DeadlineTimer timer;
  timer.aim(clock.now() + milliseconds(1));
  clock.sleep_until(clock.now() + milliseconds(10));
  EXPECT_EQ(::poll(nullptr, 0, 20), 0);  // -1: a signal
}

TEST(DeadlineTimer, of_a_deadline_that_is_no_longer_waited_for_rings_once) {
  MonotonicClock clock;
  DeadlineTimer timer;
  timer.aim(clock.now() + milliseconds(1));
  const DeadlineTimer::Wait wait(timer, clock.now() + std::chrono::hours(1));
  clock.sleep_until(clock.now() + milliseconds(10));
  EXPECT_EQ(::poll(nullptr, 0, 20), 0);
}

}  // namespace
}  // namespace gantry::devices
