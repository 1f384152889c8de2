// gantry bus scan: who is on the segment, connected how, in which state, with which process data and objects.
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "app/cli/bus_access.hpp"
#include "app/cli/terminal.hpp"

namespace gantry::cli {
namespace {

using nlohmann::ordered_json;
namespace wire = devices::wire;

std::string state_text(const devices::AlStatus& al) {
  std::string text(wire::name(al.state));
  if (al.error) text += fmt::format(" error {:04X}h, {}", al.code, wire::al_status_text(al.code));
  return text;
}

std::string open_ports(const devices::Ports& ports) {
  std::string text;
  for (std::size_t p = 0; p < ports.size(); ++p)
    if (ports[p].open()) text += static_cast<char>('0' + p);
  return text;
}

ordered_json to_json(const BusAccess& bus, const devices::FoundStation& s) {
  const auto* configured = bus.configured(s);
  const auto& r = s.record;
  ordered_json j{{"position", r.position},
                 {"name", s.name()},
                 {"configured_name", configured != nullptr ? ordered_json(configured->name) : ordered_json()},
                 {"vendor", r.sii.vendor},
                 {"product", r.sii.product},
                 {"revision", r.sii.revision},
                 {"serial", r.sii.serial},
                 {"alias", r.alias},
                 {"parent", r.parent},
                 {"parent_port", r.parent_port},
                 {"open_ports", open_ports(r.ports)},
                 {"state", std::string(wire::name(s.al.state))},
                 {"al_status_code", s.al.error ? ordered_json(s.al.code) : ordered_json()},
                 {"mailbox", r.sii.mailbox.exists()},
                 {"dc", (r.esc.features & wire::kFeatureDc) != 0}};
  if (!r.sii.damage.empty()) j["eeprom_damage"] = r.sii.damage;
  return j;
}

ordered_json to_json(const devices::PdoMap& map) {
  ordered_json out = ordered_json::array();
  for (const auto& pdo : map.pdos) {
    ordered_json entries = ordered_json::array();
    for (const auto& e : pdo.entries)
      entries.push_back({{"index", e.address.index}, {"sub", e.address.sub}, {"bits", e.bit_length}});
    out.push_back({{"pdo", pdo.index},
                   {"direction", pdo.outputs ? "outputs" : "inputs"},
                   {"sync_manager", pdo.sync_manager},
                   {"entries", entries}});
  }
  return out;
}

ordered_json to_json(const std::vector<devices::ObjectDescription>& objects) {
  ordered_json out = ordered_json::array();
  for (const auto& o : objects) {
    ordered_json entries = ordered_json::array();
    for (const auto& e : o.entries)
      entries.push_back({{"sub", e.address.sub}, {"name", e.name}, {"bits", e.bit_length}, {"access", e.access}});
    ordered_json one{{"index", o.index}, {"name", o.name}, {"entries", entries}};
    if (!o.refused.empty()) one["refused"] = o.refused;
    out.push_back(std::move(one));
  }
  return out;
}

void print(const devices::PdoMap& map) {
  for (const auto& pdo : map.pdos) {
    print_text("       {} {:04X}h SM{}:", pdo.outputs ? "out" : "in ", pdo.index, pdo.sync_manager);
    for (const auto& e : pdo.entries)
      if (e.address.index != 0)
        print_text(" {:04X}h{}/{}", e.address.index, e.address.sub != 0 ? fmt::format(":{}", e.address.sub) : "",
                   e.bit_length);
      else
        print_text(" gap/{}", e.bit_length);
    print_text("\n");
  }
}

void print(const std::vector<devices::ObjectDescription>& objects) {
  for (const auto& o : objects) {
    print_text("       {:04X}h {}\n", o.index, o.refused.empty() ? o.name : "not described: " + o.refused);
    for (const auto& e : o.entries)
      if (o.entries.size() > 1 || e.address.sub != 0)
        print_text("         :{:<3} {:<32} {:>3} bits\n", e.address.sub, e.name, e.bit_length);
  }
}

struct ScanOptions : BusOptions {
  bool objects = false;
};

Result<ordered_json> scan(BusAccess& bus, const ScanOptions& options, bool json) {
  devices::Survey survey(bus.port(), bus.clock());
  const auto stations = survey.scan();
  if (!stations) return tl::unexpected(stations.error());
  ordered_json all = ordered_json::array();
  if (!json)
    print_text("{:<18} {:>10} {:>10} {:>8} {:>5}  {:<6} {:<5} {:<3} {}\n", "station", "vendor", "product", "revision",
               "alias", "parent", "ports", "dc", "state");
  for (const auto& s : *stations) {
    const auto& r = s.record;
    ordered_json one = to_json(bus, s);
    if (!json) {
      print_text("{:<18} {:#010x} {:#010x} {:>8} {:>5}  {:<6} {:<5} {:<3} {}\n", title(bus, s), r.sii.vendor,
                 r.sii.product, r.sii.revision, r.alias, r.parent < 0 ? "master" : std::to_string(r.parent),
                 open_ports(r.ports), (r.esc.features & wire::kFeatureDc) != 0 ? "yes" : "no", state_text(s.al));
      if (!r.sii.damage.empty()) print_text("       EEPROM: {}\n", r.sii.damage);
    }
    // What one station refuses is told with it, and the others are asked all the same.
    const auto map = survey.read_pdo_map(r.position);
    if (!map && map.error().fault == Fault::BusDown) return tl::unexpected(map.error());
    one["pdos"] = map ? to_json(*map) : ordered_json::array();
    if (!map) one["pdos_missing"] = map.error().message;
    if (!json && map) print(*map);
    if (!json && !map) print_text("       no PDO map: {}\n", map.error().message);
    if (options.objects && map && r.sii.has_coe()) {
      const auto objects = survey.object_list(r.position, true);
      if (objects) {
        one["objects"] = to_json(*objects);
        if (!json) print(*objects);
      } else {  // many stations have no such list; the others still count
        one["objects_missing"] = objects.error().message;
        if (!json) print_text("       no list of objects: {}\n", objects.error().message);
      }
    }
    all.push_back(std::move(one));
  }
  return all;
}

}  // namespace

void add_bus_scan(CLI::App& bus, Context& context) {
  auto* verb = bus.add_subcommand("scan", "Stations: identity, ports, AL state, PDO map; objects with --objects");
  auto options = std::make_shared<ScanOptions>();
  add_bus_interface(*verb, *options);
  verb->add_flag("--objects", options->objects, "List the objects of each station, by its own word (SDO information)");
  verb->footer(
      "Stations in INIT are taken to PRE_OP to read their PDO map; nothing else changes.\n"
      "Example:  gantry bus scan --interface eth1 --objects");
  verb->callback([&context, options] {
    const auto access = BusAccess::open(context, *options);
    if (!access) return;
    const auto found = scan(*access, *options, context.json);
    if (!found) return void(context.exit_code = show(found.error(), context.json));
    if (context.json) show_document("done", {{"stations", *found}});
  });
}

}  // namespace gantry::cli
