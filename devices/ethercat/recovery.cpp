#include "devices/ethercat/recovery.hpp"

#include <fmt/format.h>

#include "devices/ethercat/identity_object.hpp"
#include "devices/ethercat/parameters.hpp"
#include "devices/ethercat/scan.hpp"
#include "devices/ethercat/sii.hpp"
#include "devices/ethercat/states.hpp"
#include "devices/ethercat/station_objects.hpp"
#include "devices/ethercat/station_registers.hpp"

namespace gantry::devices {
namespace {

using namespace wire;

constexpr std::uint16_t kWatchStation = 0x0FFF;  // address of a station whose identity is being asked

Result<void> enter(Link& link, const StationRecord& s, AlState state) {
  if (auto ok = request_state(link, s, state); !ok) return ok;
  return wait_for_state(link, s, state);
}

Result<bool> write_at_position(Link& link, int position, std::uint16_t reg, std::uint16_t value) {
  std::array<std::byte, 2> raw{};
  put_le<std::uint16_t>(raw, 0, value);
  const auto wkc = link.transact(Command::Apwr, physical_address(auto_increment(position), reg), raw);
  if (!wkc) return tl::unexpected(wkc.error());
  return *wkc == kWkcWrite;
}

/// A station that was being asked when the line broke has kept the address for that. Two of them would answer at once,
/// which reads like none.
Result<void> take_back_watch_address(Link& link) {
  std::array<std::byte, 2> none{};
  const auto wkc = link.transact(Command::Fpwr, physical_address(kWatchStation, reg::kStationAddress), none);
  if (!wkc) return tl::unexpected(wkc.error());
  return {};
}

/// Somebody without an address stands at the station's position: is it the station?
Result<Whereabouts> recognise(Link& link, StationRecord& s) {
  if (auto ok = take_back_watch_address(link); !ok) return tl::unexpected(ok.error());
  const auto named = write_at_position(link, s.position, reg::kStationAddress, kWatchStation);
  if (!named) return tl::unexpected(named.error());
  if (!*named) return Whereabouts::Gone;
  if (auto ok = take_eeprom(link, kWatchStation); !ok) return tl::unexpected(ok.error());
  const auto sii = read_station_sii(link, kWatchStation);
  if (!sii) return tl::unexpected(sii.error());
  std::array<std::byte, 2> alias{};
  const auto told = link.transact(Command::Fprd, physical_address(kWatchStation, reg::kStationAlias), alias);
  if (!told) return tl::unexpected(told.error());
  const bool alias_same = s.config == nullptr || s.config->alias == 0 || *told != kWkcRead ||
                          get_le<std::uint16_t>(alias, 0) == s.config->alias;
  const bool same =
      sii->vendor == s.sii.vendor && sii->product == s.sii.product && sii->serial == s.sii.serial && alias_same;
  const auto given = write_at_position(link, s.position, reg::kStationAddress, same ? s.address : std::uint16_t{0});
  if (!given) return tl::unexpected(given.error());
  if (!same)
    return fail(Fault::IdentityMismatch,
                fmt::format("another device stands where it was: vendor {:08X}h, product {:08X}h, serial {}, alias {} "
                            "instead of vendor {:08X}h, product {:08X}h, serial {}, alias {}",
                            sii->vendor, sii->product, sii->serial, get_le<std::uint16_t>(alias, 0), s.sii.vendor,
                            s.sii.product, s.sii.serial, s.config == nullptr ? 0 : s.config->alias),
                s.where);
  s.since_power_up = s.restarted = true;
  s.ignored.clear();
  return *given ? Whereabouts::Forgetful : Whereabouts::Gone;
}

}  // namespace

Result<Whereabouts> look_for(Link& link, StationRecord& s) {
  std::array<std::byte, 2> status{};
  const auto wkc = link.transact(Command::Fprd, physical_address(s.address, reg::kAlStatus), status);
  if (!wkc) return tl::unexpected(wkc.error());
  if (*wkc == kWkcRead) {
    const auto al = get_le<std::uint16_t>(status, 0);
    const auto state = static_cast<AlState>(al & kAlStateMask);
    if (state == AlState::Op && (al & kAlError) == 0) return Whereabouts::InOp;
    return state == AlState::SafeOp ? Whereabouts::Fallen : Whereabouts::Forgetful;
  }
  std::array<std::byte, 2> address{};
  const auto there =
      link.transact(Command::Aprd, physical_address(auto_increment(s.position), reg::kStationAddress), address);
  if (!there) return tl::unexpected(there.error());
  if (*there != kWkcRead) return Whereabouts::Gone;
  const auto found = get_le<std::uint16_t>(address, 0);
  // Another station of ours has moved up: the line is cut before the one we look for.
  if (found != 0 && found != kWatchStation) return Whereabouts::Gone;
  return recognise(link, s);
}

Result<void> replay(Link& link, StationRecord& s, const DcSetup& dc, std::uint16_t clock_source, Time cycle) {
  if (auto ok = reset_station(link, s); !ok) return ok;
  if (auto ok = wait_for_state(link, s, AlState::Init); !ok) return ok;
  s.mailbox = {.emergencies = std::move(s.mailbox.emergencies)};
  if (auto ok = write_mailbox_setup(link, s); !ok) return ok;
  if (auto ok = hand_over_eeprom(link, s); !ok) return ok;
  if (auto ok = enter(link, s, AlState::PreOp); !ok) return ok;
  if (auto ok = check_identity_object(link, s); !ok) return ok;
  if (auto ok = write_startup(link, s); !ok) return ok;
  if (auto ok = write_pdo_mapping(link, s); !ok) return ok;
  if (auto ok = set_first_mode(link, s); !ok) return ok;
  // The clock before process data: a reference clock is not asked for its time before it has the right one.
  if (auto ok = rejoin_clocks(link, s, dc, clock_source); !ok) return ok;
  if (auto ok = write_process_data(link, s); !ok) return ok;
  if (auto ok = start_sync0(link, std::span<const StationRecord>(&s, 1), dc, cycle); !ok) return ok;
  if (auto ok = enter(link, s, AlState::SafeOp); !ok) return ok;
  return enter(link, s, AlState::Op);
}

Result<void> pick_up(Link& link, const StationRecord& s) {
  if (auto ok = acknowledge(link, s); !ok) return ok;
  return enter(link, s, AlState::Op);
}

}  // namespace gantry::devices
