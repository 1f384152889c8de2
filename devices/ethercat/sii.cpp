#include "devices/ethercat/sii.hpp"

#include <fmt/format.h>

#include "devices/wire/sii.hpp"

namespace gantry::devices {
namespace {

using namespace wire;

constexpr Time kBusyTimeout = milliseconds(100);
constexpr Time kBusyPoll = microseconds(200);

/// Waits until the EEPROM interface is idle; its control word.
Result<std::uint16_t> wait_idle(Link& link, std::uint16_t station) {
  const Time deadline = link.clock().now() + kBusyTimeout;
  for (;;) {
    const auto control = link.read<std::uint16_t>(station, reg::kSiiControl);
    if (!control || (*control & kSiiBusy) == 0) return control;
    if (link.clock().now() >= deadline) return fail(Fault::SiiInvalid, "the SII EEPROM stays busy");
    link.pause(kBusyPoll);
  }
}

}  // namespace

Result<std::uint32_t> read_sii(Link& link, std::uint16_t station, std::uint16_t word) {
  if (auto idle = wait_idle(link, station); !idle) return tl::unexpected(idle.error());
  std::array<std::byte, 6> order{};  // control and address in one write
  put_le<std::uint16_t>(order, 0, kSiiRead);
  put_le<std::uint32_t>(order, 2, word);
  if (auto ok = link.write(station, reg::kSiiControl, std::span<const std::byte>(order)); !ok)
    return tl::unexpected(ok.error());
  const auto control = wait_idle(link, station);
  if (!control) return tl::unexpected(control.error());
  // The checksum flag tells of the first words at start-up, which an empty EEPROM fails; reading still works.
  if ((*control & (kSiiErrors & ~kSiiChecksumError)) != 0)
    return fail(Fault::SiiInvalid,
                fmt::format("the SII EEPROM reports an error (0502h = {:04X}h) at word {:04X}h", *control, word));
  return link.read<std::uint32_t>(station, reg::kSiiData);
}

Result<StationSii> read_station_sii(Link& link, std::uint16_t station) {
  StationSii s;
  std::uint32_t mailbox_out = 0, mailbox_in = 0;
  for (const auto& [word, value] :
       {std::pair{sii::kVendor, &s.vendor}, std::pair{sii::kProduct, &s.product},
        std::pair{sii::kRevision, &s.revision}, std::pair{sii::kSerial, &s.serial},
        std::pair{sii::kMailboxOutStart, &mailbox_out}, std::pair{sii::kMailboxInStart, &mailbox_in}}) {
    const auto got = read_sii(link, station, word);
    if (!got) return tl::unexpected(got.error());
    *value = *got;
  }
  s.mailbox_out_start = static_cast<std::uint16_t>(mailbox_out & 0xFFFF);
  s.mailbox_out_bytes = static_cast<std::uint16_t>(mailbox_out >> 16);
  s.mailbox_in_start = static_cast<std::uint16_t>(mailbox_in & 0xFFFF);
  s.mailbox_in_bytes = static_cast<std::uint16_t>(mailbox_in >> 16);
  return s;
}

}  // namespace gantry::devices
