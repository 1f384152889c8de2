#include "app/cycle/stop_frame.hpp"

#include <algorithm>

#include "devices/wire/cia402.hpp"

namespace gantry::cycle {
namespace {

using devices::wire::cia402::kEnableOperationCommand;
using devices::wire::cia402::kHalt;
using devices::wire::cia402::kQuickStop;

// In homing the missing start bit and the halt bit stop the drive; in CSP they say nothing (iD286 10.1, AMD530B 6.4.1,
// STD402EC 11.1), and it stands at its target.
constexpr std::uint16_t kStand = kEnableOperationCommand | kHalt;

}  // namespace

StopFrame::StopFrame(const LoopSetup& setup, int socket) noexcept : socket_(socket) {
  for (std::size_t d = 0; d < setup.drives.size(); ++d) {
    const DriveSetup& drive = setup.drives[d];
    if (!drive.layout.controlword.mapped()) continue;
    const auto at = static_cast<std::uint16_t>(drive.layout.controlword.offset);
    words_.push_back({1u << d, changes_.size()});
    changes_.push_back({drive.station, at, std::byte{0}, static_cast<std::byte>(kQuickStop & 0xFF)});
    changes_.push_back(
        {drive.station, static_cast<std::uint16_t>(at + 1), std::byte{0}, static_cast<std::byte>(kQuickStop >> 8)});
  }
  for (const ImageBit& bit : setup.outputs) {
    if ((setup.held_mask >> bit.word_bit & 1u) != 0) continue;
    const auto mask = static_cast<std::byte>(bit.mask);
    changes_.push_back({bit.station, bit.byte, ~mask, bit.invert ? mask : std::byte{0}});
  }
}

void StopFrame::write_into(devices::FieldBus& bus) const noexcept {
  for (const devices::ImageChange& change : changes_) change.apply(bus.outputs(change.station));
}

void StopFrame::make(devices::FieldBus& bus, std::uint32_t standing) noexcept {
  standing_ = standing;
  for (const Word& word : words_) {
    const std::uint16_t says = (standing & word.drive) != 0 ? kStand : kQuickStop;
    changes_[word.at].set = static_cast<std::byte>(says & 0xFF);
    changes_[word.at + 1].set = static_cast<std::byte>(says >> 8);
  }
  const int next = ready_.load() == 0 ? 1 : 0;
  Buffer& b = buffers_[static_cast<std::size_t>(next)];
  b.count = bus.spare_frames({changes_.begin(), changes_.size()}, b.frames);
  if (b.count > 0) ready_.store(next);
}

}  // namespace gantry::cycle
