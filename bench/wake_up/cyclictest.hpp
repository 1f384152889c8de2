// cyclictest (Debian's rt-tests) as the measure of what this machine can do: one thread on one CPU, 1 ms, SCHED_FIFO.
//   auto peer = Cyclictest::start(1, 90);   ...   auto latencies = peer->finish();
#pragma once
#include <string>
#include <sys/types.h>

#include "bench/wake_up/latencies.hpp"
#include "core/error.hpp"

namespace gantry::bench {

class Cyclictest {
 public:
  /// Starts at once and goes on until finish().
  static Result<Cyclictest> start(int cpu, int priority);
  Cyclictest(Cyclictest&& other) noexcept : pid_(other.pid_), pipe_(other.pipe_) { other.pid_ = other.pipe_ = -1; }
  Cyclictest& operator=(Cyclictest&&) = delete;
  ~Cyclictest();

  /// Ends it and reads what it saw.
  Result<Latencies> finish();

 private:
  Cyclictest(pid_t pid, int pipe) : pid_(pid), pipe_(pipe) {}
  pid_t pid_;
  int pipe_;
};

/// The histogram that `cyclictest --histogram` prints, with what exceeds it counted at its maximum.
Result<Latencies> parse_histogram(const std::string& text);

}  // namespace gantry::bench
