// A bus of one drive and one output byte, for those who send the stop frame: 6040h at byte 26 of the frame, 607Ah at
// 28, outputs at 32, the first of them inverted.
#pragma once
#include <array>
#include <cstddef>

#include "app/cycle/stop_frame.hpp"
#include "tests/app/cycle/still_bus.hpp"
#include "tests/app/cycle/two_ends.hpp"

namespace gantry::test {

class OneDriveBus final : public StillBus {
 public:
  std::array<std::byte, 7> image{std::byte{0x0F}, std::byte{0x00}, std::byte{0x44}, std::byte{0x33},
                                 std::byte{0x22}, std::byte{0x11}, std::byte{0xFE}};

  [[nodiscard]] std::span<std::byte> outputs(StationId) noexcept override { return image; }
  [[nodiscard]] std::span<const std::byte> inputs(StationId) const noexcept override { return {}; }
  [[nodiscard]] bool fresh(StationId) const noexcept override { return true; }
  std::size_t spare_frames(std::span<const devices::ImageChange> changes,
                           std::span<devices::FrameBytes> frames) noexcept override {
    auto changed = image;
    for (const devices::ImageChange& change : changes) change.apply(changed);
    std::fill_n(frames[0].bytes.begin(), 60, std::byte{0xA5});
    std::copy(changed.begin(), changed.end(), frames[0].bytes.begin() + 26);
    frames[0].size = 60;
    return 1;
  }
};

struct OneDrive {
  static cycle::LoopSetup wiring() {
    cycle::LoopSetup setup;
    cycle::DriveSetup drive;
    drive.layout.controlword = {0};
    setup.drives.push_back(drive);
    for (const bool invert : {true, false}) {
      const std::uint8_t bit = invert ? 0 : 1;
      setup.outputs.push_back({bit, {}, 6, static_cast<std::uint8_t>(1u << bit), invert});
    }
    return setup;
  }
  /// What a loop does in a cycle, as far as its watchers can see.
  void beat(Time now) {
    stop.make(bus);
    stop.begin_exchange(now);
    stop.end_exchange();
  }
  /// Quick stop, target as commanded, output 0 off by a 1, output 1 off by a 0, the others as they are.
  static std::vector<std::byte> expected() {
    std::vector<std::byte> frame(60, std::byte{0xA5});
    const unsigned says[] = {0x02, 0x00, 0x44, 0x33, 0x22, 0x11, 0xFD};
    for (std::size_t i = 0; i < 7; ++i) frame[26 + i] = static_cast<std::byte>(says[i]);
    return frame;
  }

  TwoEnds wire;
  OneDriveBus bus;
  cycle::StopFrame stop{wiring(), wire.in()};
};

}  // namespace gantry::test
