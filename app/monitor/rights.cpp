#include "app/monitor/rights.hpp"

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fmt/format.h>
#include <grp.h>
#include <iterator>
#include <linux/capability.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <system_error>
#include <unistd.h>

namespace gantry::monitor {
namespace {

tl::unexpected<Error> left(const char* what) {
  return fail(Fault::DdsUnusable, fmt::format("the publisher does not run with more rights than it needs, and {} "
                                              "cannot be given up: {}",
                                              what, std::strerror(errno)));
}

/// Only who has CAP_SETPCAP may; without new privileges an ordinary user's full set gives nothing.
void empty_bounding_set() {
  for (int capability = 0; prctl(PR_CAPBSET_READ, capability, 0, 0, 0) >= 0; ++capability)
    prctl(PR_CAPBSET_DROP, capability, 0, 0, 0);
}

bool drop_capabilities() {
  __user_cap_header_struct header{_LINUX_CAPABILITY_VERSION_3, 0};
  const __user_cap_data_struct none[_LINUX_CAPABILITY_U32S_3]{};
  prctl(PR_CAP_AMBIENT, PR_CAP_AMBIENT_CLEAR_ALL, 0, 0, 0);
  return syscall(SYS_capset, &header, none) == 0;
}

bool has_capabilities() {
  __user_cap_header_struct header{_LINUX_CAPABILITY_VERSION_3, 0};
  __user_cap_data_struct has[_LINUX_CAPABILITY_U32S_3]{};
  if (syscall(SYS_capget, &header, has) != 0) return true;
  for (const auto& word : has)
    if ((word.effective | word.permitted | word.inheritable) != 0) return true;
  return false;
}

}  // namespace

Result<void> give_up_rights() try {
  namespace fs = std::filesystem;
  const auto threads = std::distance(fs::directory_iterator("/proc/self/task"), fs::directory_iterator());
  if (threads != 1)
    return fail(Fault::DdsUnusable, "rights are given up thread by thread: too late, others run already");
  if (prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) != 0) return left("new privileges");
  empty_bounding_set();
  if (geteuid() == 0 || getuid() == 0) {
    if (setgroups(0, nullptr) != 0) return left("root's groups");
    if (setresgid(kNobody, kNobody, kNobody) != 0) return left("root's group");
    if (setresuid(kNobody, kNobody, kNobody) != 0) return left("root's user");
  }
  if (!drop_capabilities() || has_capabilities()) return left("capabilities");
  return {};
} catch (const std::system_error& error) {
  return fail(Fault::DdsUnusable, fmt::format("the publisher's threads cannot be counted: {}", error.what()));
}

}  // namespace gantry::monitor
