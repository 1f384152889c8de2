#include "bench/wake_up/cyclictest.hpp"

#include <fmt/format.h>
#include <sstream>
#include <sys/wait.h>

namespace gantry::bench {

Result<Cyclictest> Cyclictest::start(const Plan& plan) {
  // 20 ms of histogram: single stalls of a virtual machine's host are longer, and are counted as overflows.
  const std::string command = fmt::format(
      "exec cyclictest --quiet --mlockall --priority={} --interval=1000 --threads=1 --affinity={} "
      "--loops={} --histogram=20000 2>&1",
      plan.priority, plan.cpu, plan.cycles);
  std::FILE* pipe = popen(command.c_str(), "r");
  if (pipe == nullptr) return fail(Fault::Internal, "cyclictest cannot be started");
  return Cyclictest(pipe);
}

Result<Latencies> Cyclictest::finish() {
  std::string text;
  char part[4096];
  for (std::size_t n = 0; (n = std::fread(part, 1, sizeof part, pipe_.get())) > 0;) text.append(part, n);
  const int status = pclose(pipe_.release());
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0)
    return fail(Fault::RealTimeRefused, "cyclictest failed (it needs rt-tests and the right to SCHED_FIFO): " + text);
  return parse_histogram(text);
}

Result<Latencies> parse_histogram(const std::string& text) {
  Latencies latencies;
  std::int64_t longest = -1;
  std::uint64_t overflows = 0;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    std::int64_t us = 0;
    std::uint64_t times = 0;
    if (std::sscanf(line.c_str(), "# Max Latencies: %ld", &longest) == 1) continue;
    if (std::sscanf(line.c_str(), "# Histogram Overflows: %lu", &overflows) == 1) continue;
    if (!line.starts_with('#') && std::sscanf(line.c_str(), "%ld %lu", &us, &times) == 2 && times > 0)
      latencies.add(us, times);
  }
  if (longest < 0) return fail(Fault::Internal, "cyclictest printed no histogram: " + text.substr(0, 200));
  if (overflows > 0) latencies.add(longest, overflows);
  return latencies;
}

}  // namespace gantry::bench
