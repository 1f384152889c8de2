#include "devices/ethercat/states.hpp"

#include <fmt/format.h>

namespace gantry::devices {

using namespace wire;

namespace {
constexpr Time kBeforeNextAttempt = milliseconds(10);
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
                    fmt::format("refused {} {} times and stays in {}: AL status code {:04X}h, {}", name(state),
                                refusals, name(status->state), status->code, al_status_text(status->code)),
                    station.where);
      if (auto ok = acknowledge(link, station); !ok) return ok;
      link.pause(kBeforeNextAttempt);
      if (auto ok = request_state(link, station, state); !ok) return ok;
      link.pause(milliseconds(1));
      continue;
    }
    if (status->state == state) return {};
    if (link.clock().now() >= deadline)
      return fail(Fault::StateChangeRefused,
                  fmt::format("did not reach {} within {} s and stays in {} without an AL status code", name(state),
                              seconds(kStateTimeout), name(status->state)),
                  station.where);
    link.pause(milliseconds(1));
  }
}

}  // namespace gantry::devices
