#include "app/cycle/loop_cpu.hpp"

#include <fmt/format.h>
#include <string>

namespace gantry::cycle {
namespace {

std::string list(const cpu_set_t& set) {
  std::string text;
  for (int i = 0; i < CPU_SETSIZE; ++i)
    if (CPU_ISSET(i, &set)) text += fmt::format("{}{}", text.empty() ? "" : ", ", i);
  return text;
}

cpu_set_t allowed_here() {
  cpu_set_t allowed;
  if (sched_getaffinity(0, sizeof allowed, &allowed) != 0) CPU_ZERO(&allowed);
  return allowed;
}

}  // namespace

Result<void> LoopCpu::check(std::optional<int> wanted) {
  const cpu_set_t allowed = allowed_here();
  if (!wanted || (*wanted >= 0 && *wanted < CPU_SETSIZE && CPU_ISSET(*wanted, &allowed))) return {};
  return fail(Fault::Usage,
              fmt::format("CPU {} is none of those that this program may use ({})", *wanted, list(allowed)),
              "--loop-cpu");
}

Result<std::unique_ptr<LoopCpu>> LoopCpu::take(std::optional<int> wanted) {
  if (auto usable = check(wanted); !usable) return tl::unexpected(usable.error());
  const cpu_set_t allowed = allowed_here();
  int number = kAny;
  if (CPU_COUNT(&allowed) > 1) {
    for (int i = 0; i < CPU_SETSIZE; ++i)
      if (CPU_ISSET(i, &allowed)) number = i;
    number = wanted.value_or(number);
    cpu_set_t others = allowed;
    CPU_CLR(number, &others);
    if (sched_setaffinity(0, sizeof others, &others) != 0) number = kAny;
  }
  return std::unique_ptr<LoopCpu>(new LoopCpu(number, allowed));
}

LoopCpu::~LoopCpu() {
  if (number_ != kAny) sched_setaffinity(0, sizeof before_, &before_);
}

}  // namespace gantry::cycle
