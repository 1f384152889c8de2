// gantry bus: the verbs that look at a segment.
#include "app/cli/bus_access.hpp"

namespace gantry::cli {

void add_bus(CLI::App& app, Context& context) {
  auto* bus =
      app.add_subcommand("bus", "Looks at an EtherCAT segment, real or virtual: stations, objects, errors, clocks");
  bus->require_subcommand(1);
  bus->footer(
      "STATION is a position (0 is the first), alias:NNN, or a name of the machine file.\n"
      "Not beside a running controller: the bus has one owner.\n"
      "Example:  gantry bus scan\n"
      "          gantry bus sdo read x 0x6064 --interface eth1");
  add_bus_scan(*bus, context);
  add_bus_sdo(*bus, context);
  add_bus_errors(*bus, context);
  add_bus_dc(*bus, context);
  add_bus_capture(*bus, context);
}

}  // namespace gantry::cli
