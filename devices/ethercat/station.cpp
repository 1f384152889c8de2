#include "devices/ethercat/station.hpp"

#include <algorithm>

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

void plan_from_profile(StationRecord& s, const config::StationProfile& profile) {
  s.title = profile.title;
  s.sync_managers.clear();
  for (const auto& row : profile.sync_managers) {
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
