// What the publisher may do and who reaches it. The judges are ss, /proc and the kernel, not the program.
#include <arpa/inet.h>
#include <cstddef>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <linux/filter.h>
#include <linux/seccomp.h>
#include <map>
#include <net/if.h>
#include <sched.h>
#include <string_view>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include "app/monitor/dds.hpp"
#include "app/monitor/device_sockets.hpp"
#include "tests/app/monitor/over_dds.hpp"

namespace gantry::monitor {
namespace {

/// An interface beside lo, or none that exists.
std::string other_interface() {
  struct if_nameindex* all = if_nameindex();
  std::string found = "none";
  for (const auto* each = all; each != nullptr && each->if_index != 0 && found == "none"; ++each)
    if (std::string_view(each->if_name) != "lo") found = each->if_name;
  if (all != nullptr) if_freenameindex(all);
  return found;
}

/// What ss (iproute2), not the program, says of a process's UDP sockets: "127.0.0.1%lo:7410", ...
std::vector<std::string> udp_sockets(pid_t pid) {
  std::vector<std::string> sockets;
  FILE* ss = popen("ss -uanpH", "r");
  if (ss == nullptr) return sockets;
  char line[4096];
  while (fgets(line, sizeof line, ss) != nullptr) {
    if (std::string(line).find("pid=" + std::to_string(pid) + ",") == std::string::npos) continue;
    std::istringstream columns(line);
    std::string state, received, sent, local;
    columns >> state >> received >> sent >> local;
    sockets.push_back(local);
  }
  pclose(ss);
  return sockets;
}

TEST(Confinement, publisher_and_monitor_listen_on_the_loopback_device_alone) {
  setenv("CYCLONEDDS_URI",
         "<CycloneDDS><Domain><General><AllowMulticast>true</AllowMulticast></General></Domain></CycloneDDS>",
         1);  // is not followed
  Owner owner;
  ASSERT_EQ(heard(listening(1)).size(), 1u);
  unsetenv("CYCLONEDDS_URI");
  auto participant = dds::Participant::open({.domain = own_domain(), .interface = "", .peers = {}});
  ASSERT_TRUE(participant);
  for (const pid_t process : {owner.publisher.load(), getpid()}) {
    const auto sockets = udp_sockets(process);
    EXPECT_GE(sockets.size(), 2u);
    for (const auto& s : sockets) EXPECT_NE(s.find("%lo:"), std::string::npos) << s;
  }
  const auto second = dds::Participant::open({.domain = own_domain(), .interface = other_interface(), .peers = {}});
  ASSERT_FALSE(second) << "one process, one device";
}

TEST(DeviceSockets, a_socket_that_is_open_to_all_is_found) {
  ASSERT_TRUE(confine_sockets("lo"));
  EXPECT_TRUE(check_sockets("lo"));
  const auto open = static_cast<int>(syscall(SYS_socket, AF_INET, SOCK_DGRAM, 0));  // past our socket()
  ASSERT_GE(open, 0);
  const auto found = check_sockets("lo");
  close(open);
  ASSERT_FALSE(found);
  EXPECT_EQ(found.error().fault, Fault::DdsUnusable);
  EXPECT_TRUE(check_sockets("lo"));
  const int local = socket(AF_UNIX, SOCK_STREAM, 0);
  EXPECT_GE(local, 0) << "others than network sockets are not touched";
  EXPECT_TRUE(check_sockets("lo"));
  close(local);
}

/// From here on this process and what it starts cannot bind a socket to a device: EPERM, as on Linux before 5.7.
bool forbid_binding_to_a_device() {
  constexpr auto kNumber = offsetof(seccomp_data, nr), kOption = offsetof(seccomp_data, args[2]);
  sock_filter program[] = {
      BPF_STMT(BPF_LD | BPF_W | BPF_ABS, kNumber),          BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, SYS_setsockopt, 0, 3),
      BPF_STMT(BPF_LD | BPF_W | BPF_ABS, kOption),          BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, SO_BINDTODEVICE, 0, 1),
      BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ERRNO | EPERM), BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ALLOW),
  };
  const sock_fprog filter{static_cast<unsigned short>(std::size(program)), program};
  return prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) == 0 && prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &filter) == 0;
}

std::string file_text(const std::string& path) {
  std::ifstream in(path);
  return {std::istreambuf_iterator<char>(in), {}};
}

TEST(Confinement, a_publisher_that_cannot_be_confined_does_not_run) {
  auto writer = SnapshotWriter::create(bench_machine());
  ASSERT_TRUE(writer);
  std::string said = "/tmp/gantry-said-XXXXXX";
  const int said_fd = mkstemp(said.data());
  ASSERT_GE(said_fd, 0);
  const pid_t publisher = fork();
  ASSERT_GE(publisher, 0);
  if (publisher == 0) {
    dup2(said_fd, STDERR_FILENO);
    const int memory = dup(writer->fd());  // inherited
    if (memory < 0 || !forbid_binding_to_a_device()) _exit(77);
    const auto number = std::to_string(memory), domain = std::to_string(own_domain());
    execl(PUBLISH_TOOL, "publish_tool", "publish", "--shm", number.c_str(), "--domain", domain.c_str(), nullptr);
    _exit(78);
  }
  int status = 0;
  ASSERT_EQ(waitpid(publisher, &status, 0), publisher) << "it must end by itself";
  const auto text = file_text(said);
  close(said_fd), unlink(said.c_str());
  ASSERT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 1);
  EXPECT_NE(text.find("bound to the device 'lo' (Operation not permitted)"), std::string::npos) << text;
  EXPECT_NE(text.find("CAP_NET_RAW"), std::string::npos) << text;
}

