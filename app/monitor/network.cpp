#include "app/monitor/network.hpp"

#include <algorithm>
#include <arpa/inet.h>
#include <cctype>
#include <fmt/format.h>
#include <net/if.h>

namespace gantry::monitor {
namespace {

constexpr std::size_t kMostPeers = 32;    // each is asked at 33 ports once a second
constexpr std::size_t kLongestName = 31;  // as in idl/gantry_topics.idl

bool is_interface_name(const std::string& name) {
  return name.size() < IFNAMSIZ && std::all_of(name.begin(), name.end(), [](unsigned char c) {
           return std::isalnum(c) || c == '-' || c == '_' || c == '.' || c == '@';
         });
}

Result<void> check_peer(const std::string& peer, bool loopback_only) {
  in_addr address{};
  if (inet_pton(AF_INET, peer.c_str(), &address) != 1)
    return fail(Fault::Usage, fmt::format("'{}' is no IPv4 address; write --peer 10.0.2.2", peer), "--peer");
  const auto first = ntohl(address.s_addr) >> 24;
  if (first == 0 || first >= 224)
    return fail(Fault::Usage, fmt::format("{} is not the address of one computer", peer), "--peer");
  if (loopback_only && first != 127)
    return fail(Fault::Usage,
                fmt::format("{} cannot be reached from this computer alone; name the network that leads there: "
                            "--interface IF",
                            peer),
                "--peer");
  return {};
}

}  // namespace

Result<void> check(const NetworkOptions& options) {
  if (options.domain < 0 || options.domain > 230)
    return fail(Fault::Usage, fmt::format("DDS domain {} is out of range; use 0 .. 230", options.domain), "--domain");
  if (!is_interface_name(options.interface))
    return fail(Fault::Usage, "'" + options.interface + "' is no name of a network interface; see `ip link`",
                "--interface");
  if (if_nametoindex(options.device().c_str()) == 0)
    return fail(Fault::Usage, "there is no network interface '" + options.device() + "'; see `ip link`", "--interface");
  if (options.peers.size() > kMostPeers)
    return fail(Fault::Usage, fmt::format("{} peers are too many; {} are asked", options.peers.size(), kMostPeers),
                "--peer");
  for (const std::string& peer : options.peers)
    if (auto fits = check_peer(peer, options.device() == "lo"); !fits) return fits;
  return {};
}

Result<void> check_name(const std::string& name) {
  const bool plain = std::none_of(name.begin(), name.end(), [](unsigned char c) { return c < 0x20 || c == 0x7F; });
  if (name.empty() || name.size() > kLongestName || !plain)
    return fail(Fault::Usage, fmt::format("a machine's name has 1 to {} bytes and no control characters", kLongestName),
                "--name");
  return {};
}

std::vector<std::string> words(const NetworkOptions& options) {
  std::vector<std::string> list{"--domain", std::to_string(options.domain)};
  if (!options.interface.empty()) list.insert(list.end(), {"--interface", options.interface});
  for (const std::string& peer : options.peers) list.insert(list.end(), {"--peer", peer});
  return list;
}

}  // namespace gantry::monitor
