// The master's reader of a station's EEPROM, which holds the input.
#include "devices/ethercat/sii.hpp"
#include "devices/ethercat/station.hpp"
#include "tests/fuzz/input.hpp"
#include "tests/fuzz/liar_port.hpp"

using namespace gantry;
using namespace gantry::devices;

namespace {

class SiiLiar final : public fuzz::LiarPort {
 public:
  SiiLiar(VirtualClock& clock, std::span<const std::byte> image) : LiarPort(clock), image_(image) {}

  bool answer(const wire::DatagramHeader& asked, std::span<std::byte> data) override {
    if (++asked_ > 20000) return false;
    const auto reg = static_cast<std::size_t>(asked.address >> 16);
    if (asked.command == wire::Command::Fpwr) {
      for (std::size_t i = 0; i < data.size(); ++i)
        if (reg + i >= 0x0504 && reg + i < 0x0508) address_[reg + i - 0x0504] = data[i];
      return true;
    }
    const std::size_t word = wire::get_le<std::uint32_t>(address_, 0);
    for (std::size_t i = 0; i < data.size(); ++i) {
      const std::size_t at = reg + i;
      data[i] = std::byte{0};
      if (at == 0x0502) data[i] = std::byte{0x40};
      if (at >= 0x0504 && at < 0x0508) data[i] = address_[at - 0x0504];
      if (at >= 0x0508 && at < 0x0510 && 2 * word + at - 0x0508 < image_.size())
        data[i] = image_[2 * word + at - 0x0508];
    }
    return true;
  }

 private:
  std::span<const std::byte> image_;
  std::array<std::byte, 4> address_{};
  int asked_ = 0;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  VirtualClock clock;
  SiiLiar port(clock, {reinterpret_cast<const std::byte*>(data), size});
  Link link(port, clock);
  (void)read_station_sii(link, 0x1001);
  (void)read_sii_image(link, 0x1001);
  // And the parser by itself, on a heap block of the exact size.
  const std::vector<std::byte> image(reinterpret_cast<const std::byte*>(data),
                                     reinterpret_cast<const std::byte*>(data) + size);
  if (const auto sii = parse_sii(image)) {
    StationRecord station;
    station.sii = *sii;
    plan_from_sii(station);
  }
  return 0;
}