std::map<std::string, std::string> status_of(const std::filesystem::path& task) {
  std::map<std::string, std::string> status;
  std::ifstream in(task / "status");
  for (std::string line; std::getline(in, line);) {
    const auto colon = line.find(':');
    std::istringstream words(line.substr(colon + 1));
    std::string value;
    for (std::string word; words >> word;) value += (value.empty() ? "" : " ") + word;
    status[line.substr(0, colon)] = value;
  }
  return status;
}

TEST(Confinement, the_publisher_has_no_rights_that_it_does_not_need) {
  Owner owner;
  ASSERT_EQ(heard(listening(1)).size(), 1u);
  const auto process = std::filesystem::path("/proc") / std::to_string(owner.publisher);
  int threads = 0;
  for (const auto& task : std::filesystem::directory_iterator(process / "task")) {
    auto status = status_of(task);
    if (status.empty()) continue;  // has ended
    ++threads;
    for (const char* set : {"CapInh", "CapPrm", "CapEff", "CapAmb"}) EXPECT_EQ(status[set], "0000000000000000") << set;
    EXPECT_EQ(status["NoNewPrivs"], "1");
    if (geteuid() == 0) {
      EXPECT_EQ(status["CapBnd"], "0000000000000000");
      EXPECT_EQ(status["Uid"], "65534 65534 65534 65534");
      EXPECT_EQ(status["Gid"], "65534 65534 65534 65534");
      EXPECT_EQ(status["Groups"], "");
    }
    const auto tid = std::stoi(task.path().filename());
    EXPECT_EQ(sched_getscheduler(tid), SCHED_OTHER);
    EXPECT_EQ(getpriority(PRIO_PROCESS, static_cast<id_t>(tid)), getpriority(PRIO_PROCESS, 0));
  }
  EXPECT_GE(threads, 3) << "those of DDS too";
  if (geteuid() != 0) return;  // only root may look at the files of a process that gave its rights up
  for (const auto& entry : std::filesystem::directory_iterator(process / "fd")) {
    const auto file = std::filesystem::read_symlink(entry).string();
    EXPECT_EQ(file.find("memfd"), std::string::npos) << "mapped, and closed";
    const auto own = [](int fd) {
      return std::filesystem::read_symlink("/proc/self/fd/" + std::to_string(fd)).string();
    };
    const bool expected = file == "/dev/null" || file == own(STDERR_FILENO) || file.starts_with("socket:") ||
                          file.starts_with("pipe:") || file.starts_with("anon_inode:");
    EXPECT_TRUE(expected) << file;
  }
}

/// stderr of this process, and of what it starts, in a file while it lives.
class StderrInFile {
 public:
  StderrInFile() : saved_(dup(STDERR_FILENO)), file_(mkstemp(name_.data())) { dup2(file_, STDERR_FILENO); }
  ~StderrInFile() {
    restore();
    close(saved_), close(file_), unlink(name_.c_str());
  }
  void restore() const { dup2(saved_, STDERR_FILENO); }
  [[nodiscard]] std::string text() const { return file_text(name_); }

 private:
  std::string name_ = "/tmp/gantry-log-XXXXXX";
  int saved_, file_;
};

// R93: whoever may send to the publisher makes DDS warn of every packet (here 40000 of them, 9 MB of log).
TEST(Confinement, a_flood_of_malformed_packets_leaves_a_bounded_log) {
  StderrInFile log;
  Owner owner;
  EXPECT_EQ(heard(listening(1)).size(), 1u);
  log.restore();
  const pid_t publisher = owner.publisher;
  std::vector<sockaddr_in> ports;
  for (const auto& s : udp_sockets(publisher)) {
    sockaddr_in to{};
    to.sin_family = AF_INET;
    to.sin_port = htons(static_cast<std::uint16_t>(std::stoi(s.substr(s.rfind(':') + 1))));
    to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    ports.push_back(to);
  }
  ASSERT_FALSE(ports.empty());
  const int sender = socket(AF_INET, SOCK_DGRAM, 0);
  ASSERT_GE(sender, 0);
  // An RTPS header (DDSI-RTPS 2.5, 9.4.4) and a DATA submessage that is too short for its own fields.
  const unsigned char packet[] = {'R', 'T', 'P', 'S', 2,  1,  1,    16, 1, 2, 3, 4, 5, 6,
                                  7,   8,   9,   10,  11, 12, 0x15, 5,  4, 0, 1, 2, 3, 4};
  for (int i = 0; i < 40'000; ++i) {
    const auto& to = ports[static_cast<std::size_t>(i) % ports.size()];
    sendto(sender, packet, sizeof packet, 0, reinterpret_cast<const sockaddr*>(&to), sizeof to);
    if (i % 200 == 0) std::this_thread::sleep_for(milliseconds(1));
  }
  close(sender);
  EXPECT_EQ(heard(listening(5)).size(), 5u) << "it speaks on";
  EXPECT_EQ(owner.publisher, publisher);
  const auto text = log.text();
  EXPECT_NE(text.find("malformed packet"), std::string::npos) << "the flood did not arrive";
  EXPECT_LT(text.size(), 20'000u) << text.substr(0, 2000);
}

}  // namespace
}  // namespace gantry::monitor
