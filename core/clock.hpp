// Time of the machine. Monotonic in a real run, virtual in a dry run, where sleeping is what makes time pass.
#pragma once
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <ctime>

namespace gantry {

/// ns since the clock's own start of time. Never wall-clock time.
using Time = std::chrono::nanoseconds;
using std::chrono::microseconds;
using std::chrono::milliseconds;
using std::chrono::nanoseconds;

inline constexpr Time kNever = Time::max();

constexpr double seconds(Time t) { return static_cast<double>(t.count()) * 1e-9; }

/// How many cycles of `period` a duration takes, to the nearest: so a duration of a file or of an order becomes
/// cycles.
inline std::int64_t cycles_in(double duration_s, Time period) { return std::llround(duration_s / seconds(period)); }

constexpr timespec to_timespec(Time t) noexcept {
  return {.tv_sec = static_cast<time_t>(t.count() / 1'000'000'000),
          .tv_nsec = static_cast<long>(t.count() % 1'000'000'000)};
}

class Clock {
 public:
  virtual ~Clock() = default;
  [[nodiscard]] virtual Time now() const noexcept = 0;
  /// Returns at or after `t`; at once when t is past.
  virtual void sleep_until(Time t) noexcept = 0;
  /// A virtual clock stands still unless somebody sleeps; one thread then owns everything.
  [[nodiscard]] virtual bool is_virtual() const noexcept = 0;
  /// The host woke somebody so much too late: true where this clock takes that out of its time, as if it had not
  /// passed. Real time cannot be stopped.
  virtual bool stand_still(Time /*stall*/) noexcept { return false; }
};

/// CLOCK_MONOTONIC, absolute sleeps.
class MonotonicClock final : public Clock {
 public:
  [[nodiscard]] Time now() const noexcept override;
  void sleep_until(Time t) noexcept override;
  [[nodiscard]] bool is_virtual() const noexcept override { return false; }
};

/// CLOCK_MONOTONIC without the stalls of the host: of a machine that is simulated in this process and must not be
/// disturbed by them. A thread that reads it besides the one that sleeps sees it step back by what was taken out.
class PatientClock final : public Clock {
 public:
  [[nodiscard]] Time now() const noexcept override { return clock_.now() - stood_still(); }
  void sleep_until(Time t) noexcept override { clock_.sleep_until(t + stood_still()); }
  [[nodiscard]] bool is_virtual() const noexcept override { return false; }
  bool stand_still(Time stall) noexcept override {
    stood_still_ns_.fetch_add(stall.count(), std::memory_order_relaxed);
    return true;
  }

 private:
  [[nodiscard]] Time stood_still() const noexcept { return Time{stood_still_ns_.load(std::memory_order_relaxed)}; }

  MonotonicClock clock_;
  std::atomic<std::int64_t> stood_still_ns_{0};
};

/// Starts at 1 s (so that "a little before now" is never negative) and moves only by sleep_until.
class VirtualClock final : public Clock {
 public:
  [[nodiscard]] Time now() const noexcept override { return now_; }
  void sleep_until(Time t) noexcept override {
    if (t > now_) now_ = t;
  }
  [[nodiscard]] bool is_virtual() const noexcept override { return true; }

 private:
  Time now_{1'000'000'000};
};

}  // namespace gantry
