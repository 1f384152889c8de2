// When the program crashes (SIGSEGV, SIGABRT, SIGBUS, SIGFPE, SIGILL), its last act is to send the stop frame; then the
// signal takes its ordinary course, so that core and exit status are those of the crash. SIGKILL leaves no such chance:
// there the stations' own watchdogs answer.
//   const CrashStop crash_stop(stop);   // while the bus is in operation; one at a time in a process
//   const AlternateStack stack;         // in every thread whose stack may overflow
#pragma once
#include <array>
#include <csignal>

#include "app/cycle/stop_frame.hpp"

namespace gantry::cycle {

/// A second stack for the signal handlers of the calling thread, so that they also run when the first is used up.
class AlternateStack {
 public:
  AlternateStack();
  /// In the same thread.
  ~AlternateStack();
  AlternateStack(const AlternateStack&) = delete;
  AlternateStack& operator=(const AlternateStack&) = delete;

 private:
  void* memory_ = nullptr;
  stack_t before_{};
};

class CrashStop {
 public:
  explicit CrashStop(StopFrame& stop);
  /// Restores the handlers that were there before. In the same thread.
  ~CrashStop();
  CrashStop(const CrashStop&) = delete;
  CrashStop& operator=(const CrashStop&) = delete;

  static constexpr std::array kSignals{SIGSEGV, SIGABRT, SIGBUS, SIGFPE, SIGILL};

 private:
  AlternateStack stack_;
  std::array<struct sigaction, kSignals.size()> before_{};
};

/// For a program that is about to end without order (a second Ctrl-C): sends the stop frame when a CrashStop stands.
/// May be called in a signal handler.
void stop_before_exit() noexcept;

}  // namespace gantry::cycle
