// For tests of whole programs on a cable: a `gantry` in a process of its own, an ear on the wire, a hand that stops one
// of its threads, and a voice that reads stations when no controller is left.
#pragma once
#include <array>
#include <chrono>
#include <csignal>
#include <cstring>
#include <fcntl.h>
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <linux/if_packet.h>
#include <net/if.h>
#include <optional>
#include <poll.h>
#include <sstream>
#include <string>
#include <sys/ptrace.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>
#include <vector>

#include "tests/app/cycle/wire_judge.hpp"

namespace gantry::test {

inline constexpr double kPatience_s = 60;  // for what must come

inline double now_s() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

/// A `gantry` with its output in a file.
class Program {
 public:
  Program(const char* path, const std::vector<std::string>& words, std::string output) : output_(std::move(output)) {
    std::vector<char*> argv{const_cast<char*>("gantry")};
    for (const std::string& w : words) argv.push_back(const_cast<char*>(w.c_str()));
    argv.push_back(nullptr);
    const int file = open(output_.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
    pid_ = fork();
    if (pid_ != 0) {
      close(file);
      return;
    }
    dup2(open("/dev/null", O_RDONLY), STDIN_FILENO);
    dup2(file, STDOUT_FILENO);
    dup2(file, STDERR_FILENO);
    execv(path, argv.data());
    _exit(127);
  }
  ~Program() {
    if (ended_) return;
    kill(pid_, SIGKILL);
    waitpid(pid_, nullptr, 0);
  }
  Program(const Program&) = delete;
  Program& operator=(const Program&) = delete;

  [[nodiscard]] pid_t pid() const { return pid_; }
  [[nodiscard]] bool running() {
    if (!ended_) ended_ = waitpid(pid_, &status_, WNOHANG) == pid_;
    return !ended_;
  }
  /// As waitpid() has it; -1 when it does not end.
  int wait() {
    for (const double until = now_s() + kPatience_s; running() && now_s() < until;) usleep(1000);
    return ended_ ? status_ : -1;
  }
  [[nodiscard]] std::string output() const {
    std::ostringstream text;
    text << std::ifstream(output_).rdbuf();
    return text.str();
  }

 private:
  std::string output_;
  pid_t pid_ = -1;
  bool ended_ = false;
  int status_ = 0;
};

inline int packet_socket(const char* interface) {
  const int fd = socket(AF_PACKET, SOCK_RAW | SOCK_CLOEXEC, 0xA488);  // EtherCAT, in network order
  sockaddr_ll address{};
  address.sll_family = AF_PACKET;
  address.sll_protocol = 0xA488;
  address.sll_ifindex = static_cast<int>(if_nametoindex(interface));
  EXPECT_EQ(bind(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
  return fd;
}

/// What the controller says, overheard at the far end of the cable.
struct Heard {
  double at_s = 0;  ///< the kernel's stamp
  WireImage image;
};

class Listener {
 public:
  explicit Listener(const char* interface) : fd_(packet_socket(interface)) {
    const int on = 1, room = 16 << 20;
    setsockopt(fd_, SOL_PACKET, PACKET_IGNORE_OUTGOING, &on, sizeof on);
    setsockopt(fd_, SOL_SOCKET, SO_TIMESTAMPNS, &on, sizeof on);
    setsockopt(fd_, SOL_SOCKET, SO_RCVBUFFORCE, &room, sizeof room);
  }
  ~Listener() { close(fd_); }
  Listener(const Listener&) = delete;
  Listener& operator=(const Listener&) = delete;

  /// The next cyclic frame; nothing when there is none for `patience_s`.
  std::optional<Heard> next(double patience_s) {
    for (const double until = now_s() + patience_s;;) {
      pollfd p{fd_, POLLIN, 0};
      const double left_s = until - now_s();
      if (left_s <= 0 || poll(&p, 1, static_cast<int>(1e3 * left_s) + 1) <= 0) return std::nullopt;
      std::array<std::byte, 2000> frame{};
      std::array<char, 256> control{};
      iovec piece{frame.data(), frame.size()};
      msghdr message{};
      message.msg_iov = &piece, message.msg_iovlen = 1;
      message.msg_control = control.data(), message.msg_controllen = control.size();
      const ssize_t got = recvmsg(fd_, &message, 0);
      if (got <= 0) continue;
      const auto image = decode_cyclic(std::span(frame).first(static_cast<std::size_t>(got)));
      if (!image) continue;
      timespec stamp{};
      for (cmsghdr* c = CMSG_FIRSTHDR(&message); c != nullptr; c = CMSG_NXTHDR(&message, c))
        if (c->cmsg_type == SO_TIMESTAMPNS) std::memcpy(&stamp, CMSG_DATA(c), sizeof stamp);
      return Heard{static_cast<double>(stamp.tv_sec) + 1e-9 * static_cast<double>(stamp.tv_nsec), *image};
    }
  }
  /// All that comes until it has been silent for `silence_s`.
  std::vector<Heard> rest(double silence_s) {
    std::vector<Heard> all;
    while (const auto heard = next(silence_s)) all.push_back(*heard);
    return all;
  }

 private:
  int fd_;
};

/// Reads registers and memory of stations by bare datagrams, once the controller is gone.
class BareBus {
 public:
  explicit BareBus(const char* interface) : fd_(packet_socket(interface)) {
    const int on = 1;
    setsockopt(fd_, SOL_PACKET, PACKET_IGNORE_OUTGOING, &on, sizeof on);
  }
  ~BareBus() { close(fd_); }
  BareBus(const BareBus&) = delete;
  BareBus& operator=(const BareBus&) = delete;

  /// FPRD of two bytes; the master gives station addresses from 1001h on.
  int read(int position, unsigned at) {
    constexpr std::uint8_t kFprd = 4;
    std::array<std::uint8_t, 60> frame{0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0x02, 0,
                                       0,    0,    0,    0x77, 0x88, 0xA4, 14,   0x10};
    const unsigned station = 0x1001u + static_cast<unsigned>(position);
    const std::uint8_t header[] = {kFprd,
                                   ++index_,
                                   static_cast<std::uint8_t>(station),
                                   static_cast<std::uint8_t>(station >> 8),
                                   static_cast<std::uint8_t>(at),
                                   static_cast<std::uint8_t>(at >> 8),
                                   2,
                                   0,
                                   0,
                                   0};
    std::copy(std::begin(header), std::end(header), frame.begin() + 16);
    for (int attempt = 0; attempt < 20; ++attempt) {
      if (::send(fd_, frame.data(), frame.size(), 0) < 0) return -1;
      pollfd p{fd_, POLLIN, 0};
      while (poll(&p, 1, 500) > 0) {
        std::array<std::uint8_t, 2000> back{};
        if (recv(fd_, back.data(), back.size(), 0) < 30 || back[16] != kFprd || back[17] != index_ || back[11] != 0x77)
          continue;
        return back[28] == 1 ? back[26] | back[27] << 8 : -1;
      }
    }
    return -1;
  }
  /// Statusword: the first object of each axis' inputs, 19 bytes an axis; SyncManager 3 says where they lie.
  int statusword(int position, int slot = 0) {
    constexpr unsigned kSm3Start = 0x0818;
    const int inputs = read(position, kSm3Start);
    return inputs < 0 ? -1 : read(position, static_cast<unsigned>(inputs + 19 * slot));
  }

 private:
  int fd_;
  std::uint8_t index_ = 0;
};

/// Stops one thread of another process, as a debugger would: the rest of it runs on.
class Frozen {
 public:
  Frozen(pid_t process, const std::string& name) {
    const std::string tasks = "/proc/" + std::to_string(process) + "/task";
    for (const auto& task : std::filesystem::directory_iterator(tasks)) {
      std::string comm;
      std::getline(std::ifstream(task.path() / "comm"), comm);
      if (comm == name) thread_ = std::stoi(task.path().filename());
    }
    seized_ = thread_ > 0 && ptrace(PTRACE_SEIZE, thread_, nullptr, nullptr) == 0;
    if (seized_) ptrace(PTRACE_INTERRUPT, thread_, nullptr, nullptr), waitpid(thread_, nullptr, __WALL);
  }
  ~Frozen() { thaw(); }
  Frozen(const Frozen&) = delete;
  Frozen& operator=(const Frozen&) = delete;
  void thaw() {
    if (seized_) ptrace(PTRACE_DETACH, thread_, nullptr, nullptr);
    seized_ = false;
  }
  /// A stopped thread whose process ends waits for its tracer to see it.
  void see_it_end() {
    if (seized_) waitpid(thread_, nullptr, __WALL);
    seized_ = false;
  }
  [[nodiscard]] bool holds() const { return seized_; }

 private:
  pid_t thread_ = 0;
  bool seized_ = false;
};

}  // namespace gantry::test
