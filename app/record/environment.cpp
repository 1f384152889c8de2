#include "app/record/environment.hpp"

#include <fmt/format.h>
#include <fstream>
#include <string>
#include <string_view>
#include <sys/utsname.h>
#include <thread>

#include "app/record/program.hpp"

namespace gantry::record {
namespace {

/// Value of "key : value" in a file of /proc; empty when there is none.
std::string proc_value(const char* path, std::string_view key) {
  std::ifstream in(path);
  for (std::string line; std::getline(in, line);) {
    if (!line.starts_with(key)) continue;
    const auto colon = line.find(':');
    if (colon == std::string::npos) continue;
    const auto from = line.find_first_not_of(" \t", colon + 1);
    return from == std::string::npos ? std::string() : line.substr(from);
  }
  return {};
}

}  // namespace

std::vector<Fact> environment_facts() {
  std::vector<Fact> facts{{"program", fmt::format("gantry {} ({})", program_version(), program_commit())}};
  utsname u{};
  if (uname(&u) == 0) {
    facts.push_back({"host", u.nodename});
    facts.push_back({"kernel", fmt::format("{} {} {}", u.sysname, u.release, u.machine)});
    const bool preempt_rt = std::string_view(u.version).find("PREEMPT_RT") != std::string_view::npos;
    facts.push_back({"preemption", preempt_rt ? "PREEMPT_RT" : "no PREEMPT_RT kernel"});
  }
  if (auto cpu = proc_value("/proc/cpuinfo", "model name"); !cpu.empty())
    facts.push_back({"processor", fmt::format("{} x {}", std::thread::hardware_concurrency(), cpu)});
  if (auto memory = proc_value("/proc/meminfo", "MemTotal"); !memory.empty()) facts.push_back({"memory", memory});
  return facts;
}

}  // namespace gantry::record
