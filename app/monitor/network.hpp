// How far DDS reaches: the options of `publish`, `monitor` and of the owner that starts a publisher. No DDS in it.
//   check(options);   auto arguments = words(options);      // "--domain", "3", "--interface", "eth0", ...
#pragma once
#include <string>
#include <vector>

#include "core/error.hpp"

namespace gantry::monitor {

struct NetworkOptions {
  int domain = 0;                  ///< 0 .. 230
  std::string interface;           ///< "eth0": this network; empty: this computer alone
  std::vector<std::string> peers;  ///< "10.0.2.2": asked for by address, where multicast does not reach

  /// The device that every socket is bound to.
  [[nodiscard]] std::string device() const { return interface.empty() ? "lo" : interface; }
};

/// Fault::Usage for a domain, an interface or a peer that cannot be.
Result<void> check(const NetworkOptions& options);
/// The same for a machine's name: 1 to 31 bytes, none that steers a terminal.
Result<void> check_name(const std::string& name);
/// The options as arguments of a command line.
std::vector<std::string> words(const NetworkOptions& options);

}  // namespace gantry::monitor
