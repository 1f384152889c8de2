// What is wrong with a machine that a fault has stopped: what is latched, what else came since, and what is open now.
//   active.came(words);   active.see(snapshot);   for (const Error& e : active.list(machine, snapshot)) ...
#pragma once
#include <vector>

#include "app/cycle/channels.hpp"
#include "config/machine.hpp"
#include "core/error.hpp"

namespace gantry::stations {

class ActiveFaults {
 public:
  /// A fault that latches, in words.
  void came(const Error& words);
  /// In every snapshot: what is no longer latched is over, and with it what came since.
  void see(const cycle::Snapshot& s);
  /// The latched one first; empty while nothing is latched. Interlocks that are open count also where the loop had
  /// nothing left to do about them; one that is closed again, and waits for a reset only, says "not any more".
  [[nodiscard]] std::vector<Error> list(const config::Machine& machine, const cycle::Snapshot& s) const;

 private:
  Fault latched_ = Fault::None;
  std::vector<Error> since_;
};

}  // namespace gantry::stations
