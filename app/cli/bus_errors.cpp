// gantry bus errors: what the stations have counted at their ports; where a count grows, the cable in front is bad.
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "app/cli/bus_access.hpp"
#include "app/cli/terminal.hpp"
#include "app/record/summary.hpp"
#include "app/stations/fault_words.hpp"

namespace gantry::cli {
namespace {

std::string words(const devices::WireCheck& wire, int stations) {
  const devices::CyclicCounts& f = wire.frames;
  std::uint64_t repeats = 0;
  for (const std::uint32_t n : wire.mailbox_repeats) repeats += n;
  return fmt::format(
      "{} frames sent: {} lost, {} late, {} twice, {} of another master, {} changed on the way, {} back untouched\n"
      "working counter other than {}: fewer {} times, none {} times, more {} times; mailbox repeats: {}\n",
      f.sent, f.lost, f.late, f.duplicate, f.foreign, f.malformed, f.untouched, stations, f.wkc_low, f.wkc_zero,
      f.wkc_high, repeats);
}

}  // namespace

void add_bus_errors(CLI::App& bus, Context& context) {
  auto* verb = bus.add_subcommand("errors", "Error counters of every port, and what becomes of frames on the wire");
  auto options = std::make_shared<BusOptions>();
  add_bus_interface(*verb, *options);
  auto frames = std::make_shared<int>(200);
  verb->add_option("--frames", *frames, "How many frames are sent to see what becomes of them; 200 when left out")
      ->check(CLI::Range(1, 100'000));
  verb->footer(
      "invalid: frames with a wrong checksum; rx: symbols that are none; forwarded: errors that a station in front "
      "has\n"
      "seen already; lost: the link went away. Counters stop at 255. Look first at the port where `invalid` grows and\n"
      "`forwarded` does not: its cable or connector is the cause. Behind them what became of this verb's own frames. "
      "Of\n"
      "an owner that is up, `gantry --json status` has the same under `wire`.");
  verb->callback([&context, options, frames] {
    const auto access = BusAccess::open(context, *options);
    if (!access) return;
    devices::Survey survey(access->port(), access->clock());
    const auto stations = survey.scan();
    if (!stations) return void(context.exit_code = show(stations.error(), context.json));
    const auto counters = survey.error_counters();
    if (!counters) return void(context.exit_code = show(counters.error(), context.json));
    const auto wire = survey.check_wire(*frames);
    if (!wire) return void(context.exit_code = show(wire.error(), context.json));

    nlohmann::ordered_json all = nlohmann::json::array();
    if (!context.json)
      print_text("{:<18} {:>4} {:>8} {:>4} {:>10} {:>5}\n", "station", "port", "invalid", "rx", "forwarded", "lost");
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
          print_text("{:<18} {:>4} {:>8} {:>4} {:>10} {:>5}\n", title(*access, s), p, port.invalid_frames,
                     port.rx_errors, port.forwarded, port.lost_links);
      }
      all.push_back({{"position", s.record.position},
                     {"name", s.name()},
                     {"ports", ports},
                     {"mailbox_repeats", wire->mailbox_repeats[i]},
                     {"processing_unit", c.processing_unit},
                     {"pdi", c.pdi}});
    }
    const std::string other = wire->other_master ? stations::sender_words(wire->other_master->address) : "";
    if (context.json) {
      nlohmann::ordered_json on_the_wire{
          {"frames", record::to_json(wire->frames)},
          {"other_master", other.empty() ? nlohmann::ordered_json() : nlohmann::ordered_json(other)}};
      show_document("done", {{"stations", all}, {"wire", on_the_wire}});
      return;
    }
    print_text("\n{}", words(*wire, static_cast<int>(stations->size())));
    if (!other.empty()) print_text("another EtherCAT master sends on this line, {}\n", other);
  });
}

}  // namespace gantry::cli
