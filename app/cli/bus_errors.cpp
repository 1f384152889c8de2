// gantry bus errors: what the stations have counted at their ports; where a count grows, the cable in front is bad.
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "app/cli/bus_access.hpp"

namespace gantry::cli {

void add_bus_errors(CLI::App& bus, Context& context) {
  auto* verb = bus.add_subcommand("errors", "Error counters of every port: bad frames, lost links");
  auto options = std::make_shared<BusOptions>();
  add_bus_interface(*verb, *options);
  verb->footer(
      "invalid: frames with a wrong checksum; rx: symbols that are none; forwarded: errors that a station in front "
      "has\n"
      "seen already; lost: the link went away. Counters stop at 255. Look first at the port where `invalid` grows and\n"
      "`forwarded` does not: its cable or connector is the cause.");
  verb->callback([&context, options] {
    const auto access = BusAccess::open(context, *options);
    if (!access) return;
    devices::Survey survey(access->port(), access->clock());
    const auto stations = survey.scan();
    if (!stations) return void(context.exit_code = show(stations.error(), context.json));
    const auto counters = survey.error_counters();
    if (!counters) return void(context.exit_code = show(counters.error(), context.json));

    nlohmann::ordered_json all = nlohmann::json::array();
    if (!context.json)
      fmt::print("{:<18} {:>4} {:>8} {:>4} {:>10} {:>5}\n", "station", "port", "invalid", "rx", "forwarded", "lost");
    for (std::size_t i = 0; i < counters->size(); ++i) {
      const auto& s = (*stations)[i];
      const auto& c = (*counters)[i];
      nlohmann::ordered_json ports = nlohmann::json::array();
      for (std::size_t p = 0; p < c.ports.size(); ++p) {
        const auto& port = c.ports[p];
        const bool counted = (port.invalid_frames | port.rx_errors | port.forwarded | port.lost_links) != 0;
        if (!counted && !s.record.ports[p].open()) continue;
        ports.push_back({{"port", p},
                         {"invalid_frames", port.invalid_frames},
                         {"rx_errors", port.rx_errors},
                         {"forwarded", port.forwarded},
                         {"lost_links", port.lost_links}});
        if (!context.json)
          fmt::print("{:<18} {:>4} {:>8} {:>4} {:>10} {:>5}\n", title(*access, s), p, port.invalid_frames,
                     port.rx_errors, port.forwarded, port.lost_links);
      }
      all.push_back({{"position", s.record.position},
                     {"name", s.name()},
                     {"ports", ports},
                     {"processing_unit", c.processing_unit},
                     {"pdi", c.pdi}});
    }
    if (context.json) fmt::print("{}\n", nlohmann::ordered_json{{"result", "done"}, {"stations", all}}.dump(2));
  });
}

}  // namespace gantry::cli
