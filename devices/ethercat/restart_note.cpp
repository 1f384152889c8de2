#include "devices/ethercat/restart_note.hpp"

#include "devices/ethercat/parameters.hpp"

namespace gantry::devices {

Result<void> RestartNote::under(const std::function<Result<void>()>& write) {
  if (!station_.restart_pending) {
    station_.restart_pending = ours_ = true;
    if (auto kept = keep_(); !kept) {
      station_.restart_pending = ours_ = false;
      return kept;
    }
  }
  auto written = write();
  if (written || !is_refusal(written.error())) needed_ = true;
  if (!written && !is_refusal(written.error()))
    written.error().message +=
        "; whether it has the value is not known, so that the axes stay without torque until its supply was off and on";
  return written;
}

Result<void> RestartNote::settle() {
  if (!ours_ || needed_) return {};
  station_.restart_pending = ours_ = false;
  return keep_();
}

}  // namespace gantry::devices
