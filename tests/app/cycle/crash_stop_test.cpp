// R62: a program that crashes sends the stop frame and dies as it would have died without. Each crash happens in a
// child; the judges are the frame on the socket and what the system says of the child's end.
#include "app/cycle/crash_stop.hpp"

#include <csignal>
#include <cstdlib>
#include <functional>
#include <gtest/gtest.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <thread>

#include "tests/app/cycle/one_drive.hpp"

namespace gantry::test {
namespace {

volatile int zero = 0;
volatile int sink = 0;

void use_up_the_stack(int depth) {
  volatile char page[4096];
  page[0] = static_cast<char>(depth);
  if (depth < 1'000'000) use_up_the_stack(depth + 1);
  sink = page[0];
}

void divide_by_zero() {
#ifdef __x86_64__
  sink = sink / zero;
#else
  raise(SIGFPE);  // elsewhere a division gives some number
#endif
}

void read_past_the_end_of_a_file() {
  const int file = memfd_create("empty", MFD_CLOEXEC);
  sink = *static_cast<volatile int*>(mmap(nullptr, 4096, PROT_READ, MAP_SHARED, file, 0));
}

/// How a child ends that does `work` with a loop that has beaten.
int status_of(OneDrive& drive, const std::function<void()>& work) {
  drive.beat(Time{1});
  const pid_t child = fork();
  if (child == 0) {
    const rlimit no_core{0, 0};
    setrlimit(RLIMIT_CORE, &no_core);
    work();
    _exit(0);
  }
  int status = 0;
  waitpid(child, &status, 0);
  return status;
}

struct Crash {
  const char* name;
  int signal;
  std::function<void()> happen;
};

TEST(CrashStop, each_crash_sends_one_frame_and_ends_by_its_own_signal) {
  const std::vector<Crash> crashes{
      {"null pointer", SIGSEGV, [] { *const_cast<volatile int*>(reinterpret_cast<volatile int*>(zero)) = 1; }},
      {"abort", SIGABRT, [] { std::abort(); }},
      {"terminate", SIGABRT, [] { std::terminate(); }},
      {"illegal instruction", SIGILL, [] { __builtin_trap(); }},
      {"division", SIGFPE, divide_by_zero},
      {"bus error", SIGBUS, read_past_the_end_of_a_file},
      {"from outside", SIGSEGV, [] { kill(getpid(), SIGSEGV); }},
      {"stack used up", SIGSEGV, [] { use_up_the_stack(0); }},
      {"stack of another thread used up", SIGSEGV,
       [] {
         std::thread([] {
           const cycle::AlternateStack stack;
           use_up_the_stack(0);
         }).join();
       }},
      {"in another thread", SIGSEGV,
       [] { std::thread([] { *const_cast<volatile int*>(reinterpret_cast<volatile int*>(zero)) = 1; }).join(); }},
  };
  for (const Crash& crash : crashes) {
    OneDrive drive;
    const int status = status_of(drive, [&] {
      const cycle::CrashStop armed(drive.stop);
      crash.happen();
    });
    EXPECT_TRUE(WIFSIGNALED(status)) << crash.name;
    EXPECT_EQ(WTERMSIG(status), crash.signal) << crash.name;
    EXPECT_EQ(drive.wire.read(0), OneDrive::expected()) << crash.name;
    EXPECT_TRUE(drive.wire.read(0).empty()) << crash.name << ": one frame";
  }
}

// The loop of a program whose other thread crashes may be handing its frame to the system: the stop frame comes again
// when it must have done so.
TEST(CrashStop, has_the_last_word_over_an_exchange_under_way) {
  OneDrive drive;
  const int status = status_of(drive, [&] {
    const cycle::CrashStop armed(drive.stop);
    drive.stop.begin_exchange(Time{2});
    std::abort();
  });
  EXPECT_EQ(WTERMSIG(status), SIGABRT);
  EXPECT_EQ(drive.wire.read(0), OneDrive::expected());
  EXPECT_EQ(drive.wire.read(0), OneDrive::expected());
  EXPECT_TRUE(drive.wire.read(0).empty());
}

TEST(CrashStop, is_silent_when_the_loop_has_made_no_frame) {
  OneDrive drive;
  const int status = status_of(drive, [&] {
    cycle::StopFrame nothing(OneDrive::wiring(), drive.wire.in());
    const cycle::CrashStop armed(nothing);
    std::abort();
  });
  EXPECT_EQ(WTERMSIG(status), SIGABRT);
  EXPECT_TRUE(drive.wire.read(0).empty());
}

void somebody_elses(int) { _exit(77); }

TEST(CrashStop, stands_only_as_long_as_it_lives_and_gives_back_what_was_there) {
  OneDrive drive;
  const int after = status_of(drive, [&] {
    { const cycle::CrashStop armed(drive.stop); }
    std::abort();
  });
  EXPECT_TRUE(WIFSIGNALED(after));
  EXPECT_TRUE(drive.wire.read(0).empty()) << "the bus was left in order before";

  const int handled = status_of(drive, [&] {
    struct sigaction own {};
    own.sa_handler = somebody_elses;
    for (const int number : cycle::CrashStop::kSignals) sigaction(number, &own, nullptr);
    stack_t own_stack{};
    sigaltstack(nullptr, &own_stack);
    { const cycle::CrashStop armed(drive.stop); }
    stack_t now_stack{};
    sigaltstack(nullptr, &now_stack);
    if (now_stack.ss_sp != own_stack.ss_sp || now_stack.ss_flags != own_stack.ss_flags) _exit(1);
    for (const int number : cycle::CrashStop::kSignals) {
      struct sigaction there {};
      sigaction(number, nullptr, &there);
      if (there.sa_handler != somebody_elses) _exit(2);
    }
    raise(SIGSEGV);
  });
  EXPECT_TRUE(WIFEXITED(handled));
  EXPECT_EQ(WEXITSTATUS(handled), 77);
}

TEST(CrashStop, a_program_that_ends_without_order_can_ask_for_it) {
  OneDrive drive;
  EXPECT_EQ(status_of(drive, [&] { cycle::stop_before_exit(); }), 0);
  EXPECT_TRUE(drive.wire.read(0).empty()) << "no bus is in operation";
  EXPECT_EQ(status_of(drive,
                      [&] {
                        const cycle::CrashStop armed(drive.stop);
                        cycle::stop_before_exit();
                      }),
            0);
  EXPECT_EQ(drive.wire.read(0), OneDrive::expected());
}

}  // namespace
}  // namespace gantry::test
