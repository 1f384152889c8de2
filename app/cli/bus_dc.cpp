// gantry bus dc: the stations' clocks, how far they are apart, and what SYNC0 is set to.
#include <algorithm>
#include <cstdlib>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "app/cli/bus_access.hpp"
#include "app/cli/terminal.hpp"
#include "app/cli/usage.hpp"

namespace gantry::cli {
namespace {

struct Clocks {
  std::vector<devices::DcStatus> last;
  std::vector<std::int64_t> largest_ns;  ///< of the difference's magnitude, over all looks
};

/// One look, and others every 10 ms until `seconds` have passed.
Result<Clocks> watch(devices::Survey& survey, Clock& clock, double seconds) {
  constexpr Time kLook = milliseconds(10);
  Clocks seen;
  for (const Time end = clock.now() + Time{static_cast<std::int64_t>(seconds * 1e9)};;) {
    auto now = survey.dc_status();
    if (!now) return tl::unexpected(now.error());
    seen.last = std::move(*now);
    seen.largest_ns.resize(seen.last.size());
    for (std::size_t i = 0; i < seen.last.size(); ++i)
      seen.largest_ns[i] = std::max(seen.largest_ns[i], std::abs(std::int64_t{seen.last[i].difference_ns}));
    if (clock.now() + kLook > end) return seen;
    clock.sleep_until(clock.now() + kLook);
  }
}

}  // namespace

void add_bus_dc(CLI::App& bus, Context& context) {
  auto* verb = bus.add_subcommand("dc", "Distributed clocks: difference, delay, SYNC0 of every station");
  auto options = std::make_shared<BusOptions>();
  add_bus_interface(*verb, *options);
  auto seconds = std::make_shared<double>(0);
  verb->add_option("--watch", *seconds, "Look so many seconds, every 10 ms; `largest` is of that time")
      ->check(zero_or_more)
      ->check(CLI::Range(0.0, 86400.0));
  verb->footer(
      "difference: the station's clock minus the time that comes by (092Ch); within 1000 ns it is in step. Without a\n"
      "cycle nobody carries the time round, and clocks drift. The virtual segment is brought up first.");
  verb->callback([&context, options, seconds] {
    const auto access = BusAccess::open(context, *options);
    if (!access) return;
    if (access->is_virtual())
      if (auto up = access->bring_up(); !up) return void(context.exit_code = show(up.error(), context.json));
    devices::Survey survey(access->port(), access->clock());
    const auto stations = survey.scan();
    if (!stations) return void(context.exit_code = show(stations.error(), context.json));
    const auto seen = watch(survey, access->clock(), *seconds);
    if (!seen) return void(context.exit_code = show(seen.error(), context.json));
    const auto& clocks = seen->last;

    nlohmann::ordered_json all = nlohmann::json::array();
    if (!context.json)
      print_text("{:<18} {:>5} {:>13} {:>10} {:>9} {:>8} {:>10}\n", "station", "clock", "difference ns", "largest ns",
                 "delay ns", "SYNC0", "cycle us");
    for (std::size_t i = 0; i < clocks.size(); ++i) {
      const auto& s = (*stations)[i];
      const auto& c = clocks[i];
      all.push_back({{"position", s.record.position},
                     {"name", s.name()},
                     {"clock_bits", c.present ? (c.wide ? 64 : 32) : 0},
                     {"system_time_ns", c.system_time_ns},
                     {"difference_ns", c.difference_ns},
                     {"largest_difference_ns", seen->largest_ns[i]},
                     {"delay_ns", c.delay_ns},
                     {"sync0_active", (c.activation & 2) != 0},
                     {"sync0_cycle_ns", c.sync0_cycle_ns}});
      if (context.json) continue;
      if (!c.present)
        print_text("{:<18} {:>5}\n", title(*access, s), "none");
      else
        print_text("{:<18} {:>5} {:>13} {:>10} {:>9} {:>8} {:>10.1f}\n", title(*access, s), c.wide ? 64 : 32,
                   c.difference_ns, seen->largest_ns[i], c.delay_ns, (c.activation & 2) != 0 ? "on" : "off",
                   c.sync0_cycle_ns / 1000.0);
    }
    if (context.json) show_document("done", {{"stations", all}});
  });
}

}  // namespace gantry::cli
