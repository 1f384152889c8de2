// The segment's port, with scripts between its frames.
#pragma once
#include "core/rt/trap.hpp"
#include "devices/passing_port.hpp"
#include "sim/machine/wiring.hpp"
#include "sim/segment/segment_port.hpp"

namespace gantry::sim {

class ScriptedPort final : public devices::PassingPort {
 public:
  ScriptedPort(SegmentPort& port, Wiring& wiring) : PassingPort(port), wiring_(wiring) {}
  bool send(devices::PortIndex port, std::span<const std::byte> frame) noexcept override {
    const rt::Outside world;  // scripts and the world are not held to the loop's rules
    wiring_.do_due();
    return port_.send(port, frame);
  }

 private:
  Wiring& wiring_;
};

}  // namespace gantry::sim
