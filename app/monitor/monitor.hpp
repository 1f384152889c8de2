// `gantry monitor`: what a machine tells over DDS, shown in the terminal or written as JSON lines. Only listens.
//   monitor({.json = true, .count = 10}, std::cout, stop);
#pragma once
#include <atomic>
#include <cstdint>
#include <functional>
#include <iosfwd>
#include <string>

#include "app/monitor/dds.hpp"
#include "core/error.hpp"

namespace gantry::monitor {

struct MonitorOptions {
  NetworkOptions network;
  std::string machine;                             ///< listen to this one only; empty: all
  bool json = false;                               ///< one line a sample
  bool live = false;                               ///< redraw in place, in colour: only where `out` is a terminal
  std::uint64_t count = 0;                         ///< end after so many samples; 0: go on
  double for_s = 0;                                ///< end after so long; 0: go on
  double silence_s = 3;                            ///< say so when nothing was heard for so long
  std::function<void(const std::string&)> notice;  ///< "no machine heard ..."; empty: to the log (stderr)
};

/// Fault::NoMachineHeard when it ends without having heard anything, Fault::DdsUnusable.
Result<void> monitor(const MonitorOptions& options, std::ostream& out, const std::atomic<bool>& stop);

}  // namespace gantry::monitor
