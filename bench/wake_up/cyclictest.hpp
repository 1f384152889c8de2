// cyclictest (Debian's rt-tests) as the measure of what this machine can do: one thread on one CPU, 1 ms, SCHED_FIFO.
#pragma once
#include <cstdio>
#include <memory>
#include <string>

#include "bench/wake_up/latencies.hpp"
#include "core/error.hpp"

namespace gantry::bench {

struct Plan {
  int cpu = 0;
  int priority = 90;
  int cycles = 10000;
};

/// Starts at once and goes on by itself until `finish`, which waits for its end.
class Cyclictest {
 public:
  static Result<Cyclictest> start(const Plan& plan);
  Result<Latencies> finish();

 private:
  struct Close {
    void operator()(std::FILE* f) const { pclose(f); }
  };
  explicit Cyclictest(std::FILE* pipe) : pipe_(pipe) {}
  std::unique_ptr<std::FILE, Close> pipe_;
};

/// The histogram that `cyclictest --histogram` prints, with what exceeds it counted at its maximum.
Result<Latencies> parse_histogram(const std::string& text);

}  // namespace gantry::bench
