#include <cerrno>
#include <cstring>
#include <ctime>
#include <fmt/format.h>
#include <fstream>
#include <grp.h>
#include <pwd.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/utsname.h>
#include <sys/wait.h>
#include <unistd.h>

#include "app/cli/doctor.hpp"
#include "app/cycle/watchdog.hpp"

namespace gantry::cli {
namespace {

using Level = Finding::Level;

/// Tries it in a process of its own, whose rights end with it. The errno, or 0.
int errno_of(int (*attempt)()) {
  const pid_t child = fork();
  if (child < 0) return errno;
  if (child == 0) _exit(attempt());
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  return WIFEXITED(status) ? WEXITSTATUS(status) : EFAULT;
}

int try_priority() {
  const sched_param parameter{.sched_priority = cycle::kWatchdogPriority};
  return sched_setscheduler(0, SCHED_FIFO, &parameter) == 0 ? 0 : errno;
}
int try_lock() { return mlockall(MCL_CURRENT | MCL_FUTURE) == 0 ? 0 : errno; }

std::string first_line(const char* path) {
  std::string line;
  std::getline(std::ifstream(path), line);
  return line;
}

std::string user() {
  const passwd* const entry = getpwuid(getuid());
  return entry != nullptr ? entry->pw_name : std::to_string(getuid());
}

/// For people who log in, and for a service.
std::string how_to_allow(std::string_view limit, std::string_view capability) {
  const group* const members = getgrnam("gantry");
  if (members != nullptr && ::access("/etc/security/limits.d/gantry.conf", R_OK) == 0) {
    for (char** name = members->gr_mem; *name != nullptr; ++name)
      if (user() == *name)
        return fmt::format("log in again: {} is in the group `gantry`, and this session began without its limits",
                           user());
    return fmt::format("`adduser {} gantry`, and log in again", user());
  }
  return fmt::format(
      "write the line `{} - {}` into /etc/security/limits.d/gantry.conf and log in again; a service of systemd gets it "
      "by AmbientCapabilities={}",
      user(), limit, capability);
}

Finding priority(Level when_missing) {
  const int why = errno_of(try_priority);
  if (why == 0)
    return {"real-time priority", Level::Ok, fmt::format("SCHED_FIFO {} is allowed", cycle::kWatchdogPriority), "", {}};
  return {"real-time priority", when_missing,
          fmt::format("SCHED_FIFO {}: {}", cycle::kWatchdogPriority, std::strerror(why)),
          how_to_allow("rtprio 90", "CAP_SYS_NICE"), Fault::RealTimeRefused};
}

Finding memory(Level when_missing) {
  const int why = errno_of(try_lock);
  if (why == 0) return {"locked memory", Level::Ok, "mlockall is allowed", "", {}};
  return {"locked memory", when_missing, fmt::format("mlockall: {}", std::strerror(why)),
          how_to_allow("memlock unlimited", "CAP_IPC_LOCK"), Fault::RealTimeRefused};
}

Finding timer(Level when_missing) {
  timespec resolution{};
  clock_getres(CLOCK_MONOTONIC, &resolution);
  const long ns = resolution.tv_sec * 1'000'000'000L + resolution.tv_nsec;
  const std::string source = first_line("/sys/devices/system/clocksource/clocksource0/current_clocksource");
  const std::string text = fmt::format("{} ns, clock source {}", ns, source.empty() ? "not told" : source);
  if (ns > 1000)
    return {"timer", when_missing, text, "use a kernel with CONFIG_HIGH_RES_TIMERS and without highres=off",
            Fault::LateCycles};
  if (source == "acpi_pm" || source == "hpet" || source == "jiffies")
    return {"timer", Level::Warning, text + ", which is slow to read",
            "look into `dmesg` why tsc was given up; tsc=reliable on the kernel's command line keeps it",
            Fault::LateCycles};
  return {"timer", Level::Ok, text, "", {}};
}

Finding kernel(bool hardware) {
  utsname name{};
  uname(&name);
  const std::string text = fmt::format("{} {}", name.release, name.version);
  if (text.find("PREEMPT_RT") != std::string::npos || first_line("/sys/kernel/realtime") == "1")
    return {"kernel", Level::Ok, text, "", {}};
  if (!hardware)
    return {"kernel", Level::Ok, text + "; not a real-time one, which a simulated machine can do without", "", {}};
  return {"kernel", Level::Warning, text + ": not a real-time one, so that a cycle may be late",
          "`sudo apt install linux-image-rt-amd64`, and start that kernel", Fault::LateCycles};
}

Finding processors(Level when_missing) {
  cpu_set_t allowed;
  CPU_ZERO(&allowed);
  const int count = sched_getaffinity(0, sizeof allowed, &allowed) == 0 ? CPU_COUNT(&allowed) : 1;
  const std::string isolated = first_line("/sys/devices/system/cpu/isolated");
  const std::string text = fmt::format("{} may be used, isolated: {}", count, isolated.empty() ? "none" : isolated);
  if (count < 2)
    return {"CPUs", when_missing, text + ": the 1 ms loop shares its CPU with everything else",
            "give this computer a second CPU", Fault::LateCycles};
  return {"CPUs", Level::Ok, text, "", {}};
}

}  // namespace

Findings look_at_real_time(bool hardware) {
  const Level missing = hardware ? Level::Error : Level::Warning;
  return {priority(missing), memory(missing), timer(missing), kernel(hardware), processors(Level::Warning)};
}

}  // namespace gantry::cli
