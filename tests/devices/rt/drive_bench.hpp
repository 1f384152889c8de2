// A drive's process image in a test's hands: inputs that the test sets, outputs that it looks at. Layout: as AMD530B.
#pragma once
#include <array>

#include "devices/rt/drive.hpp"

namespace gantry::devices {

struct DriveBench {
  std::array<std::byte, 9> outputs{};
  std::array<std::byte, 19> inputs{};
  DriveLayout layout;
  Drive drive;

  explicit DriveBench(double counts_per_unit = 2000, bool invert = false, DriveOptions options = {})
      : layout(make_layout()), drive(layout, AxisScale(counts_per_unit, invert), options) {
    status(0x0250);
    layout.mode_display.set(inputs, 8);
  }

  static DriveLayout make_layout() {
    DriveLayout l;
    l.controlword.offset = 0, l.mode.offset = 2, l.target.offset = 3, l.probe_function.offset = 7;
    l.statusword.offset = 0, l.mode_display.offset = 2, l.position.offset = 3, l.error_code.offset = 7;
    l.probe_status.offset = 9, l.probe_rising.offset = 11, l.digital_inputs.offset = 15;
    l.neg_limit_bit = 0, l.pos_limit_bit = 1, l.home_bit = 2, l.probe_level_bit = 7;
    l.codes.push_back({0x3210, Fault::DriveFault, false});
    l.codes.push_back({0x3220, Fault::Undervoltage, false});
    l.codes.push_back({0xFF23, Fault::DriveEmergencyInput, true});
    return l;
  }

  void status(int word) { layout.statusword.set(inputs, static_cast<std::uint16_t>(word)); }
  void position(std::int32_t counts) { layout.position.set(inputs, counts); }
  void mode(std::int8_t m) { layout.mode_display.set(inputs, m); }
  [[nodiscard]] std::uint16_t controlword() const { return layout.controlword.get(outputs); }
  [[nodiscard]] std::int32_t target() const { return layout.target.get(outputs); }

  Feedback cycle(const DriveCommand& command, bool fresh = true) {
    const Feedback f = drive.read(inputs, fresh);
    drive.write(outputs, command);
    return f;
  }
  /// From switch-on disabled to enabled, as a drive does that follows at once; the target stays where it is.
  void enable() {
    for (const int word : {0x0250, 0x0231, 0x0233, 0x1237}) {
      status(word);
      drive.read(inputs, true);
      drive.write(outputs, {.goal = DriveGoal::Enabled, .target = drive.commanded()});
    }
  }
};

}  // namespace gantry::devices
