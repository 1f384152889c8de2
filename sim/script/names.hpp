// What a script names on the machine: stations, axes, drives, inputs, objects. A name that the machine does not have is
// a mistake at its location that tells the nearest one.
//   Names names(machine, mistakes);   const StationId station = names.station(entry.station);
#pragma once
#include "config/fields.hpp"
#include "config/machine.hpp"

namespace gantry::sim {

/// Each answers with something harmless when it has added a mistake, and when nothing was given.
class Names {
 public:
  Names(const config::Machine& machine, config::Mistakes& mistakes) : machine_(machine), mistakes_(mistakes) {}

  /// A station on the EtherCAT line; scripts reach no other bus.
  StationId station(const config::At<std::string>& name);
  /// An axis whose drives hang on that line.
  AxisId axis(const config::At<std::string>& name);
  /// A drive of the axis, counted from 0; 0 when none is given.
  int drive(AxisId axis, const config::At<int>& number);
  /// Bit of the input in the loop's word.
  unsigned input(const config::At<std::string>& name);
  /// The same of something that one presses: start, stop, reset, hold, or an input with a free name.
  unsigned button(const config::At<std::string>& name);
  /// An object that the station's profile lists.
  config::ObjectAddress object(StationId station, const config::At<config::ObjectAddress>& address);

 private:
  void unknown(std::string_view what, const config::At<std::string>& name, const std::vector<std::string_view>& known);

  const config::Machine& machine_;
  config::Mistakes& mistakes_;
};

}  // namespace gantry::sim
