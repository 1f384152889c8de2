// The wires between the segment's terminals and the world: where the motors are and which outputs are on go there, the
// probe's contact and the inputs come back.
//   Wiring wiring(machine, segment, world);   segment.set_world(&wiring);
#pragma once
#include <cstdint>
#include <vector>

#include "config/machine.hpp"
#include "sim/segment/segment.hpp"
#include "sim/world/world.hpp"

namespace gantry::sim {

class Wiring final : public WorldHook {
 public:
  Wiring(const config::Machine& machine, Segment& segment, World& world);

  /// Puts the motors where they stood in the last life.
  void recall(const std::vector<double>& values);
  /// Records where the motors are, when that has changed.
  void keep();

  void on_sync(std::uint64_t cycle, Time now) noexcept override;
  /// What scripts do to the bus, between frames: the segment is not touched while it calls the world.
  void do_due();

 private:
  struct Drive {
    AxisId axis;
    int drive;
  };
  struct InputStation {
    StationId station;
    std::uint16_t bits = 0;
  };
  std::vector<InputStation>::iterator find(StationId station);
  [[nodiscard]] std::uint32_t outputs() const;
  [[nodiscard]] bool clamp_commanded() const;
  void set_inputs(std::uint32_t inputs);

  const config::Machine& machine_;
  Segment& segment_;
  World& world_;
  std::vector<Drive> drives_;
  std::vector<double> kept_;  ///< position and count zero of each drive
  std::vector<config::WordBit> output_bits_, input_bits_;
  std::vector<InputStation> input_stations_;
  std::vector<BusAction> due_;
};

}  // namespace gantry::sim
