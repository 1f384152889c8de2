// The virtual stations' EEPROM interface: accesses of any kind to 0500h-050Fh, and an EEPROM that holds anything when
// the station starts again. Input: accesses of kind and station, offset, length, bytes.
#include "tests/fuzz/segment_bench.hpp"

using namespace gantry;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static fuzz::SegmentBench line{"devices/aio4.yaml", "devices/dio16.yaml"};
  fuzz::Input in(data, size);
  line.renew();
  for (int accesses = 0; accesses < 16 && !in.empty(); ++accesses) {
    const unsigned kind = in.u8(), station = kind >> 4 & 1;
    const StationId id{static_cast<std::uint16_t>(station)};
    const unsigned offset = in.u8() % 16u;
    const auto bytes = in.take(1 + in.u8() % 16u);
    switch (kind & 7) {
      case 0:  // write a word: address, data, command
        if (bytes.size() >= 4) {
          line.write(station, 0x0508, bytes.first(2));
          line.poke(station, 0x0502, 0x81, 0x02, std::to_integer<int>(bytes[2]), std::to_integer<int>(bytes[3]) & 3, 0,
                    0);
        }
        break;
      case 1: {
        std::array<std::byte, 16> shown{};
        line.read(station, 0x0500 + offset, std::span(shown).first(bytes.size()));
        break;
      }
      case 2:
        line.segment.power_off(id);
        line.segment.power_on(id);
        break;
      case 3: line.poke(station, 0x0502, 0x00, 0x04); break;  // reload
      case 4: line.wait(microseconds(50) * static_cast<int>(bytes.size())); break;
      case 5: line.bring_up(devices::wire::AlState::PreOp); break;  // a station without its EEPROM refuses
      default: line.write(station, 0x0500 + offset, bytes); break;
    }
  }
  return 0;
}
