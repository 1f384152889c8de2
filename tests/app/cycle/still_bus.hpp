// A fieldbus that has come up and does nothing: what the loop's parts see of it, a test adds.
#pragma once
#include "devices/bus.hpp"

namespace gantry::test {

class StillBus : public devices::FieldBus {
 public:
  Result<void> bring_up() override { return {}; }
  Result<void> request_operation() override { return {}; }
  Result<void> check_operation() override { return {}; }
  [[nodiscard]] Time first_cycle(Time t) const noexcept override { return t; }
  void shut_down() override {}
  Result<devices::Bytes> read_object(StationId, config::ObjectAddress) override { return devices::Bytes{}; }
  Result<void> write_object(StationId, config::ObjectAddress, std::span<const std::byte>) override { return {}; }
  devices::Exchange exchange(Time) noexcept override { return {}; }
  std::size_t spare_frames(std::span<const devices::ImageChange>, std::span<devices::FrameBytes>) noexcept override {
    return 0;
  }
};

}  // namespace gantry::test
