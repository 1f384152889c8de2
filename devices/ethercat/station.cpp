#include "devices/ethercat/station.hpp"

namespace gantry::devices {

const wire::SyncManager* find_sync_manager(const StationRecord& station, config::SyncManagerKind kind, int* number) {
  const auto& rows = station.profile().sync_managers;
  for (std::size_t i = 0; i < rows.size() && i < station.sync_managers.size(); ++i)
    if (rows[i].kind == kind) {
      if (number != nullptr) *number = static_cast<int>(i);
      return &station.sync_managers[i];
    }
  return nullptr;
}

bool StationRecord::has_mailbox() const {
  return find_sync_manager(*this, config::SyncManagerKind::MailboxOut, nullptr) != nullptr &&
         find_sync_manager(*this, config::SyncManagerKind::MailboxIn, nullptr) != nullptr;
}

}  // namespace gantry::devices
