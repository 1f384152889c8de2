#include "bench/wake_up/subject.hpp"

#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <pthread.h>
#include <sched.h>
#include <sys/wait.h>
#include <thread>
#include <vector>

#include "core/clock.hpp"

namespace gantry::bench {

Result<Figures> run_empty_loop(int cpu, int priority, int seconds) {
  std::vector<std::int64_t> late_ns(static_cast<std::size_t>(seconds) * 1000);  // touched here: no page is new later
  int refused = 0;
  std::thread thread([&] {
    cpu_set_t cpus;
    CPU_ZERO(&cpus);
    CPU_SET(static_cast<std::size_t>(cpu), &cpus);
    const sched_param fifo{.sched_priority = priority};
    refused = pthread_setaffinity_np(pthread_self(), sizeof cpus, &cpus);
    if (refused == 0) refused = pthread_setschedparam(pthread_self(), SCHED_FIFO, &fifo);
    if (refused != 0) return;
    MonotonicClock clock;
    Time next = clock.now() + milliseconds(1);
    for (std::int64_t& late : late_ns) {
      clock.sleep_until(next);
      const Time now = clock.now();
      late = (now - next).count();
      do
        next += milliseconds(1);  // after a stall the phase is kept and nothing comes in a burst, as cyclictest does it
      while (next <= now);
    }
  });
  thread.join();
  if (refused != 0)
    return fail(Fault::RealTimeRefused, std::string("the loop's thread was refused SCHED_FIFO or its CPU: ") +
                                            std::strerror(refused) + "; run as root, or see `gantry doctor`");
  Latencies latencies;
  for (const std::int64_t ns : late_ns) latencies.add(ns / 1000);
  return figures(latencies);
}

Result<Figures> run_job(int cpu, const std::string& program, const std::string& recipe) {
  std::string folder = (std::filesystem::temp_directory_path() / "wake_up-XXXXXX").string();
  if (mkdtemp(folder.data()) == nullptr) return fail(Fault::FileUnwritable, "no folder for the job's results", folder);
  const std::string command =
      fmt::format("'{}' run '{}' --loop-cpu {} --out '{}/out' --force --state '{}/state' >'{}/log' 2>&1", program,
                  recipe, cpu, folder, folder, folder);
  const auto text_of = [&](const char* name) {
    std::ifstream in(std::filesystem::path(folder) / name);
    return std::string(std::istreambuf_iterator<char>(in), {});
  };
  const int status = std::system(command.c_str());
  // A job that the host's stall has stopped has cycles to count like any other.
  const auto counts = [](int code) { return code == 0 || code == static_cast<int>(ExitCode::Deadline); };
  Result<Figures> found =
      WIFEXITED(status) && counts(WEXITSTATUS(status))
          ? parse_summary(text_of("out/summary.json"))
          : fail(Fault::Internal, fmt::format("`{}` ended with {}: {}", command, WEXITSTATUS(status), text_of("log")));
  std::filesystem::remove_all(folder);
  return found;
}

Result<Figures> parse_summary(const std::string& text) {
  try {
    const auto cycle = nlohmann::json::parse(text).at("cycle");
    const auto& wake = cycle.at("wake_us");
    const auto& compute = cycle.at("compute_us");
    if (!cycle.at("real_time_priority").get<bool>())
      return fail(Fault::RealTimeRefused, "the loop had no real-time priority; run as root, or see `gantry doctor`");
    return Figures{.at = {wake.at("p50").get<double>(), wake.at("p99").get<double>(), wake.at("p99_9").get<double>()},
                   .max = wake.at("max").get<double>(),
                   .stalls = cycle.at("stalls").get<std::uint64_t>(),
                   .slept = cycle.at("skipped").get<std::uint64_t>(),
                   .missed = cycle.at("deadline_misses").get<std::uint64_t>(),
                   .cycles = cycle.at("cycles").get<std::uint64_t>(),
                   .cost = fmt::format("{:.1f} / {:.1f} / {:.1f} / {:.1f}", compute.at("p50").get<double>(),
                                       compute.at("p99").get<double>(), compute.at("p99_9").get<double>(),
                                       compute.at("max").get<double>())};
  } catch (const nlohmann::json::exception& e) {
    return fail(Fault::Internal, std::string("summary.json has another form than this bench knows: ") + e.what());
  }
}

}  // namespace gantry::bench
