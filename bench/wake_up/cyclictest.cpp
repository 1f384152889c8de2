#include "bench/wake_up/cyclictest.hpp"

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fmt/format.h>
#include <signal.h>
#include <sstream>
#include <sys/wait.h>
#include <unistd.h>

namespace gantry::bench {

Result<Cyclictest> Cyclictest::start(int cpu, int priority) {
  int ends[2];
  if (pipe(ends) != 0) return fail(Fault::Internal, std::string("no pipe to cyclictest: ") + std::strerror(errno));
  const std::string on = fmt::format("--affinity={}", cpu), fifo = fmt::format("--priority={}", priority);
  const pid_t pid = fork();
  if (pid == 0) {
    dup2(ends[1], STDOUT_FILENO);
    dup2(ends[1], STDERR_FILENO);
    close(ends[0]);
    close(ends[1]);
    // 200 ms of histogram: single stalls of a virtual machine's host last many ms, and each counts for as long as it
    // was.
    execlp("cyclictest", "cyclictest", "--quiet", "--mlockall", "--interval=1000", "--threads=1", "--histogram=200000",
           on.c_str(), fifo.c_str(), nullptr);
    std::perror("cyclictest");
    _exit(127);
  }
  close(ends[1]);
  if (pid < 0) {
    close(ends[0]);
    return fail(Fault::Internal, std::string("cyclictest cannot be started: ") + std::strerror(errno));
  }
  return Cyclictest(pid, ends[0]);
}

Cyclictest::~Cyclictest() {
  if (pid_ > 0) {
    kill(pid_, SIGKILL);
    waitpid(pid_, nullptr, 0);
  }
  if (pipe_ >= 0) close(pipe_);
}

Result<Latencies> Cyclictest::finish() {
  kill(pid_, SIGINT);  // it prints its histogram on the way out
  std::string text;
  char part[4096];
  for (ssize_t n = 0; (n = read(pipe_, part, sizeof part)) > 0;) text.append(part, static_cast<std::size_t>(n));
  int status = 0;
  waitpid(pid_, &status, 0);
  pid_ = -1;
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0)
    return fail(Fault::RealTimeRefused,
                "cyclictest failed (it needs rt-tests and the right to SCHED_FIFO): " + text.substr(0, 300));
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
