// The virtual station's EEPROM interface: accesses of any kind to 0500h-050Fh, and an EEPROM that holds anything when
// the station starts again. Input: accesses of kind, offset, length, bytes.
#include "tests/fuzz/input.hpp"
#include "tests/fuzz/segment_bench.hpp"

using namespace gantry;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  fuzz::Input in(data, size);
  fuzz::SegmentBench line;
  for (int accesses = 0; accesses < 200 && !in.empty(); ++accesses) {
    const unsigned kind = in.u8(), station = kind >> 4 & 1;
    const auto adp = static_cast<std::uint16_t>(-static_cast<int>(station));
    const unsigned offset = in.u8() % 16u;
    const auto bytes = in.take(1 + in.u8() % 16u);
    switch (kind & 7) {
      case 0:  // write a word: address, data, command
        if (bytes.size() >= 4) {
          line.poke(station, 0x0508, std::to_integer<int>(bytes[0]), std::to_integer<int>(bytes[1]));
          line.poke(station, 0x0502, 0x81, 0x02, std::to_integer<int>(bytes[2]), std::to_integer<int>(bytes[3]) & 3, 0,
                    0);
        }
        break;
      case 1: line.datagram(1, adp, 0x0500 + offset, bytes); break;
      case 2:
        line.segment.power_off(StationId{static_cast<std::uint16_t>(station)});
        line.segment.power_on(StationId{static_cast<std::uint16_t>(station)});
        break;
      case 3: line.poke(station, 0x0502, 0x00, 0x04); break;  // reload
      case 4: line.clock.sleep_until(line.clock.now() + milliseconds(bytes.size())); break;
      default: line.write(station, 0x0500 + offset, bytes); break;
    }
  }
  return 0;
}
