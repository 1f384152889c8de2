#include "app/cli/bus_access.hpp"

#include <algorithm>
#include <charconv>
#include <fmt/format.h>

#include "devices/ethercat/master.hpp"
#include "devices/raw_socket_port.hpp"
#include "sim/segment/segment_port.hpp"

namespace gantry::cli {
namespace {

class WireBus final : public BusAccess {
 public:
  WireBus(config::Machine machine, std::unique_ptr<devices::RawSocketPort> wire)
      : BusAccess(std::move(machine)), wire_(std::move(wire)) {}
  devices::FramePort& port() override { return *wire_; }
  Clock& clock() override { return clock_; }
  Result<void> bring_up() override {
    return fail(Fault::Usage, "only the virtual segment is brought up here; for a real one: gantry run or gantry up");
  }

 private:
  std::unique_ptr<devices::RawSocketPort> wire_;
  MonotonicClock clock_;
};

class VirtualBus final : public BusAccess {
 public:
  explicit VirtualBus(config::Machine machine) : BusAccess(std::move(machine)) {}
  devices::FramePort& port() override { return port_; }
  Clock& clock() override { return clock_; }
  Result<void> bring_up() override { return devices::EthercatMaster(machine_, port_, clock_).bring_up(); }

 private:
  VirtualClock clock_;
  sim::Segment segment_{machine_, clock_};
  sim::SegmentPort port_{segment_, clock_};
};

std::optional<int> whole_number(std::string_view text) {
  int value = 0;
  const auto [end, problem] = std::from_chars(text.data(), text.data() + text.size(), value);
  return problem == std::errc{} && end == text.data() + text.size() ? std::optional(value) : std::nullopt;
}

}  // namespace

std::unique_ptr<BusAccess> BusAccess::open(Context& context, const BusOptions& options) {
  auto machine = load_machine(context);
  if (!machine) return nullptr;
  if (options.interface.empty()) return std::make_unique<VirtualBus>(std::move(*machine));
  auto wire = devices::RawSocketPort::open(options.interface);
  if (!wire) {
    context.exit_code = show(wire.error(), context.json);
    return nullptr;
  }
  return std::make_unique<WireBus>(std::move(*machine), std::move(*wire));
}

const config::Station* BusAccess::configured(const devices::FoundStation& found) const {
  for (const auto& station : machine_.stations) {
    if (station.bus != config::BusKind::EtherCat || station.position != found.record.position) continue;
    const auto& id = station.profile.identity;
    return id.vendor == found.record.sii.vendor && id.product == found.record.sii.product ? &station : nullptr;
  }
  return nullptr;
}

Result<int> BusAccess::find(std::span<const devices::FoundStation> stations, const std::string& wanted) const {
  const auto known = [&](int position) { return position >= 0 && position < static_cast<int>(stations.size()); };
  if (const auto position = whole_number(wanted); position && known(*position)) return *position;
  if (wanted.starts_with("alias:"))
    if (const auto alias = whole_number(std::string_view(wanted).substr(6)))
      for (const auto& s : stations)
        if (s.record.alias == *alias && *alias != 0) return s.record.position;
  std::string names;
  for (const auto& s : stations) {
    const auto* station = configured(s);
    if (station == nullptr) continue;
    if (station->name == wanted) return s.record.position;
    names += ", " + station->name;
  }
  for (const auto& station : machine_.stations)
    if (station.name == wanted && station.bus == config::BusKind::EtherCat)
      return fail(Fault::IdentityMismatch,
                  fmt::format("the machine file has '{}' at position {}, and another device, or none, stands there",
                              wanted, station.position),
                  "station " + wanted);
  return fail(Fault::Usage, fmt::format("no station '{}'; there are the positions 0 to {}{}; or write alias:NNN",
                                        wanted, static_cast<int>(stations.size()) - 1, names));
}

std::string title(const BusAccess& bus, const devices::FoundStation& found) {
  const auto* station = bus.configured(found);
  return station != nullptr ? fmt::format("{} '{}'", found.record.position, station->name)
                            : fmt::format("{} {}", found.record.position, found.name());
}

void add_bus_interface(CLI::App& verb, BusOptions& options) {
  verb.add_option("--interface", options.interface,
                  "Network interface with the stations; without it: the virtual segment of --machine, in this process");
}

}  // namespace gantry::cli
