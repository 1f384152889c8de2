#include "app/cycle/stop_frame.hpp"

#include <algorithm>

#include "devices/wire/cia402.hpp"

namespace gantry::cycle {

StopFrame::StopFrame(const LoopSetup& setup, int socket) noexcept : socket_(socket) {
  using devices::wire::cia402::kQuickStop;
  for (const DriveSetup& drive : setup.drives) {
    if (!drive.layout.controlword.mapped()) continue;
    const auto at = static_cast<std::uint16_t>(drive.layout.controlword.offset);
    changes_.push_back({drive.station, at, std::byte{0}, static_cast<std::byte>(kQuickStop & 0xFF)});
    changes_.push_back(
        {drive.station, static_cast<std::uint16_t>(at + 1), std::byte{0}, static_cast<std::byte>(kQuickStop >> 8)});
  }
  for (const BitPlace& bit : setup.outputs) {
    const auto mask = static_cast<std::byte>(bit.mask);
    changes_.push_back({bit.station, bit.byte, ~mask, bit.invert ? mask : std::byte{0}});
  }
}

void StopFrame::write_into(devices::FieldBus& bus) const noexcept {
  for (const devices::ImageChange& change : changes_) change.apply(bus.outputs(change.station));
}

void StopFrame::make(devices::FieldBus& bus) noexcept {
  const int next = ready_.load() == 0 ? 1 : 0;
  Buffer& b = buffers_[static_cast<std::size_t>(next)];
  b.count = bus.spare_frames({changes_.begin(), changes_.size()}, b.frames);
  if (b.count > 0) ready_.store(next);
}

}  // namespace gantry::cycle
