#include "devices/rt/canopen_cyclic.hpp"

#include "devices/wire/cia301.hpp"

namespace gantry::devices {

CanTick CanopenCyclic::tick(CanPort& port, Time now) noexcept {
  CanTick t;
  CanFrame frame;
  while (t.received < kFramesPerTick && port.receive(frame, now)) ++t.received;
  received_ += static_cast<std::uint64_t>(t.received);
  const CanFrame sync{.id = wire::cia301::kSync};
  failures_ = port.send(sync) ? 0 : failures_ + 1;
  if (failures_ >= kSendFailuresMax) t.fault = Fault::CanBusDown;
  return t;
}

}  // namespace gantry::devices
