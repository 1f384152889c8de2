#include "devices/packet_socket_owner.hpp"

#include <algorithm>
#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <sstream>
#include <unistd.h>
#include <vector>

namespace gantry::devices {
namespace {

namespace fs = std::filesystem;

/// As the links in /proc/PID/fd show them. Columns of /proc/net/packet: sk RefCnt Type Proto Iface R Rmem User Inode
/// (net/packet/af_packet.c, packet_seq_show).
std::vector<std::string> sockets_on(unsigned interface_index, std::uint16_t protocol) {
  std::vector<std::string> out;
  std::ifstream table("/proc/net/packet");
  std::string line;
  std::getline(table, line);
  while (std::getline(table, line)) {
    std::istringstream columns(line);
    std::string sk, references, type, proto, running, memory, user, inode;
    unsigned index = 0;
    if (columns >> sk >> references >> type >> proto >> index >> running >> memory >> user >> inode &&
        index == interface_index && proto == fmt::format("{:04x}", protocol))
      out.push_back("socket:[" + inode + "]");
  }
  return out;
}

bool has_one_of(const fs::path& process, const std::vector<std::string>& sockets) {
  std::error_code hidden;
  for (fs::directory_iterator fd(process / "fd", hidden), end; !hidden && fd != end; fd.increment(hidden)) {
    std::error_code closed;
    const std::string target = fs::read_symlink(fd->path(), closed).string();
    if (!closed && std::find(sockets.begin(), sockets.end(), target) != sockets.end()) return true;
  }
  return false;
}

}  // namespace

std::string packet_socket_owner(unsigned interface_index, std::uint16_t protocol) {
  const auto sockets = sockets_on(interface_index, protocol);
  const std::string self = std::to_string(getpid());
  std::error_code gone;
  for (fs::directory_iterator process("/proc", gone), end; !gone && process != end; process.increment(gone)) {
    const std::string id = process->path().filename().string();
    if (id.find_first_not_of("0123456789") != std::string::npos || id == self) continue;
    if (!has_one_of(process->path(), sockets)) continue;
    std::string name;
    std::getline(std::ifstream(process->path() / "comm"), name);
    return fmt::format("process {} ({})", id, name);
  }
  return {};
}

}  // namespace gantry::devices
