#include "devices/ethercat/states.hpp"

#include <array>
#include <fmt/format.h>

namespace gantry::devices {

using namespace wire;

namespace {
constexpr Time kBeforeNextAttempt = milliseconds(10);

struct Remedy {
  std::uint16_t first, last;
  std::string_view text;
};
constexpr std::array kRemedies{
    Remedy{0x0011, 0x0012, "bring the bus up anew; if it stays, the station's firmware is at fault"},
    Remedy{0x0013, 0x0014, "load its firmware with the vendor's tool"},
    Remedy{0x0015, 0x0017, "compare `sync_managers` of its profile with the manual"},
    Remedy{0x0018, 0x0018, "check what feeds its inputs"},
    Remedy{0x0019, 0x0019, "outputs did not come: look at the network and the host (`gantry doctor`)"},
    Remedy{0x001A, 0x001A, "see `gantry bus dc` and the host's timing (`gantry doctor`)"},
    Remedy{0x001B, 0x001B,
           "look at the network and the host (`gantry doctor`), or state a longer `watchdog` in its profile"},
    Remedy{0x001C, 0x001C, "compare `sync_managers` of its profile with the manual"},
    Remedy{0x001D, 0x001E, "compare `sync_managers` and the PDOs of its profile with the manual"},
    Remedy{0x001F, 0x001F, "correct `watchdog` in its profile"},
    Remedy{0x0020, 0x0020, "switch its supply off and on"},
    Remedy{0x0021, 0x0023, "bring the bus up anew"},
    Remedy{0x0024, 0x0026, "compare `rx_pdos` and `tx_pdos` of its profile with the manual"},
    Remedy{0x0027, 0x0029, "correct `dc` in its profile by the manual"},
    Remedy{0x002A, 0x002B, "check its supply and wiring; if it stays, the station is at fault"},
    Remedy{0x002C, 0x002D, "see `gantry bus dc`, and whether its profile's `dc` is the manual's"},
    Remedy{0x002E, 0x002E, "take a longer `bus: cycle`, one of `cycle_times_us`"},
    Remedy{0x0030, 0x0034, "see `gantry bus dc`, and whether its profile's `dc` is the manual's"},
    Remedy{0x0035, 0x0037, "take a `bus: cycle` that the manual lists (`cycle_times_us`)"},
    Remedy{0x0041, 0x004F, "compare its mailbox in `sync_managers` with the manual; switch its supply off and on"},
    Remedy{0x0050, 0x0051, "write its EEPROM anew with the vendor's tool"},
    Remedy{0x0060, 0x0060, "bring the bus up anew; if it comes again, check its supply"},
    Remedy{0x0061, 0x0061,
           "its switches were turned since its supply came: set them as they were, or switch its supply off and on and "
           "state the `alias` that they give"},
};
}  // namespace

std::string_view remedy_of_al_code(std::uint16_t code) {
  for (const Remedy& r : kRemedies)
    if (code >= r.first && code <= r.last) return r.text;
  return "look the code up in the station's manual";
}

Result<AlStatus> read_al_status(Link& link, const StationRecord& station) {
  std::array<std::byte, 6> raw{};  // 0130h status, 0134h code
  if (auto ok = link.read(station.address, reg::kAlStatus, raw); !ok) return tl::unexpected(ok.error());
  const auto status = get_le<std::uint16_t>(raw, 0);
  return AlStatus{static_cast<AlState>(status & kAlStateMask), (status & kAlError) != 0, get_le<std::uint16_t>(raw, 4)};
}

std::string in_words(const AlStatus& status) {
  std::string words = fmt::format("in {}", name(status.state));
  if (status.code != 0) words += fmt::format(": AL status code {:04X}h, {}", status.code, al_status_text(status.code));
  return words;
}

Result<void> request_state(Link& link, const StationRecord& station, AlState state) {
  return link.write<std::uint16_t>(station.address, reg::kAlControl, static_cast<std::uint16_t>(state));
}

Result<void> acknowledge(Link& link, const StationRecord& station) {
  const auto status = read_al_status(link, station);
  if (!status) return tl::unexpected(status.error());
  return link.write<std::uint16_t>(station.address, reg::kAlControl,
                                   static_cast<std::uint16_t>(static_cast<std::uint16_t>(status->state) | kAlError));
}

Result<void> wait_for_state(Link& link, const StationRecord& station, AlState state) {
  const Time deadline = link.clock().now() + kStateTimeout;
  for (int refusals = 0;;) {
    const auto status = read_al_status(link, station);
    if (!status) return tl::unexpected(status.error());
    if (status->error) {
      if (++refusals == kStateAttempts)
        return fail(Fault::StateChangeRefused,
                    fmt::format("refused {} {} times and stays in {}: AL status code {:04X}h, {}; {}", name(state),
                                refusals, name(status->state), status->code, al_status_text(status->code),
                                remedy_of_al_code(status->code)),
                    station.where);
      if (auto ok = acknowledge(link, station); !ok) return ok;
      link.pause(kBeforeNextAttempt);
      if (auto ok = request_state(link, station, state); !ok) return ok;
      link.pause(milliseconds(1));
      continue;
    }
    if (status->state == state) return {};
    if (auto ok = link.goes_on(); !ok) return ok;
    if (link.clock().now() >= deadline)
      return fail(Fault::StateChangeRefused,
                  fmt::format("did not reach {} within {} s and stays in {} without an AL status code", name(state),
                              seconds(kStateTimeout), name(status->state)),
                  station.where);
    link.pause(milliseconds(1));
  }
}

}  // namespace gantry::devices
