#include "devices/ethercat/station.hpp"

#include <algorithm>

#include "devices/wire/coe.hpp"

namespace gantry::devices {

using namespace wire;
using config::SyncManagerKind;

namespace {

SyncManagerPlan mailbox_plan(SyncManagerKind kind, std::uint16_t start, std::uint16_t length) {
  const bool out = kind == SyncManagerKind::MailboxOut;
  return {{.start = start,
           .length = length,
           .control = out ? kSmControlMailboxOut : kSmControlMailboxIn,
           .activate = kSmActivateEnable},
          static_cast<std::uint8_t>(kind)};
}

std::vector<config::PdoRow> to_rows(const std::vector<SiiPdo>& pdos, std::vector<std::uint8_t>& sync_managers) {
  std::vector<config::PdoRow> rows;
  sync_managers.clear();
  for (const SiiPdo& pdo : pdos) {
    if (pdo.sync_manager == sii::kNoSyncManager) continue;  // not assigned by default
    config::PdoRow row{.index = pdo.index, .slot = 0, .entries = {}};
    for (const SiiPdoEntry& e : pdo.entries) row.entries.push_back({e.address, e.bit_length});
    rows.push_back(std::move(row));
    sync_managers.push_back(pdo.sync_manager);
  }
  return rows;
}

/// SyncManagers as the EEPROM has them; empty where it does not name all kinds that the profile needs.
std::vector<SyncManagerPlan> sync_managers_of(const StationSii& sii, const config::StationProfile& profile) {
  std::vector<SyncManagerPlan> plans;
  for (const SiiSyncManager& sm : sii.sync_managers) {
    SyncManagerPlan plan{{}, sm.type <= 4 ? sm.type : std::uint8_t{0}};
    const bool out = plan.is(SyncManagerKind::ProcessOut), in = plan.is(SyncManagerKind::ProcessIn);
    if (plan.is_mailbox()) {
      const bool from_us = plan.is(SyncManagerKind::MailboxOut);
      const std::uint16_t by_header_bytes = from_us ? sii.mailbox.out_bytes : sii.mailbox.in_bytes;
      plan = mailbox_plan(from_us ? SyncManagerKind::MailboxOut : SyncManagerKind::MailboxIn, sm.registers.start,
                          sm.registers.length != 0 ? sm.registers.length : by_header_bytes);
    } else if (out || in) {
      plan.registers.start = sm.registers.start;
      const std::uint8_t usual = out ? kSmControlOutputs : kSmControlInputs;
      constexpr std::uint8_t kModeAndDirection = 0x0F;
      const bool sane = (sm.registers.control & kModeAndDirection) == (usual & kModeAndDirection);
      plan.registers.control = sane ? sm.registers.control : usual;
    }
    plans.push_back(plan);
  }
  while (!plans.empty() && plans.back().kind == 0) plans.pop_back();
  for (const SyncManagerKind kind : {SyncManagerKind::MailboxOut, SyncManagerKind::MailboxIn,
                                     SyncManagerKind::ProcessOut, SyncManagerKind::ProcessIn}) {
    const auto ours = std::ranges::count(profile.sync_managers, kind, &config::SyncManagerRow::kind);
    const auto theirs = std::ranges::count_if(plans, [&](const auto& p) { return p.is(kind); });
    const bool nowhere = std::ranges::any_of(plans, [&](const auto& p) {
      return p.is(kind) && (p.registers.start == 0 || (p.is_mailbox() && p.registers.length == 0));
    });
    if (ours != theirs || nowhere) return {};
  }
  return plans;
}

/// The first operation mode of its EEPROM that has pulses. An EEPROM without modes does not say.
void take_clock_mode(StationRecord& s) {
  if (s.sii.dc_modes.empty()) return;
  constexpr std::uint16_t kCyclic = kDcActivateCyclic << 8;
  const auto mode = std::ranges::find_if(s.sii.dc_modes, [](const auto& m) { return (m.activate & kCyclic) != 0; });
  if (mode == s.sii.dc_modes.end()) {
    s.sync0 = false;
    return;
  }
  s.sync = {.activate = mode->activate,
            .cycle0_ns = mode->cycle0_ns,
            .factor0 = mode->factor0,
            .factor1 = mode->factor1,
            .shift0_ns = static_cast<std::int32_t>(mode->shift0_ns),
            .shift1_ns = static_cast<std::int32_t>(mode->shift1_ns)};
}

constexpr std::uint16_t kStrangerWatchdogMs = 100;  // the ESC's own power-on value

}  // namespace

const SyncManager* find_sync_manager(const StationRecord& station, SyncManagerKind kind, int* number) {
  const auto& plans = station.sync_managers;
  const auto at = std::find_if(plans.begin(), plans.end(), [&](const auto& p) { return p.is(kind); });
  if (at == plans.end()) return nullptr;
  if (number != nullptr) *number = static_cast<int>(at - plans.begin());
  return &at->registers;
}

bool StationRecord::has_mailbox() const {
  return find_sync_manager(*this, SyncManagerKind::MailboxOut, nullptr) != nullptr &&
         find_sync_manager(*this, SyncManagerKind::MailboxIn, nullptr) != nullptr;
}

/// A profile with a mailbox has CoE; of a stranger its EEPROM says whether it has.
bool StationRecord::has_coe() const { return has_mailbox() && (config != nullptr || sii.has_coe()); }

std::uint16_t pdo_assignment(const StationRecord& s, bool outputs) {
  int number = outputs ? 2 : 3;
  find_sync_manager(s, outputs ? SyncManagerKind::ProcessOut : SyncManagerKind::ProcessIn, &number);
  return static_cast<std::uint16_t>(object::kSyncManagerAssign0 + number);
}

void plan_from_profile(StationRecord& s, const config::StationProfile& profile) {
  s.title = profile.title;
  s.sync_managers = sync_managers_of(s.sii, profile);
  const bool eeprom_says = !s.sync_managers.empty();
  for (const auto& row : profile.sync_managers) {
    if (eeprom_says) break;
    const SiiMailbox& box = s.sii.mailbox;
    switch (row.kind) {
      case SyncManagerKind::MailboxOut:
        s.sync_managers.push_back(mailbox_plan(row.kind, box.exists() ? box.out_start : row.start,
                                               box.exists() ? box.out_bytes : row.length));
        break;
      case SyncManagerKind::MailboxIn:
        s.sync_managers.push_back(
            mailbox_plan(row.kind, box.exists() ? box.in_start : row.start, box.exists() ? box.in_bytes : row.length));
        break;
      case SyncManagerKind::ProcessOut:
        s.sync_managers.push_back(
            {{.start = row.start, .control = kSmControlOutputs}, static_cast<std::uint8_t>(row.kind)});
        break;
      case SyncManagerKind::ProcessIn:
        s.sync_managers.push_back(
            {{.start = row.start, .control = kSmControlInputs}, static_cast<std::uint8_t>(row.kind)});
        break;
    }
  }
  s.startup = profile.startup;
  s.rx_pdos = profile.rx_pdos;
  s.tx_pdos = profile.tx_pdos;
  s.rx_sync_managers.clear();
  s.tx_sync_managers.clear();
  s.writes_mapping = !profile.pdo_fixed && s.has_mailbox();
  s.max_pdo_entries = profile.max_pdo_entries;
  s.max_pdo_bytes = profile.max_pdo_bytes;
  s.watchdog_ms = profile.watchdog_ms;
  s.dc = s.sync0 = profile.dc;
  s.bent = false;
  s.outputs_fixed = s.inputs_fixed = {};
  s.slow.clear();
  s.foreign_outputs.clear();
  s.left_out.clear();
  s.sync = {};
  take_clock_mode(s);
}

void plan_from_sii(StationRecord& s) {
  s.title = !s.sii.name.empty() ? s.sii.name : s.sii.order;
  s.sync_managers.clear();
  for (const SiiSyncManager& sm : s.sii.sync_managers) {
    SyncManagerPlan plan{sm.registers, sm.type <= 4 ? sm.type : std::uint8_t{0}};
    if (plan.is_mailbox()) plan.registers.activate = kSmActivateEnable;
    s.sync_managers.push_back(plan);
  }
  if (!s.has_mailbox() && s.sii.mailbox.exists()) {  // no category, or an incomplete one: SM0 and SM1 by custom
    s.sync_managers.resize(std::max<std::size_t>(s.sync_managers.size(), 2));
    s.sync_managers[0] = mailbox_plan(SyncManagerKind::MailboxOut, s.sii.mailbox.out_start, s.sii.mailbox.out_bytes);
    s.sync_managers[1] = mailbox_plan(SyncManagerKind::MailboxIn, s.sii.mailbox.in_start, s.sii.mailbox.in_bytes);
  }
  s.startup.clear();
  s.rx_pdos = to_rows(s.sii.rx_pdos, s.rx_sync_managers);
  s.tx_pdos = to_rows(s.sii.tx_pdos, s.tx_sync_managers);
  s.writes_mapping = false;
  s.max_pdo_entries = s.max_pdo_bytes = 0;
  s.watchdog_ms = kStrangerWatchdogMs;
  s.dc = true;      // if its ESC has clocks
  s.sync0 = false;  // free run is the default; SYNC0 is asked for by a profile
  s.lrw = (s.sii.flags & sii::kFlagNoLrw) == 0;
}

}  // namespace gantry::devices
