#include <algorithm>
#include <arpa/inet.h>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <ifaddrs.h>
#include <net/if.h>
#include <set>
#include <sys/socket.h>
#include <unistd.h>

#include "app/cli/doctor.hpp"
#include "core/near_word.hpp"
#include "devices/interface_lock.hpp"

namespace gantry::cli {
namespace {

namespace fs = std::filesystem;
using Level = Finding::Level;

Finding raw_frames(Level when_missing) {
  const int fd = socket(AF_PACKET, SOCK_RAW | SOCK_CLOEXEC, 0);
  const int why = errno;
  if (fd >= 0) {
    close(fd);
    return {"raw frames", Level::Ok, "allowed", "", {}};
  }
  return {"raw frames", when_missing, fmt::format("a packet socket: {}", std::strerror(why)),
          "`sudo setcap cap_net_raw,cap_sys_nice,cap_ipc_lock+ep` on the program, or start `gantry up` by systemd with "
          "AmbientCapabilities=CAP_NET_RAW",
          Fault::InterfaceUnusable};
}

/// All of this computer's, but the one that leads to itself.
std::set<std::string> interfaces() {
  std::set<std::string> names;
  if (auto* all = if_nameindex(); all != nullptr) {
    for (const auto* each = all; each->if_index != 0; ++each)
      if (std::string_view(each->if_name) != "lo") names.insert(each->if_name);
    if_freenameindex(all);
  }
  return names;
}

struct LinkState {
  bool up = false, carrier = false;
  std::vector<std::string> addresses;  ///< IPv4
};
LinkState state_of_link(const std::string& interface) {
  LinkState state;
  ifaddrs* all = nullptr;
  if (getifaddrs(&all) != 0) return state;
  for (const ifaddrs* each = all; each != nullptr; each = each->ifa_next) {
    if (interface != each->ifa_name) continue;
    state.up |= (each->ifa_flags & IFF_UP) != 0;
    state.carrier |= (each->ifa_flags & IFF_RUNNING) != 0;
    if (each->ifa_addr == nullptr || each->ifa_addr->sa_family != AF_INET) continue;
    sockaddr_in address{};
    std::memcpy(&address, each->ifa_addr, sizeof address);
    char text[INET_ADDRSTRLEN] = "";
    inet_ntop(AF_INET, &address.sin_addr, text, sizeof text);
    state.addresses.emplace_back(text);
  }
  freeifaddrs(all);
  return state;
}

/// The words of a process's command line.
std::vector<std::string> command_of(const fs::path& process) {
  std::ifstream file(process / "cmdline", std::ios::binary);
  std::vector<std::string> words;
  for (std::string word; std::getline(file, word, '\0');) words.push_back(word);
  return words;
}

/// What --interface names of a `gantry publish`; "lo" where it names none; "" of any other process.
std::string publishes_on(const std::vector<std::string>& words) {
  const auto verb = std::find(words.begin(), words.end(), "publish");
  if (words.empty() || verb == words.end() || fs::path(words.front()).filename() != "gantry") return "";
  for (auto word = verb; word != words.end(); ++word) {
    if (*word == "--interface" && word + 1 != words.end()) return *(word + 1);
    if (word->starts_with("--interface=")) return word->substr(std::strlen("--interface="));
  }
  return "lo";
}

}  // namespace

Findings look_at_interface(const std::string& interface) {
  if (interface.empty()) return {raw_frames(Level::Warning)};
  const std::string name = "interface " + interface;
  const auto all = interfaces();
  if (interface != "lo" && !all.contains(interface))
    return {{name, Level::Error,
             fmt::format("there is no such interface; {}", did_you_mean(interface, {all.begin(), all.end()})),
             "name one that `ip link` shows", Fault::InterfaceUnusable},
            raw_frames(Level::Error)};
  Findings findings;
  const LinkState link = state_of_link(interface);
  if (!link.up)
    findings.push_back({name, Level::Error, "it is down", fmt::format("`sudo ip link set dev {} up`", interface),
                        Fault::InterfaceUnusable});
  else if (!link.carrier)
    findings.push_back({name, Level::Error, "it is up and has no carrier",
                        "plug the cable in at both ends, and switch the first station's supply on", Fault::BusDown});
  else
    findings.push_back({name, Level::Ok, "up, with carrier", "", {}});
  if (!link.addresses.empty())
    findings.push_back({"other traffic", Level::Warning,
                        fmt::format("{} has the address {}: other programs send there too", interface,
                                    fmt::join(link.addresses, ", ")),
                        fmt::format("take it away (`sudo ip address flush dev {}`) and let no network manager give it "
                                    "one: a bus has the line for itself",
                                    interface),
                        Fault::LateCycle});
  const Finding raw = raw_frames(Level::Error);
  findings.push_back(raw);
  if (raw.level != Level::Ok || !link.up) return findings;
  if (const auto lock = devices::InterfaceLock::take(interface); lock)
    findings.push_back({"owner of the bus", Level::Ok, "nobody else drives it", "", {}});
  else
    findings.push_back({"owner of the bus", Level::Error, lock.error().message,
                        std::string(info(lock.error().fault).remedy), lock.error().fault});
  return findings;
}

Findings look_at_dds() {
  std::set<std::string> open;
  std::size_t confined = 0;
  std::error_code ignored;
  for (fs::directory_iterator process("/proc", ignored), end; !ignored && process != end; process.increment(ignored)) {
    if (process->path().filename().string().find_first_not_of("0123456789") != std::string::npos) continue;
    const std::string interface = publishes_on(command_of(process->path()));
    if (interface == "lo")
      ++confined;
    else if (!interface.empty())
      open.insert(interface);
  }
  if (!open.empty())
    return {{"DDS", Level::Warning,
             fmt::format("a machine of this computer publishes on {}: whoever is on that network can listen, and can "
                         "invent machines",
                         fmt::join(open, ", ")),
             "leave --interface away from `gantry up` where only this computer monitors; else keep that network to "
             "machines",
             Fault::DdsUnusable}};
  const LinkState loopback = state_of_link("lo");
  if (!loopback.up)
    return {{"DDS", Level::Warning, "the loopback device is down, so that no monitor hears this computer's machines",
             "`sudo ip link set dev lo up`", Fault::DdsUnusable}};
  return {{"DDS",
           Level::Ok,
           fmt::format("heard by this computer alone, unless --interface says otherwise ({} machines publish now)",
                       confined),
           "",
           {}}};
}

}  // namespace gantry::cli
